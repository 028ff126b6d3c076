//! `revprio simulate`

use std::process::Stdio;

use crate::program::{Scratch, failure, files, program, success};
use crate::serve::Server;
use crate::trace::Trace;

/// A built-in scenario with a shorter duration.
pub fn short(name: &str, duration: &str) -> String {
    let path = format!("{}/fixtures/scenarios/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let lines = text.lines().map(|line| if line.starts_with("duration_s") { duration } else { line });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn own_scenario_runs_against_a_server_and_writes_recording_figures_and_page() {
    let (scratch, server) = (Scratch::new("simulate"), Server::start());
    let file = scratch.write("mine.toml", &short("stiff_wall", "duration_s = 0.4"));
    let out = scratch.argument("out");
    let options = ["--method", "strict_reverse_priority", "--solver", "qp", "--server", &server.url, "--out", &out];
    let table = success(&[&["simulate", &file][..], &options].concat());
    assert!(table.contains("strict reverse priority") && table.contains("index.html"), "{table}");
    let files = files(&scratch.path().join("out"));
    assert!(files.contains(&"stiff_wall-strict_reverse_priority-qp.csv".to_owned()), "{files:?}");
    for ending in [".html", ".svg", ".png"] {
        assert!(files.iter().any(|name| name.ends_with(ending)), "no {ending} in {files:?}");
    }
    let trace = Trace::read(&scratch.path().join("out/stiff_wall-strict_reverse_priority-qp.csv"));
    assert_eq!(trace.rows(), 400);
    assert!(trace.words("path").iter().all(|path| path == "qp"));
}

#[test]
fn losses_and_faults_are_printed_for_the_law_contact_alone() {
    let scratch = Scratch::new("simulate_losses");
    let table = |name: &str, duration: &str| {
        let file = scratch.write("mine.toml", &short(name, duration));
        success(&["simulate", &file, "--in-process", "--out", &scratch.argument("out")])
    };
    let pressing = table("peg_edge", "duration_s = 6.0");
    let line = pressing.lines().find(|line| line.trim_start().starts_with("losses / faults"));
    assert!(line.is_some_and(|line| line.ends_with(" 1 / 0")), "{pressing}");
    assert!(!table("stiff_wall", "duration_s = 0.1").contains("losses / faults"));
}

#[test]
fn stateless_run_gives_the_same_recording() {
    let scratch = Scratch::new("stateless");
    let file = scratch.write("mine.toml", &short("force_tracking_singular", "duration_s = 0.3"));
    let trace = |out: &str, more: &[&str]| {
        success(&[&["simulate", &file, "--out", &scratch.argument(out)], more].concat());
        std::fs::read(scratch.path().join(out).join("force_tracking_singular-reverse_priority-auto.csv")).unwrap()
    };
    assert!(trace("session", &[]) == trace("stateless", &["--stateless"]), "the two traces differ");
}

/// Returns the number of answered steps of all sessions that a server reports.
fn steps(server: &Server) -> u64 {
    let text = ureq::get(format!("{}/metrics", server.url)).call().unwrap().body_mut().read_to_string().unwrap();
    let start = r#"revprio_requests_total{route="/v1/controllers/{id}/step",status="200"} "#;
    text.lines().find_map(|line| line.strip_prefix(start)).map_or(0, |count| count.parse().unwrap())
}

#[test]
fn table_has_the_number_of_requests_that_the_server_answered() {
    let (scratch, server) = (Scratch::new("simulate_requests"), Server::start());
    let file = scratch.write("mine.toml", &short("stiff_wall", "duration_s = 0.1"));
    let table = success(&["simulate", &file, "--server", &server.url, "--out", &scratch.argument("out")]);
    let line = table.lines().find(|line| line.trim_start().starts_with("requests")).unwrap();
    let count: u64 = line.split_whitespace().last().unwrap().parse().unwrap();
    assert_eq!(steps(&server), 100);
    // Two more open and close the session.
    assert_eq!(count, 102);
}

#[test]
fn run_in_the_process_gives_the_same_recording_without_requests() {
    let scratch = Scratch::new("simulate_in_process");
    let file = scratch.write("mine.toml", &short("stiff_wall", "duration_s = 0.4"));
    for more in [&["--solver", "auto"][..], &["--solver", "qp"], &["--stateless", "--solver", "auto"]] {
        let run = |out: &str, in_process: &[&str]| {
            let table = success(&[&["simulate", &file, "--out", &scratch.argument(out)], more, in_process].concat());
            let trace = format!("stiff_wall-reverse_priority-{}.csv", more.last().unwrap());
            (table.contains("requests"), std::fs::read(scratch.path().join(out).join(trace)).unwrap())
        };
        let ((has_requests, trace), (in_process_has, in_process)) = (run("http", &[]), run("own", &["--in-process"]));
        assert!(has_requests && !in_process_has);
        assert!(trace == in_process, "{more:?}");
    }
}

#[test]
fn in_process_is_explained_and_excludes_a_server() {
    for command in ["simulate", "compare"] {
        let help = success(&[command, "--help"]).split_whitespace().collect::<Vec<_>>().join(" ");
        for words in ["--in-process", "there are no requests", "are not measured", "the same to the last bit"] {
            assert!(help.contains(words), "no `{words}` in {help}");
        }
        let both = [command, "stiff_wall", "--in-process", "--server", "http://127.0.0.1:9"];
        let output = program(&both).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&output.stderr).contains("--in-process"));
    }
}

