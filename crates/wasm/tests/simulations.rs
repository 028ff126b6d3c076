//! Interactive runs of the module, on this machine.

use std::thread::sleep;
use std::time::Duration;

use revprio_wasm::BrowserService;
use serde_json::{Value, json};

struct Page(BrowserService);

impl Page {
    fn new() -> Self {
        Self(BrowserService::new())
    }

    fn call(&mut self, method: &str, path: &str, body: &Value) -> (u16, Value) {
        let request = json!({"method": method, "path": path, "body": body}).to_string();
        let answer: Value = serde_json::from_slice(&self.0.answer_text(request.as_bytes())).unwrap();
        (u16::try_from(answer["status"].as_u64().unwrap()).unwrap(), answer["body"].clone())
    }

    /// Starts a run and returns its path.
    fn start(&mut self, paused: bool) -> String {
        let (status, scenario) = self.call("GET", "/v1/scenarios/stiff_wall", &Value::Null);
        assert_eq!(status, 200);
        let mut scenario = scenario;
        scenario["duration_s"] = json!(0.2);
        let request = json!({"scenario": scenario, "interactive": {"paused": paused, "speed": 20.0}});
        let (status, run) = self.call("POST", "/v1/simulations", &request);
        assert_eq!((status, &run["state"]), (202, &json!("running")), "{run}");
        format!("/v1/simulations/{}", run["id"].as_str().unwrap())
    }

    fn advance(&mut self, path: &str) -> Value {
        let (status, advanced) = self.call("POST", &format!("{path}/advance"), &Value::Null);
        assert_eq!(status, 200, "{advanced}");
        advanced
    }
}

#[test]
fn a_run_that_is_advanced_ends_with_metrics_and_all_samples() {
    let mut page = Page::new();
    let path = page.start(false);
    let (mut times, mut name) = (Vec::new(), Value::Null);
    while name != "end" {
        let advanced = page.advance(&path);
        name = advanced["name"].clone();
        let samples = advanced["frame"]["samples"].as_array().into_iter().flatten();
        times.extend(samples.map(|sample| sample["time_s"].as_f64().unwrap()));
        sleep(Duration::from_millis(1));
    }
    assert!(times.is_sorted() && times.len() > 5 && times.last().is_some_and(|time| *time > 0.19), "{times:?}");
    let (status, run) = page.call("GET", &path, &Value::Null);
    assert_eq!((status, &run["state"], &run["progress"]), (200, &json!("finished"), &json!(1.0)), "{run}");
    assert!(run["metrics"]["largest_joint_speed_rad_s"].as_f64().unwrap() > 0.0);
    assert_eq!(page.call("POST", &format!("{path}/control"), &json!({"paused": true})).0, 409);
    assert_eq!(page.call("DELETE", &path, &Value::Null).0, 204);
    assert_eq!(page.call("GET", &path, &Value::Null).0, 404);
}

#[test]
fn a_paused_run_computes_the_steps_that_are_commanded() {
    let mut page = Page::new();
    let path = page.start(true);
    assert_eq!(page.advance(&path)["frame"]["done"], json!(0));
    assert_eq!(page.advance(&path)["frame"], Value::Null, "nothing is new");
    assert_eq!(page.call("GET", &format!("{path}/cycle"), &Value::Null).0, 409);
    assert_eq!(page.call("POST", &format!("{path}/control"), &json!({"step": 3})).0, 200);
    assert_eq!(page.advance(&path)["frame"]["done"], json!(3));
    let (status, cycle) = page.call("GET", &format!("{path}/cycle"), &Value::Null);
    assert_eq!((status, &cycle["state"]["sequence"]), (200, &json!(2)));
    assert_eq!(page.call("POST", "/v1/step", &cycle).0, 200);
    assert_eq!(page.call("DELETE", &path, &Value::Null).0, 204);
    assert_eq!(page.advance(&path)["name"], "end");
}

#[test]
fn wrong_requests_are_refused_with_the_place() {
    let mut page = Page::new();
    let refused = |(status, problem): (u16, Value)| (status, problem["pointer"].as_str().unwrap_or("").to_owned());
    assert_eq!(
        refused(page.call("POST", "/v1/simulations", &json!({"scenario": "stiff_wall"}))),
        (422, "/interactive".to_owned())
    );
    assert_eq!(refused(page.call("POST", "/v1/simulations", &json!({"scenario": 1}))), (422, "/scenario".to_owned()));
    assert_eq!(refused(page.call("POST", "/v1/simulations/9/advance", &Value::Null)).0, 404);
    assert_eq!(refused(page.call("POST", "/v1/controllers/x/step", &json!({}))).0, 422);
    assert_eq!(refused(page.call("BREW", "/", &Value::Null)).0, 404);
    for text in ["", "{", "[]", "{\"method\": 1}", "\u{0}"] {
        let answer: Value = serde_json::from_slice(&page.0.answer_text(text.as_bytes())).unwrap();
        assert_eq!(answer["status"], 400, "{text:?}");
    }
}

#[test]
fn at_most_four_runs_are_open() {
    let mut page = Page::new();
    let paths: Vec<String> = (0..4).map(|_| page.start(true)).collect();
    let request = json!({"scenario": "stiff_wall", "interactive": {}});
    assert_eq!(page.call("POST", "/v1/simulations", &request).0, 503);
    page.call("DELETE", &paths[0], &Value::Null);
    assert_eq!(page.call("POST", "/v1/simulations", &request).0, 202);
}
