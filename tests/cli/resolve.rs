//! `revprio`, its help, and `revprio resolve`.

use std::process::Stdio;

use crate::program::{failure, program, success, success_with_input};
use crate::serve::Server;

const EXAMPLE: &str = "api/examples/resolve.json";

#[test]
fn help_shows_every_command_and_examples() {
    let help = success(&["--help"]);
    for word in ["demo", "serve", "config", "completions", "simulate", "resolve", "stability", "Examples:", "--version"]
    {
        assert!(help.contains(word), "{word} is not in {help}");
    }
    for command in ["demo", "serve", "config", "completions", "simulate", "resolve", "stability"] {
        assert!(success(&[command, "--help"]).contains("Usage: revprio"), "{command}");
    }
    assert!(success(&["--version"]).starts_with("revprio "));
}

#[test]
fn unknown_command_is_refused_with_a_hint_to_help() {
    let output = program(&["fly"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--help"));
}

#[test]
fn stability_prints_the_margins() {
    let contact = ["stability", "--inertia", "15", "--damping", "150", "--environment-stiffness", "1e5"];
    let stable = success(&contact);
    assert!(stable.starts_with("stable, ") && stable.contains("largest lag           1."), "{stable}");
    let lagging = success(&[&contact[..], &["--lag-s", "0.005"]].concat());
    assert!(lagging.starts_with("unstable, "), "{lagging}");
}

#[test]
fn stability_prints_limits_of_the_search_and_loops_without_damping_as_they_are() {
    let printed = |more: &str| {
        let more: Vec<&str> = more.split(' ').collect();
        let text = success(&[&["stability", "--inertia", "15"], &more[..]].concat());
        text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect::<Vec<_>>().join("\n")
    };
    let undamped = "unstable, spectral radius 1\nlargest lag none\nlargest delay none\nsmallest damping B_d above 0\n";
    for environment in ["1e5", "0"] {
        let text = printed(&format!("--damping 0 --environment-stiffness {environment}"));
        assert!(text.starts_with(undamped), "{text}");
    }
    let damped = printed("--damping 0 --environment-stiffness 1e5 --environment-damping 1000");
    assert!(damped.starts_with("stable, ") && damped.contains("\nsmallest damping B_d 0\n"), "{damped}");
    let soft = printed("--damping 100 --environment-stiffness 1e-3");
    assert!(soft.starts_with("stable, spectral radius 1 - 1.0e-8\nlargest lag 1e8 ms\n"), "{soft}");
    assert!(soft.contains("\nlargest delay 64 periods or more\n"), "{soft}");
    let late = printed("--damping 150 --environment-stiffness 1e5");
    assert!(late.contains("largest lag 1.5 ms\nlargest delay 1 period\n"), "{late}");
}

#[test]
fn stability_refuses_a_lag_that_no_arm_has() {
    let loop_ =
        ["stability", "--inertia", "15", "--damping", "150", "--environment-stiffness", "1e5", "--lag-s", "1e9"];
    assert_eq!(failure(&loop_), "error: --lag-s: 1e9 s is out of range; give 0 to 10 s\n");
}

#[test]
fn stability_names_the_option_that_is_wrong() {
    let contact = ["stability", "--damping", "150", "--environment-stiffness", "1e5"];
    for (option, value) in
        [("--inertia", "0"), ("--inertia", "nan"), ("--lag-s", "inf"), ("--environment-inertia", "-1")]
    {
        let inertia = if option == "--inertia" { &[][..] } else { &["--inertia", "15"] };
        let output = program(&[&contact[..], inertia, &[option, value]].concat()).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(text.contains(option) && !text.contains("http://") && !text.contains("null"), "{text}");
    }
}

#[test]
fn answer_is_printed_as_text_and_as_json() {
    let table = success(&["resolve", EXAMPLE]);
    for part in
        ["velocity (rad/s, m/s)\nj1 ", "task `push`, rank 1", "task `rest`, rank 5", "solved by closed_form, optimal"]
    {
        assert!(table.contains(part), "{part} is not in {table}");
    }
    let answer: serde_json::Value = serde_json::from_str(&success(&["resolve", EXAMPLE, "--json"])).unwrap();
    let achieved = answer["tasks"][0]["achieved"][0].as_f64().unwrap();
    assert!((achieved - 0.05).abs() < 1e-9, "{achieved}");
}

#[test]
fn problem_is_read_from_standard_input() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/api/examples/resolve.json")).unwrap();
    assert_eq!(success_with_input(&["resolve", "-"], &text), success(&["resolve", EXAMPLE]));
}

#[test]
fn running_server_gives_the_same_answer() {
    let server = Server::start();
    assert_eq!(success(&["resolve", EXAMPLE, "--server", &server.url]), success(&["resolve", EXAMPLE]));
}

#[test]
fn errors_name_the_file_and_the_line() {
    assert!(failure(&["resolve", "no_such.json"]).contains("cannot read no_such.json"));
    assert!(
        failure(&["resolve", "rustfmt.toml"])
            .contains("rustfmt.toml: this is not a JSON value; strings stand in double quotes at line 1")
    );
    let message = failure(&["resolve", EXAMPLE, "--server", "http://127.0.0.1:9"]);
    assert!(message.contains("no answer from http://127.0.0.1:9/v1/resolve"), "{message}");
}

#[test]
fn problem_with_its_own_jacobian_needs_no_robot() {
    let problem = r#"{"tasks": [{"jacobian": [[2]], "velocity": [3]}]}"#;
    let answer: serde_json::Value =
        serde_json::from_str(&success_with_input(&["resolve", "-", "--json"], problem)).unwrap();
    assert!((answer["joint_velocity"][0].as_f64().unwrap() - 1.5).abs() < 1e-12);
}

#[test]
fn active_rows_and_contradictions_are_printed() {
    let table = success(&["resolve", "api/examples/resolve_bounds.json"]);
    assert!(table.contains("row 0 at its upper bound, multiplier 2.6"), "{table}");
    let problem = r#"{"tasks": [{"name": "fast", "jacobian": [[1]], "lower": [1]}],
        "inequalities": [{"kind": "joints", "name": "wall", "coefficients": [1], "upper": 0.5}]}"#;
    let table = success_with_input(&["resolve", "-"], problem);
    for part in ["the bounds of task `fast` cannot all be kept", "row 0 of task `fast` lower", "`wall` upper"] {
        assert!(table.contains(part), "{part} is not in {table}");
    }
}

