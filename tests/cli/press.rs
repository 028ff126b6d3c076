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
    refused(&["push", "--newtons", "5", "--hold", "x,z"], "axis `z` presses or moves already; leave it out");
    refused(&["wipe", "--newtons", "5", "--along", "x", "--hold", "x"], "axis `x` presses or moves already");
    refused(&["push", "--newtons", "5", "--hold", "x,rx,x"], "axis `x` is there twice");
}

#[test]
fn what_the_service_refuses_is_told_by_the_name_of_the_option() {
    let refused = |command: &[&str], option: &str| {
        let wipe: &[&str] = if command[0] == "wipe" { &["--along", "x"] } else { &[] };
        let arm = ["--robot", "panda", "--axis", "z", "--newtons", "5"];
        let with_default = |pair: &&[&str]| !command.contains(&pair[0]);
        let rest = arm.chunks(2).filter(with_default).flatten().copied();
        let arguments: Vec<&str> = command.iter().chain(wipe).copied().chain(rest).collect();
        let error = failure(&arguments);
        assert!(error.contains(&format!("error: {option}")), "{option} is not in {error}");
    };
    for (option, value) in [
        ("--lag-s", "nan"),
        ("--lag-s", "-0.01"),
        ("--period-s", "0"),
        ("--period-s", "-0.001"),
        ("--delay-periods", "65"),
        ("--newtons", "1e300"),
        ("--stiffest", "1"),
        ("--max-force", "0.1"),
        ("--robot", "nobody"),
    ] {
        refused(&["push", option, value], option);
        refused(&["wipe", option, value], option);
    }
    refused(&["wipe", "--speed", "1e300"], "--speed over --stroke-m");
    refused(&["wipe", "--stroke-m", "1e-200"], "--speed over --stroke-m");
    refused(&["wipe", "--stroke-m", "1e300"], "--stroke-m");
}

#[test]
fn a_service_tells_whether_it_knows_the_robot() {
    let server = Server::start();
    let robot = include_str!("../../api/examples/robot.json");
    ureq::post(format!("{}/v1/robots", server.url)).content_type("application/json").send(robot).unwrap();
    let name = serde_json::from_str::<serde_json::Value>(robot).unwrap()["name"].as_str().unwrap().to_owned();
    let push = ["push", "--robot", &name, "--axis", "x", "--newtons", "5", "--hold", "y"];
    assert!(failure(&push).contains("--server"));
    let body = success(&[&push[..], &["--server", &server.url]].concat());
    assert!(body.contains(&name), "{body}");
    // No session is left.
    assert!(server.get("/metrics").contains("sessions 0"));
}
