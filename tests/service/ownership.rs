//! Owner tokens, idempotency keys, and clients that step the same session.

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;

use crate::harness::{Answer, Service, example};

const JSON: (&str, &str) = ("content-type", "application/json");

fn open(service: &Service, headers: &[(&str, &str)]) -> Answer {
    service.send("POST", "/v1/controllers", &[&[JSON], headers].concat(), &example("controller.json").to_string())
}

fn state(sequence: u64) -> Value {
    let mut state = example("state.json");
    (state["sequence"], state["time_s"]) = (json!(sequence), json!(0.001 * sequence as f64));
    state
}

fn step(service: &Service, session: &str, headers: &[(&str, &str)], sequence: u64) -> Answer {
    service.send("POST", &format!("{session}/step"), &[&[JSON], headers].concat(), &state(sequence).to_string())
}

#[test]
fn only_the_owner_steps_replaces_and_ends_a_session_with_an_owner() {
    let service = Service::start();
    let owner = ("revprio-owner", "robot-cell-7");
    let session = open(&service, &[owner]).location.unwrap();
    step(&service, &session, &[owner], 1).accepted();
    let change = |method: &str, headers: &[(&str, &str)]| {
        service.send(method, &session, &[&[JSON], headers].concat(), &example("controller.json").to_string())
    };
    for stranger in [&[][..], &[("revprio-owner", "robot-cell-8")], &[("revprio-owner", "robot-cell-77")]] {
        for refused in [step(&service, &session, stranger, 2), change("PUT", stranger), change("DELETE", stranger)] {
            refused.assert_refused(403, None);
            assert_eq!(refused.json()["type"], "/problems/owner");
        }
    }
    change("PUT", &[owner]).accepted();
    assert_eq!(step(&service, &session, &[owner], 2).accepted()["sequence"], 2);
    let shown = service.get(&session).text;
    assert!(!shown.contains("robot-cell"), "the token is a secret: {shown}");
    let twice = service.send("DELETE", &format!("{session}?revprio_owner=%C3"), &[owner], "");
    twice.assert_refused(400, None);
    assert_eq!(change("DELETE", &[owner]).status, 204);
    assert_eq!(service.get(&session).status, 404);
}

#[test]
fn a_stream_of_a_session_with_an_owner_needs_its_token_in_a_header_or_in_the_address() {
    let service = Service::start();
    let session = open(&service, &[("revprio-owner", "me")]).location.unwrap();
    let connect = |query: &str, header: Option<&str>| {
        let url = format!("{}{session}/stream{query}", service.url().replace("http", "ws"));
        let mut request = url.into_client_request().unwrap();
        header.map(|owner| request.headers_mut().insert("revprio-owner", owner.parse().unwrap()));
        tungstenite::client(request, service.connect()).is_ok()
    };
    assert!(connect("", Some("me")) && connect("?revprio_owner=me", None) && connect("?a=b&revprio_owner=me", None));
    assert!(!connect("", None) && !connect("?revprio_owner=you", None) && !connect("", Some("you")));
}

#[test]
fn a_session_without_owner_is_open_to_all() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    step(&service, &session, &[("revprio-owner", "me")], 1).accepted();
    step(&service, &session, &[], 2).accepted();
}

#[test]
fn the_same_key_opens_one_session() {
    let service = Service::start();
    let key = ("idempotency-key", "0b8a6f");
    let (first, again) = (open(&service, &[key]), open(&service, &[key]));
    assert_eq!((first.status, again.status, &first.location), (201, 201, &again.location));
    assert_eq!(first.text, again.text);
    assert_eq!(service.get("/v1/controllers").accepted()["controllers"].as_array().unwrap().len(), 1);
    assert_ne!(open(&service, &[("idempotency-key", "0b8a70")]).location, first.location);
    assert_ne!(open(&service, &[]).location, open(&service, &[]).location);
    service.delete(&first.location.clone().unwrap());
    assert_ne!(open(&service, &[key]).location, first.location);
}

#[test]
fn a_key_is_not_reused_for_another_request() {
    let service = Service::start();
    let key = ("idempotency-key", "0b8a6f");
    open(&service, &[key]);
    let mut other = example("controller.json");
    other["period_s"] = json!(0.002);
    let refused = service.send("POST", "/v1/controllers", &[JSON, key], &other.to_string());
    refused.assert_refused(422, None);
    assert_eq!(refused.json()["type"], "/problems/key-reused");
    open(&service, &[key, ("revprio-owner", "me")]).assert_refused(422, None);
}

#[test]
fn tokens_and_keys_that_are_not_words_are_refused() {
    let service = Service::start();
    let long = "a".repeat(129);
    for name in ["revprio-owner", "idempotency-key"] {
        for wrong in ["", "a b", "ä", long.as_str()] {
            open(&service, &[(name, wrong)]).assert_refused(400, None);
        }
        open(&service, &[(name, "a"), (name, "b")]).assert_refused(400, None);
    }
}

fn warnings(answer: &Answer) -> String {
    answer.accepted()["warnings"].to_string()
}

#[test]
fn two_clients_that_count_for_themselves_are_flagged() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    (100..103).for_each(|sequence| drop(step(&service, &session, &[], sequence).accepted()));
    step(&service, &session, &[], 5).assert_refused(409, Some("/sequence"));
    let flagged = warnings(&step(&service, &session, &[], 103));
    assert!(flagged.contains("two clients") && flagged.contains("Revprio-Owner"), "{flagged}");
    assert_eq!(warnings(&step(&service, &session, &[], 104)), "null");
}
