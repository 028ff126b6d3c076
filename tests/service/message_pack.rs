//! MessagePack bodies give the same answers as JSON bodies.

use serde_json::{Value, json};

use crate::harness::{Service, example, without};

const MESSAGE_PACK: &str = "application/msgpack";

fn packed(value: &Value) -> Vec<u8> {
    rmp_serde::to_vec_named(value).unwrap()
}

/// Posts a body. Returns status, media type and value of the answer.
fn post(service: &Service, path: &str, headers: &[(&str, &str)], body: &[u8]) -> (u16, String, Value) {
    let answer = service.exchange("POST", path, headers, body);
    let media_type = answer.headers()["content-type"].to_str().unwrap().to_owned();
    let value = if media_type == MESSAGE_PACK {
        rmp_serde::from_slice(answer.body()).unwrap()
    } else {
        serde_json::from_slice(answer.body()).unwrap()
    };
    (answer.status().as_u16(), media_type, value)
}

#[test]
fn answers_in_both_formats_are_equal_to_the_last_bit() {
    let service = Service::start();
    for (path, file) in [
        ("/v1/resolve", "resolve.json"),
        ("/v1/step", "step.json"),
        ("/v1/stability", "stability.json"),
        ("/v1/kinematics", "kinematics.json"),
    ] {
        let body = example(file);
        let json = service.call(path, &body);
        let (status, media_type, value) = post(&service, path, &[("content-type", MESSAGE_PACK)], &packed(&body));
        assert_eq!((status, media_type.as_str()), (200, MESSAGE_PACK));
        let elapsed =
            |answer: Value| if answer.get("elapsed_us").is_some() { without(answer, &["elapsed_us"]) } else { answer };
        assert_eq!(elapsed(value), elapsed(json), "{path}");
    }
}

#[test]
fn message_pack_keeps_the_memory_of_a_controller() {
    let service = Service::start();
    let step = |request: &Value| post(&service, "/v1/step", &[("content-type", MESSAGE_PACK)], &packed(request)).2;
    let mut request = example("step.json");
    request["memory"] = step(&request)["memory"].clone();
    request["state"]["sequence"] = json!(18);
    let second = step(&request);
    assert_eq!(second["memory"]["sequence"], 18);
    assert_eq!(without(second, &["elapsed_us"]), without(service.call("/v1/step", &request), &["elapsed_us"]));
}

#[test]
fn a_session_may_be_used_in_both_formats() {
    let service = Service::start();
    let controller = packed(&example("controller.json"));
    let (status, media_type, created) =
        post(&service, "/v1/controllers", &[("content-type", MESSAGE_PACK)], &controller);
    assert_eq!((status, media_type.as_str()), (201, MESSAGE_PACK));
    let path = format!("/v1/controllers/{}/step", created["id"].as_str().unwrap());
    let in_json = service.call(&path, &example("state.json"));
    // The same state in the other format is a retry.
    let again = post(&service, &path, &[("content-type", MESSAGE_PACK)], &packed(&example("state.json"))).2;
    assert_eq!(again, in_json);
}

#[test]
fn the_answer_has_the_accepted_format() {
    let service = Service::start();
    let (json, binary) = (example("resolve.json").to_string().into_bytes(), packed(&example("resolve.json")));
    for (sent, body, accept, got) in [
        ("application/json", &json, MESSAGE_PACK, MESSAGE_PACK),
        ("application/json", &json, "*/*", "application/json"),
        (MESSAGE_PACK, &binary, "application/json", "application/json"),
        (MESSAGE_PACK, &binary, "*/*", MESSAGE_PACK),
        (MESSAGE_PACK, &binary, "application/msgpack;q=0.5, application/json", "application/json"),
        ("application/json", &json, "text/html", "application/json"),
    ] {
        let (_, media_type, _) = post(&service, "/v1/resolve", &[("content-type", sent), ("accept", accept)], body);
        assert_eq!(media_type, got, "{sent}, {accept}");
    }
    let robots = service.exchange("GET", "/v1/robots", &[("accept", MESSAGE_PACK)], &[]);
    let robots: Value = rmp_serde::from_slice(robots.body()).unwrap();
    assert_eq!(robots, service.get("/v1/robots").accepted());
}

