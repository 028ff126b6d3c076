//! Certificates of every method and solver, checked by `tools/check/check.py`, which shares no code with the solvers.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use revprio::service::{LocalService, Robots};
use serde_json::{Value, json};

use requests::{SOLVERS, examples, golden_requests, of_every_method_and_solver, random_request};

#[path = "../../crates/core/tests/resolution_properties/problems.rs"]
#[expect(dead_code, reason = "the tests of the core use all of it")]
mod problems;
mod requests;

/// Random problems of an ordinary run, each solved by every method and solver. `REVPRIO_CERTIFICATE_PROBLEMS` sets another number.
const PROBLEMS: u64 = 140;

/// Answers that are changed by 1e-6, each in some ten ways.
const CHANGED: &str = "100";

/// Returns the answer to a request, by the code of the service.
fn answer(request: &Value) -> Value {
    let service = LocalService::new(Robots::built_in());
    let body = service.call("POST", "/v1/resolve", request.to_string().as_bytes());
    let body = body.unwrap_or_else(|error| panic!("{request}: {error:?}"));
    serde_json::from_slice(&body).unwrap()
}

/// Returns requests with their answers.
fn solve(requests: Vec<Value>) -> Vec<Value> {
    requests.into_par_iter().map(|request| json!({"answer": answer(&request), "request": request})).collect()
}

/// Writes a line for each request and answer, and prints how many answers have which status.
fn write_lines<'a>(name: &str, pairs: impl IntoIterator<Item = &'a Value>) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let mut statuses: BTreeMap<&str, usize> = BTreeMap::new();
    let mut lines = String::new();
    for pair in pairs {
        *statuses.entry(pair["answer"]["solver"]["status"].as_str().unwrap()).or_default() += 1;
        writeln!(lines, "{pair}").unwrap();
    }
    println!("{name}: {statuses:?}");
    std::fs::write(&path, lines).unwrap();
    path
}

fn python(script: &str, path: &Path, arguments: &[&str]) -> Output {
    let script = format!("{}/tools/check/{script}", env!("CARGO_MANIFEST_DIR"));
    let output = Command::new("python3").arg(script).arg(path).args(arguments).output().unwrap();
    print!("{}", String::from_utf8_lossy(&output.stdout));
    output
}

/// Returns the number of certificates that do not hold.
fn wrong(path: &Path) -> usize {
    let output = python("check.py", path, &[]);
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(printed.ends_with("cannot be read: 0\n"), "{}", String::from_utf8_lossy(&output.stderr));
    printed.lines().filter(|line| line.contains("the certificate does not hold")).count()
}

#[test]
fn certificates_of_random_answers_hold_and_those_of_changed_ones_do_not() {
    let problems = std::env::var("REVPRIO_CERTIFICATE_PROBLEMS").ok();
    let problems =
        problems.map_or(PROBLEMS, |text| text.parse().expect("REVPRIO_CERTIFICATE_PROBLEMS is a whole number"));
    let requests = (0..problems).flat_map(|seed| of_every_method_and_solver(&random_request(seed)));
    let pairs = solve(requests.collect());
    assert!(pairs.len() >= 2000);
    for solver in SOLVERS {
        let own: Vec<&Value> = pairs.iter().filter(|pair| pair["request"]["solver"] == solver).collect();
        let certified = own.iter().filter(|pair| pair["answer"]["solver"]["status"] == "optimal").count();
        assert!(10 * certified > 9 * own.len(), "{solver}: only {certified} of {} answers are certified", own.len());
        let wrong = wrong(&write_lines(&format!("random-{solver}.jsonl"), own));
        assert_eq!(wrong, 0, "{solver}: {wrong} certificates do not hold");
    }
    let output = python("changes.py", &write_lines("random.jsonl", &pairs), &[CHANGED]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn certificates_of_golden_cases_hold() {
    let pairs = solve(golden_requests().iter().flat_map(of_every_method_and_solver).collect());
    assert_eq!(wrong(&write_lines("golden.jsonl", &pairs)), 0);
}

#[test]
fn certificates_of_examples_hold() {
    let pairs = solve(examples());
    assert!(pairs.len() >= 5);
    assert_eq!(wrong(&write_lines("examples.jsonl", &pairs)), 0);
}
