//! `revprio push` and `revprio wipe`

use crate::program::{failure, program, success};
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
fn axes_that_exclude_each_other_are_refused() {
    let refused = |arguments: &[&str], part: &str| {
        let error = failure(&[arguments, &["--robot", "panda", "--axis", "z"]].concat());
        assert!(error.contains(part), "{part} is not in {error}");
    };
    refused(&["wipe", "--newtons", "5", "--along", "z"], "along another axis");
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
        ("--max-force", "0.1"),
        ("--robot", "nobody"),
    ] {
        refused(&["push", option, value], option);
        refused(&["wipe", option, value], option);
    }
}

#[test]
fn sizes_that_no_arm_has_are_refused_with_option_value_unit_and_range() {
    let refused = |arguments: &str, message: &str| {
        let given: Vec<&str> = arguments.split(' ').collect();
        let error = failure(&[&given, &["--robot", "panda"][..]].concat());
        assert_eq!(error, format!("error: {message}\n"));
    };
    let sign = "the sign is the direction";
    for (newtons, shown) in [("-5000", "-5000"), ("1e300", "1e300"), ("1e-200", "1e-200"), ("0", "0"), ("nan", "NaN")] {
        let message = format!("--newtons: {shown} N is out of range; give 0.001 to 2000 N; {sign}");
        refused(&format!("push --axis z --newtons {newtons}"), &message);
        refused(&format!("wipe --axis z --along x --newtons {newtons}"), &message);
    }
    for (option, message) in [
        ("--approach-speed 1e9", "--approach-speed: 1e9 m/s is out of range; give 1e-5 to 2 m/s"),
        ("--approach-speed 1e-200", "--approach-speed: 1e-200 m/s is out of range; give 1e-5 to 2 m/s"),
        ("--stiffest 1e9", "--stiffest: 1e9 N/m is out of range; give 300 to 1e8 N/m"),
        ("--stiffest nan", "--stiffest: NaN N/m is out of range; give 300 to 1e8 N/m"),
        ("--max-force 1e5", "--max-force: 100000 N is out of range; give 0.001 to 10000 N"),
    ] {
        refused(&format!("push --axis z --newtons 5 {option}"), message);
    }
    for (option, message) in [
        ("--speed 0", "--speed: 0 m/s is out of range; give 1e-5 to 2 m/s"),
        ("--stroke-m 1e-200", "--stroke-m: 1e-200 m is out of range; give 0.0001 to 10 m; the sign is the direction"),
        ("--stroke-m -100", "--stroke-m: -100 m is out of range; give 0.0001 to 10 m; the sign is the direction"),
        ("--max-tilt-rad 9", "--max-tilt-rad: 9 rad is out of range; give 0.001 to 1.4 rad"),
    ] {
        refused(&format!("wipe --axis z --along x --newtons 5 {option}"), message);
    }
    let angular = "--stiffest: 1 N·m/rad is out of range; give 3 to 1e8 N·m/rad";
    refused("push --axis rz --newtons 1 --stiffest 1", angular);
}

#[test]
fn a_time_that_is_not_finite_is_refused_at_its_option() {
    let wipe = ["wipe", "--robot", "panda", "--axis", "z", "--newtons", "5", "--along", "x"];
    for option in ["--period-s", "--lag-s", "--start-time-s"] {
        for (value, shown) in [("nan", "NaN"), ("inf", "inf"), ("-inf", "-inf")] {
            let error = failure(&[&wipe[..], &[&format!("{option}={value}")]].concat());
            assert_eq!(error, format!("error: {option}: give a finite number, not {shown}\n"));
        }
    }
}

#[test]
fn a_tilt_around_an_axis_of_rotation_is_told_by_the_name_of_the_option() {
    let error = failure(&[
        "wipe",
        "--robot",
        "panda",
        "--axis",
        "rz",
        "--along",
        "x",
        "--newtons",
        "1",
        "--max-tilt-rad",
        "0.3",
    ]);
    assert!(error.starts_with("error: --max-tilt-rad: a task that follows the normal"), "{error}");
}

#[test]
fn a_warning_about_the_force_names_its_axis() {
    let push = ["push", "--robot", "panda", "--axis", "z", "--newtons", "15", "--max-force", "16"];
    let output = program(&push).output().unwrap();
    let warning = String::from_utf8(output.stderr).unwrap();
    assert!(warning.starts_with("warning: task `push`, axis z: `max_force` 16 is less than 1.2 times"), "{warning}");
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
