//! Wrong input, as tables: the change in a correct body, and the expected problem.

mod controller;
mod kinematics;
mod protocol;
mod resolve;
mod robots;
mod simulations;
mod stability;
mod state;

use serde_json::Value;

use crate::harness::Service;

/// JSON pointer of the change in a correct body, new JSON text, expected status, expected pointer of the problem.
type Row = (&'static str, &'static str, u16, &'static str);

/// In the place of the JSON text: the field is omitted.
const OMITTED: &str = "";

/// The problem has no pointer.
const NO_POINTER: &str = "none";

/// Sends every row. Asserts that each gets its problem, and that the service still works.
fn assert_all_refused(service: &Service, path: &str, body: &Value, rows: &[Row]) {
    service.post(path, &body.to_string()).accepted();
    let differences: Vec<String> = rows.iter().filter_map(|row| difference(service, path, body, row)).collect();
    assert!(differences.is_empty(), "{path}: {} of {} rows\n{}", differences.len(), rows.len(), differences.join("\n"));
    service.assert_alive();
    service.post(path, &body.to_string()).accepted();
}

fn difference(service: &Service, path: &str, body: &Value, &(at, text, status, pointer): &Row) -> Option<String> {
    let pointer = Some(pointer).filter(|pointer| *pointer != NO_POINTER);
    let answer = service.post(path, &changed(body, at, text));
    answer.refusal_difference(status, pointer).map(|difference| format!("{at} = {text:.60}: {difference}"))
}

/// Returns the body as JSON text, with `text` at the pointer `at`.
fn changed(body: &Value, at: &str, text: &str) -> String {
    let mut body = body.clone();
    let (parent, field) = at.rsplit_once('/').unwrap();
    match body.pointer_mut(parent).unwrap() {
        Value::Object(object) if text == OMITTED => drop(object.remove(field).unwrap()),
        Value::Object(object) => drop(object.insert(field.to_owned(), "@".into())),
        Value::Array(list) => list[field.parse::<usize>().unwrap()] = "@".into(),
        other => panic!("{at} is inside {other}"),
    }
    body.to_string().replace(r#""@""#, text)
}