#[test]
fn sentences_and_warnings_are_printed() {
    let task = |axis: &str| format!(r#"{{"axes": ["{axis}"], "velocity": [0.1]}}"#);
    let problem = format!(
        r#"{{"robot": "sawyer_dh", "joint_position": [0.3, -0.6, 0.2, 1.4, 0.1, 0.9, 0.0], "period_s": 0.01, "why": true,
            "method": "reverse_priority", "tasks": [{}, {}, {}]}}"#,
        task("x"),
        task("y"),
        task("rz")
    );
    let table = success_with_input(&["resolve", "-"], &problem);
    let answer: serde_json::Value =
        serde_json::from_str(&success_with_input(&["resolve", "-", "--json"], &problem)).unwrap();
    for sentence in answer["why"].as_array().unwrap().iter().chain(answer["warnings"].as_array().unwrap()) {
        assert!(table.contains(sentence.as_str().unwrap()), "{sentence} is not in {table}");
    }
    assert!(table.contains("warning: the method `reverse_priority`"), "{table}");
}

#[test]
fn closed_pipe_is_no_error() {
    let mut child = program(&["resolve", EXAMPLE]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[cfg(target_os = "linux")]
#[test]
fn full_standard_output_is_an_ordinary_error() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = program(&["resolve", EXAMPLE]).stdout(full).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && message.starts_with("error: cannot print"), "{message}");
}
