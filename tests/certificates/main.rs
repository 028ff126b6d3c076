//! Certificates of every method and solver, checked by `tools/check/check.py`, which shares no code with the solvers.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::{Command, Output};

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use revprio::service::{LocalService, Robots};
use serde_json::{Value, json};

#[path = "../../crates/core/tests/resolution_properties/problems.rs"]
#[expect(dead_code, reason = "the tests of the core use all of it")]
mod problems;
mod requests;

/// Random problems, each solved by every method and solver: more than 10⁴ answers.
const PROBLEMS: u64 = 560;

/// Answers that are changed by 1e-6, each in some ten ways.
const CHANGED: &str = "100";

/// Returns the answer to a request, by the code of the service.
fn answer(request: &Value) -> Value {
    let service = LocalService::new(Robots::built_in());
    let body = service.call("POST", "/v1/resolve", request.to_string().as_bytes());
    let body = body.unwrap_or_else(|error| panic!("{request}: {error:?}"));
    serde_json::from_slice(&body).unwrap()
}

/// Writes a line with request and answer for each request, and prints how many answers are certified.
fn write_lines(name: &str, requests: Vec<Value>) -> (PathBuf, usize) {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let pairs: Vec<Value> =
        requests.into_par_iter().map(|request| json!({"answer": answer(&request), "request": request})).collect();
    let mut statuses: BTreeMap<String, usize> = BTreeMap::new();
    let mut file = std::io::BufWriter::new(std::fs::File::create(&path).unwrap());
    for pair in &pairs {
        let solver = pair["request"]["solver"].as_str().unwrap_or("auto");
        *statuses.entry(format!("{solver} {}", pair["answer"]["solver"]["status"])).or_default() += 1;
        writeln!(file, "{pair}").unwrap();
    }
    file.flush().unwrap();
    println!("{name}: {} answers, {statuses:?}", pairs.len());
    (path, pairs.len())
}

fn python(script: &str, arguments: &[&str]) -> Output {
    let script = format!("{}/tools/check/{script}", env!("CARGO_MANIFEST_DIR"));
    let output = Command::new("python3").arg(script).args(arguments).output().unwrap();
    print!("{}", String::from_utf8_lossy(&output.stdout));
    output
}

/// Asserts that the certificate of every answer holds.
fn assert_all_hold(path: &std::path::Path) {
    let output = python("check.py", &[path.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn random_lines() -> (PathBuf, usize) {
    let requests = (0..PROBLEMS).flat_map(|seed| requests::of_every_method_and_solver(&requests::random_request(seed)));
    write_lines("random.jsonl", requests.collect())
}

#[test]
fn certificates_of_random_answers_hold_and_those_of_changed_ones_do_not() {
    let (path, count) = random_lines();
    assert!(count >= 10_000);
    assert_all_hold(&path);
    let output = python("changes.py", &[path.to_str().unwrap(), CHANGED]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn certificates_of_golden_cases_hold() {
    let requests = requests::golden_requests();
    let requests = requests.iter().flat_map(requests::of_every_method_and_solver).collect();
    assert_all_hold(&write_lines("golden.jsonl", requests).0);
}

#[test]
fn certificates_of_examples_hold() {
    let (path, count) = write_lines("examples.jsonl", requests::examples());
    assert!(count >= 5);
    assert_all_hold(&path);
}
