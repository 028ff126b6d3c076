//! Metrics, logs and probes for operators.

use std::time::Duration;

use revprio::service::ServiceConfig;
use serde_json::{Value, json};

use crate::harness::{Service, example};

/// Returns the value of a metric by its name with labels.
fn metric(service: &Service, name: &str) -> f64 {
    let text = service.get("/metrics").text;
    let value = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' ')?.parse().ok());
    value.unwrap_or_else(|| panic!("{name} is not in {text}"))
}

#[test]
fn requests_are_counted_by_route_and_status_not_by_what_clients_send() {
    let service = Service::start();
    let address = service.open(&example("controller.json"));
    service.call(&format!("{address}/step"), &example("state.json"));
    for path in ["/v1/robots/a", "/v1/robots/b"] {
        service.get(path).assert_refused(404, None);
    }
    for path in ["/x", "/y"] {
        service.get(path).assert_refused(404, None);
    }
    service.post("/v1/resolve", "{").assert_refused(400, None);
    for (name, value) in [
        (r#"revprio_requests_total{route="/v1/controllers/{id}/step",status="200"}"#, 1.0),
        (r#"revprio_requests_total{route="/v1/robots/{name}",status="404"}"#, 2.0),
        (r#"revprio_requests_total{route="none",status="404"}"#, 2.0),
        (r#"revprio_request_duration_seconds_count{route="/v1/resolve"}"#, 1.0),
        (r#"revprio_problems_total{type="malformed"}"#, 1.0),
        ("revprio_sessions", 1.0),
        ("revprio_panics_total", 0.0),
    ] {
        assert_eq!(metric(&service, name), value, "{name}");
    }
    assert!(metric(&service, "revprio_connections") >= 1.0);
    let answer = service.get("/metrics");
    assert!(answer.media_type.starts_with("application/openmetrics-text"), "{}", answer.media_type);
    assert!(answer.text.ends_with("# EOF\n"));
}

#[test]
fn solver_paths_statuses_and_iterations_are_counted() {
    let service = Service::start();
    let mut problem = example("resolve.json");
    service.call("/v1/resolve", &problem);
    problem["solver"] = json!("qp");
    let iterations = service.call("/v1/resolve", &problem)["solver"]["iterations"].as_f64().unwrap();
    assert!(iterations > 0.0);
    let solved = |path: &str| format!(r#"revprio_resolutions_total{{path="{path}",status="optimal"}}"#);
    assert_eq!(metric(&service, &solved("closed_form")), 1.0);
    assert_eq!(metric(&service, &solved("qp")), 1.0);
    assert_eq!(metric(&service, &solved("active_set")), 0.0);
    assert_eq!(metric(&service, "revprio_clarabel_iterations_total"), iterations);
    assert_eq!(metric(&service, "revprio_last_resorts_total"), 0.0);
}

#[test]
fn items_of_batches_and_messages_of_streams_count_like_requests() {
    let service = Service::start();
    let item = example("resolve.json");
    let mut wrong = item.clone();
    wrong["joint_position"] = json!([0]);
    service.call("/v1/resolve/batch", &json!({"items": [item, item, wrong]}));
    let session = service.open(&example("controller.json"));
    let request = service.url().replace("http", "ws") + &session + "/stream";
    let (mut stream, _) = tungstenite::client(request, service.connect()).unwrap();
    let mut call = |text: String| {
        stream.send(tungstenite::Message::text(text)).unwrap();
        stream.read().unwrap().into_text().unwrap()
    };
    let answer: Value = serde_json::from_str(&call(example("state.json").to_string())).unwrap();
    // The same state again is a retry, not a step.
    call(example("state.json").to_string());
    assert!(call("{".to_owned()).contains("/problems/malformed"));
    let path = |answer: &Value| answer["solver"]["path"].as_str().unwrap().to_owned();
    let (of_item, of_step) = (path(&service.call("/v1/resolve", &item)), path(&answer));
    let solved =
        |path: &str| metric(&service, &format!(r#"revprio_resolutions_total{{path="{path}",status="optimal"}}"#));
    if of_item == of_step {
        assert_eq!(solved(&of_item), 4.0);
    } else {
        assert_eq!((solved(&of_item), solved(&of_step)), (3.0, 1.0));
    }
    let route = "/v1/controllers/{id}/stream";
    for (name, value) in [
        (r#"revprio_problems_total{type="invalid"}"#.to_owned(), 1.0),
        (r#"revprio_problems_total{type="malformed"}"#.to_owned(), 1.0),
        ("revprio_clarabel_failures_total".to_owned(), 0.0),
        // The stream is still open. It was counted at its start.
        (format!(r#"revprio_requests_total{{route="{route}",status="101"}}"#), 1.0),
        (format!(r#"revprio_request_duration_seconds_count{{route="{route}"}}"#), 1.0),
    ] {
        assert_eq!(metric(&service, &name), value, "{name}");
    }
    assert!(metric(&service, &format!(r#"revprio_request_duration_seconds_sum{{route="{route}"}}"#)) < 0.1);
}

#[test]
fn a_late_step_is_counted_in_its_session_and_in_the_metrics() {
    let service = Service::start();
    let mut controller = example("controller.json");
    // The period is so long that only a sleep makes a step late.
    controller["period_s"] = json!(1.0);
    let address = service.open(&controller);
    let step = |sequence: u64| {
        let mut state = example("state.json");
        state["sequence"] = json!(sequence);
        service.call(&format!("{address}/step"), &state)
    };
    let missed = || service.get(&address).accepted()["missed_periods"].clone();
    step(1);
    std::thread::sleep(Duration::from_millis(1600));
    step(2);
    step(3);
    // A retry is not a step.
    step(3);
    assert_eq!(missed(), 1);
    assert_eq!(metric(&service, "revprio_missed_periods_total"), 1.0);
}

#[test]
fn every_answer_has_a_request_id() {
    let service = Service::start();
    let named = |id: &str| service.send("GET", "/v1/nothing", &[("x-request-id", id)], "");
    let answer = named("line-4:robot_2.a");
    assert_eq!(answer.header("x-request-id"), Some("line-4:robot_2.a"));
    assert_eq!(answer.json()["request_id"], "line-4:robot_2.a");
    answer.assert_refused(404, None);
    let long = "x".repeat(65);
    let mut made = Vec::new();
    for strange in ["", "two words", "\"quoted\"", "<b>", long.as_str()] {
        let answer = named(strange);
        let id = answer.header("x-request-id").unwrap().to_owned();
        assert_ne!(id, strange);
        assert_eq!(answer.json()["request_id"], id.as_str());
        made.push(id);
    }
    made.sort();
    made.dedup();
    assert_eq!(made.len(), 5, "the IDs are not unique: {made:?}");
    let answer = service.get("/healthz");
    assert!(answer.header("x-request-id").is_some());
    assert_eq!(answer.header("x-content-type-options"), Some("nosniff"));
}

#[test]
fn the_readiness_probe_is_answered() {
    let service = Service::start();
    let answer = service.get("/readyz");
    assert_eq!((answer.status, answer.text.as_str()), (200, "ready"));
}

#[test]
fn an_unknown_controller_is_refused_with_the_remedy() {
    let service = Service::start();
    let path = "/v1/controllers/00000000-0000-4000-8000-000000000000/step";
    let answer = service.post(path, &example("state.json").to_string());
    answer.assert_refused(404, None);
    let problem: Value = answer.json();
    assert_eq!(problem["type"], "/problems/unknown-controller");
    assert!(problem["detail"].as_str().unwrap().contains("create it again with POST /v1/controllers"), "{problem}");
}

#[test]
fn an_idle_session_ends() {
    let session_idle = Duration::from_millis(300);
    let service = Service::with(ServiceConfig { session_idle, max_sessions: 1, ..ServiceConfig::default() });
    let address = service.open(&example("controller.json"));
    service.post("/v1/controllers", &example("controller.json").to_string()).assert_refused(503, None);
    std::thread::sleep(session_idle);
    service.get(&address).assert_refused(404, None);
    assert_eq!(metric(&service, "revprio_sessions"), 0.0);
    service.open(&example("controller.json"));
}