/// Returns the example with another number in the place of 0.05, which occurs once.
fn with_number(value: f64) -> Vec<u8> {
    let mut bytes = packed(&example("resolve.json"));
    let at = bytes.windows(8).position(|window| window == 0.05_f64.to_be_bytes()).unwrap();
    bytes[at..at + 8].copy_from_slice(&value.to_be_bytes());
    bytes
}

#[test]
fn numbers_that_are_not_finite_are_refused_with_a_pointer() {
    let service = Service::start();
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let (status, media_type, problem) =
            post(&service, "/v1/resolve", &[("content-type", MESSAGE_PACK)], &with_number(value));
        assert_eq!((status, media_type.as_str()), (400, "application/problem+json"));
        assert_eq!(problem["pointer"], "/tasks/0/velocity/0");
    }
    let (status, _, problem) = post(&service, "/v1/resolve", &[("content-type", MESSAGE_PACK)], &with_number(1e308));
    assert_eq!((status, &problem["pointer"]), (422, &json!("/tasks/0/velocity/0")));
}

#[test]
fn message_pack_is_refused_like_json() {
    let service = Service::start();
    let good = example("resolve.json");
    let changed = |pointer: &str, value: Value| {
        let mut body = good.clone();
        *body.pointer_mut(pointer).unwrap() = value;
        body
    };
    let mut unknown = good.clone();
    unknown["bogus"] = json!(1);
    for body in [
        changed("/robot", json!("puma")),
        changed("/joint_position", json!([1, 2])),
        changed("/method", json!("magic")),
        changed("/tasks/0/velocity", json!("fast")),
        changed("/tasks/1", json!([])),
        unknown,
        json!([]),
        json!({}),
    ] {
        let in_json = service.post("/v1/resolve", &body.to_string()).json();
        let (status, media_type, problem) =
            post(&service, "/v1/resolve", &[("content-type", MESSAGE_PACK)], &packed(&body));
        assert_eq!((status, media_type.as_str()), (422, "application/problem+json"));
        assert_eq!(problem["pointer"], in_json["pointer"], "{body}");
        // Only JSON has lines and columns.
        let detail = in_json["detail"].as_str().unwrap();
        assert_eq!(problem["detail"], detail.split(" at line ").next().unwrap(), "{body}");
        for word in ["unknown variant", "unknown field", "missing field", "invalid type", "expected"] {
            assert!(!detail.contains(word), "{detail}");
        }
    }
}

/// In JSON such a body is refused, too.
#[test]
fn a_field_that_is_there_twice_is_refused() {
    let service = Service::start();
    let body = packed(&example("kinematics.json"));
    // A map of fewer than 16 entries has its length in the low four bits of its first byte.
    assert_eq!(body[0] & 0xf0, 0x80);
    let mut twice = vec![body[0] + 1];
    twice
        .extend(packed(&json!("robot")).into_iter().chain(packed(&json!("nonsense"))).chain(body[1..].iter().copied()));
    let (status, _, problem) = post(&service, "/v1/kinematics", &[("content-type", MESSAGE_PACK)], &twice);
    assert_eq!(status, 422, "{problem}");
    assert_eq!(problem["detail"], "give the field `robot` only once");
}

#[test]
fn truncated_and_extended_bytes_are_refused() {
    let service = Service::start();
    let good = packed(&example("resolve.json"));
    let status = |bytes: &[u8]| post(&service, "/v1/resolve", &[("content-type", MESSAGE_PACK)], bytes).0;
    assert_eq!(status(&good), 200);
    for end in (0..good.len()).step_by(13) {
        assert_eq!(status(&good[..end]), 400, "{end}");
    }
    assert_eq!(status(&[good, vec![0xc0]].concat()), 400);
    // A field by its index instead of its name.
    assert_eq!(status(&[0x81, 0x00, 0xa1, b'a']), 400);
    service.assert_alive();
}
