//! `revprio check`.

use crate::program::{Scratch, program, success};

const REQUEST: &str = "tests/cli/certificate/request.json";
const ANSWER: &str = "tests/cli/certificate/answer.json";

/// Runs `revprio check` and returns its exit status, standard output and standard error.
fn check(files: &[&str]) -> (Option<i32>, String, String) {
    let output = program(&[&["check"], files].concat()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn certificate_of_a_right_answer_holds() {
    let printed = success(&["check", REQUEST, ANSWER]);
    assert!(printed.ends_with("answers: 1, certificate does not hold: 0, cannot be read: 0\n"), "{printed}");
}

#[test]
fn changed_answer_is_refused() {
    let scratch = Scratch::new("check-changed");
    let answer = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/certificate/answer.json"));
    let changed =
        scratch.write("answer.json", &answer.unwrap().replace(r#""multiplier": 3.0"#, r#""multiplier": 3.000003"#));
    let (status, printed, errors) = check(&[REQUEST, &changed]);
    assert_eq!((status, errors.as_str()), (Some(1), ""), "{printed}");
    assert!(printed.starts_with("answer 1: the certificate does not hold: active\n"), "{printed}");
}

#[test]
fn unreadable_input_is_explained() {
    let (status, printed, errors) = check(&["no_such.json", ANSWER]);
    assert_eq!((status, printed.as_str()), (Some(2), ""));
    assert!(errors.contains("cannot be read") && !errors.contains("Traceback"), "{errors}");
    let (status, printed, errors) = check(&["rustfmt.toml", ANSWER]);
    assert_eq!((status, errors.as_str()), (Some(2), ""), "{printed}");
}

#[test]
fn missing_python_is_explained() {
    let output = program(&["check", REQUEST, ANSWER]).env("PATH", "").output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("Install Python") && errors.contains("revprio check --script"), "{errors}");
}

#[test]
fn script_is_printed_as_it_is_in_the_repository() {
    assert_eq!(success(&["check", "--script"]), include_str!("../../tools/check/check.py"));
}

#[test]
fn script_with_a_file_is_refused() {
    let (status, printed, errors) = check(&["--script", REQUEST]);
    assert_eq!((status, printed.as_str()), (Some(2), ""));
    assert!(errors.contains("'--script' cannot be used with"), "{errors}");
}

#[test]
fn help_names_inputs_python_and_exit_statuses() {
    let help = success(&["check", "--help"]);
    for words in [
        "Usage: revprio check REQUEST ANSWER\n       revprio check LINES\n       revprio check --script\n",
        "Python 3.11",
        "0  the certificates of all answers hold",
        "2  an input cannot be read",
    ] {
        assert!(help.contains(words), "no `{words}` in {help}");
    }
}