#[test]
fn errors_name_the_scenario_the_line_and_the_server() {
    let scratch = Scratch::new("simulate_failures");
    let known = failure(&["simulate", "stif_wall"]);
    assert!(known.contains("no scenario `stif_wall`; did you mean `stiff_wall`? known: force_tracking, "), "{known}");
    let far = failure(&["simulate", "nothing_like_it"]);
    assert!(far.contains("no scenario `nothing_like_it`; known: force_tracking, "), "{far}");
    assert!(failure(&["simulate", "no_such.toml"]).contains("cannot read no_such.toml"));
    let broken = scratch.write("broken.toml", &short("stiff_wall", "duration_s = = 1"));
    assert!(failure(&["simulate", &broken]).contains("line 5"));
    let misspelt = scratch.write("misspelt.toml", &short("stiff_wall", "duration = 1.0"));
    let message = failure(&["simulate", &misspelt]);
    let text = "there is no field `duration`; did you mean `duration_s`? known: `name`, ";
    assert!(message.contains("line 5") && message.contains(text), "{message}");
    let other = short("stiff_wall", "duration_s = 0.1").replacen("robot = \"sawyer_dh\"", "robot = \"sawer_dh\"", 1);
    let place = other.lines().position(|line| line.starts_with("robot = ")).unwrap() + 1;
    let refused = scratch.write("refused.toml", &other);
    for command in ["simulate", "compare"] {
        let message = failure(&[command, &refused]);
        assert!(message.contains(&format!("refused.toml, line {place}: ")) && message.contains("sawer"), "{message}");
    }
    let message = failure(&["simulate", "stiff_wall", "--server", "http://127.0.0.1:9"]);
    assert!(
        message.contains("no answer from http://127.0.0.1:9") && message.contains("is the service running"),
        "{message}"
    );
}

#[test]
fn no_directory_is_left_without_an_answer_of_the_service() {
    let scratch = Scratch::new("simulate_nobody");
    let out = scratch.argument("out");
    for command in ["simulate", "compare"] {
        let message = failure(&[command, "stiff_wall", "--server", "http://127.0.0.1:9", "--out", &out]);
        assert!(message.contains("is the service running"), "{message}");
        for (server, words) in
            [("https://127.0.0.1:8443", "TLS is not supported here"), ("nonsense", "http://127.0.0.1:8080")]
        {
            let output = program(&[command, "stiff_wall", "--server", server, "--out", &out]).output().unwrap();
            let message = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(2), "{message}");
            assert!(message.contains("--server") && message.contains(words), "{message}");
        }
        assert!(!std::path::Path::new(&out).exists());
    }
}

#[test]
fn a_reader_that_ends_early_is_no_error() {
    let scratch = Scratch::new("simulate_pipe");
    let file = scratch.write("mine.toml", &short("stiff_wall", "duration_s = 0.01"));
    for command in ["simulate", "compare"] {
        let out = scratch.argument(command);
        let mut run = program(&[command, &file, "--out", &out]);
        let mut run = run.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(run.stdout.take());
        let output = run.wait_with_output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && !message.contains("error"), "{message}");
        assert!(std::path::Path::new(&out).join("index.html").exists());
    }
}

#[test]
fn errors_of_the_service_are_printed() {
    let scratch = Scratch::new("simulate_refused");
    let text = short("stiff_wall", "duration_s = 0.1").replacen("inertia = [15.0]", "inertia = [-15.0]", 1);
    let message = failure(&["simulate", &scratch.write("heavy.toml", &text)]);
    assert!(message.contains("give an inertia from 1e-6") && message.contains("/tasks/0/law/inertia/0"), "{message}");
}

#[test]
fn unknown_method_is_refused_with_the_known_ones() {
    let output = program(&["simulate", "stiff_wall", "--method", "newton"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("reverse_priority"));
}

#[test]
fn error_names_an_output_directory_that_cannot_be_created() {
    let scratch = Scratch::new("simulate_out");
    let file = scratch.write("mine.toml", &short("stiff_wall", "duration_s = 0.01"));
    let taken = scratch.write("taken", "");
    assert!(failure(&["simulate", &file, "--out", &taken]).contains(&taken));
}
