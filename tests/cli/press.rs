//! `revprio push` and `revprio wipe`

use crate::program::{failure, success};
use crate::serve::Server;

#[test]
fn a_service_accepts_what_the_commands_print() {
    let server = Server::start();
    let create = |arguments: &[&str]| {
        let body = success(arguments);
        let address = format!("{}/v1/controllers", server.url);
        let mut answer = ureq::post(address).content_type("application/json").send(&body).unwrap();
        assert_eq!(answer.status(), 201, "{}", answer.body_mut().read_to_string().unwrap());
        serde_json::from_str::<serde_json::Value>(&body).unwrap()
    };
    let arm = ["--robot", "panda", "--axis", "z", "--newtons", "-15"];
    let pushing = create(&[&["push"], &arm[..]].concat());
    assert_eq!(pushing["tasks"][1]["axes"], serde_json::json!(["x", "y", "rx", "ry", "rz"]));
    let more = ["--along", "y", "--stroke-m", "-0.2", "--hold", "rx,ry", "--max-force", "60", "--lag-s", "0.01"];
    let wiping = create(&[&["wipe"], &arm[..], &more[..]].concat());
    assert_eq!(wiping["tasks"][0]["law"]["max_force"], 60.0);
    assert_eq!(wiping["tasks"][2]["axes"], serde_json::json!(["rx", "ry"]));
    assert_eq!(wiping["drive"]["lag_s"], 0.01);
}

#[test]
fn numbers_without_a_meaning_are_refused() {
    let refused = |arguments: &[&str], part: &str| {
        let error = failure(&[arguments, &["--robot", "panda", "--axis", "z"]].concat());
        assert!(error.contains(part), "{part} is not in {error}");
    };
    refused(&["push", "--newtons", "0"], "the force must be finite and not 0");
    refused(&["push", "--newtons", "5", "--stiffest", "nan"], "stiffest contact must be finite and above 0");
    refused(&["wipe", "--newtons", "5", "--along", "z"], "along another axis");
    refused(&["wipe", "--newtons", "5", "--along", "x", "--speed", "0"], "the speed must be finite and above 0");
}
