//! Bad input, row by row: what is changed in a good body, and the refusal that it gets.

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

/// Where a good body is changed (JSON pointer), the JSON text that stands there then, the status, the pointer of the
/// refusal.
type Row = (&'static str, &'static str, u16, &'static str);

/// Instead of a text: the field is left out.
const LEFT_OUT: &str = "";

/// The refusal is about the text as a whole.
const NO_POINTER: &str = "none";

/// Sends every row, and holds that each gets its refusal and the service is none the worse.
fn assert_all_refused(service: &Service, path: &str, body: &Value, rows: &[Row]) {
    service.post(path, &body.to_string()).accepted();
    let flaws: Vec<String> = rows.iter().filter_map(|row| flaw(service, path, body, row)).collect();
    assert!(flaws.is_empty(), "{path}: {} of {} rows\n{}", flaws.len(), rows.len(), flaws.join("\n"));
    service.assert_alive();
    service.post(path, &body.to_string()).accepted();
}

fn flaw(service: &Service, path: &str, body: &Value, &(at, text, status, pointer): &Row) -> Option<String> {
    let pointer = Some(pointer).filter(|pointer| *pointer != NO_POINTER);
    let answer = service.post(path, &changed(body, at, text));
    answer.flaw(status, pointer).map(|flaw| format!("{at} = {text:.60}: {flaw}"))
}

/// The body as JSON text with `text` at `at`, which is replaced or added.
fn changed(body: &Value, at: &str, text: &str) -> String {
    let mut body = body.clone();
    let (parent, field) = at.rsplit_once('/').unwrap();
    match body.pointer_mut(parent).unwrap() {
        Value::Object(object) if text == LEFT_OUT => drop(object.remove(field).unwrap()),
        Value::Object(object) => drop(object.insert(field.to_owned(), "@".into())),
        Value::Array(list) => list[field.parse::<usize>().unwrap()] = "@".into(),
        other => panic!("{at} is inside {other}"),
    }
    body.to_string().replace(r#""@""#, text)
}
