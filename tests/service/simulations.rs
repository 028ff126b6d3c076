//! Simulations and scenarios.

use std::io::Read;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

use revprio_api::Client;
use revprio_lab::simulator::recording::Format;
use revprio_lab::simulator::{CallMode, Scenario, run};
use serde_json::{Value, json};

use crate::harness::{LONG_DRAIN, Service, example};

/// Far more than every wait needs.
const TIMEOUT: Duration = Duration::from_mins(1);

/// Media types of traces that are also file formats.
const FILES: [(&str, Format); 4] = [
    ("text/csv", Format::Csv),
    ("application/x-ndjson", Format::JsonLines),
    ("application/vnd.apache.parquet", Format::Parquet),
    ("application/vnd.mcap", Format::Mcap),
];

/// Returns the path of a file for one test.
fn tempfile(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// Returns a scenario of 0.2 s.
fn short(service: &Service) -> Value {
    let mut scenario = service.get("/v1/scenarios/force_tracking").accepted();
    scenario["duration_s"] = json!(0.2);
    scenario
}

fn start(service: &Service, request: &Value) -> String {
    let answer = service.post("/v1/simulations", &request.to_string());
    assert_eq!(answer.status, 202, "{}", answer.text);
    let address = answer.location.clone().unwrap();
    assert_eq!(address, format!("/v1/simulations/{}", answer.accepted()["id"].as_str().unwrap()));
    address
}

/// Waits until the status of the run satisfies the condition.
fn until(service: &Service, address: &str, condition: impl Fn(&Value) -> bool) -> Value {
    let start = Instant::now();
    loop {
        let status = service.get(address).accepted();
        if condition(&status) {
            return status;
        }
        assert!(start.elapsed() < TIMEOUT, "{status}");
        sleep(Duration::from_millis(5));
    }
}

fn finished(service: &Service, address: &str) -> Value {
    until(service, address, |status| status["state"] == "finished")
}

fn is_running(status: &Value) -> bool {
    status["state"] == "running" && status["progress"].as_f64().unwrap() > 0.0
}

#[test]
fn a_run_of_the_service_equals_the_run_of_a_client() {
    let service = Service::start();
    let scenario = short(&service);
    let address = start(&service, &json!({"scenario": scenario, "solver": "qp"}));
    let status = finished(&service, &address);
    assert_eq!((&status["progress"], &status["periods"]), (&json!(1.0), &json!(200)));
    assert_eq!((&status["scenario"], &status["solver"]), (&json!("force_tracking"), &json!("qp")));
    assert!(status["metrics"]["peak_force_n"].as_f64().unwrap() > 0.0);

    let mut scenario: Scenario = serde_json::from_value(scenario).unwrap();
    scenario.controller.solver = revprio_api::wire::Solver::Qp;
    let recording =
        run(&scenario, &Client::new(&service.url()), CallMode::Stateless, |_| ControlFlow::Continue(())).unwrap();
    let scratch = tempfile(&format!("simulation-{}", std::process::id()));
    for (media_type, format) in FILES {
        let file = scratch.with_extension(format.ending());
        format.write_file(&recording, false, &file).unwrap();
        let expected = std::fs::read(&file).unwrap();
        let trace = service.exchange("GET", &format!("{address}/trace"), &[("accept", media_type)], &[]);
        assert_eq!(trace.headers()["content-type"], media_type);
        assert!(*trace.body() == expected, "{media_type}");
        std::fs::remove_file(file).unwrap();
    }
}

#[test]
fn a_trace_has_the_accepted_format() {
    let service = Service::start();
    let mut scenario = short(&service);
    // More than one piece.
    scenario["duration_s"] = json!(1.2);
    let address = start(&service, &json!({"scenario": scenario, "solver": "closed_form"}));
    finished(&service, &address);
    let trace = |headers: &[(&str, &str)]| service.exchange("GET", &format!("{address}/trace"), headers, &[]);

    let json = trace(&[("accept", "application/json")]);
    let json: Value = serde_json::from_slice(json.body()).unwrap();
    let samples = json["samples"].as_array().unwrap();
    assert_eq!((samples.len(), &json["period_s"], &json["method"]), (1200, &json!(0.001), &json!("reverse_priority")));
    assert_eq!(json["joint_names"].as_array().unwrap().len(), 7);

    let lines = trace(&[("accept", "application/x-ndjson")]);
    let lines: Vec<Value> = lines
        .body()
        .split(|byte| *byte == b'\n')
        .filter(|line| !line.is_empty())
        .map(|line| serde_json::from_slice(line).unwrap())
        .collect();
    assert_eq!(lines, *samples);

    let (plain, small) = (trace(&[]), trace(&[("accept-encoding", "gzip")]));
    assert_eq!(
        (&small.headers()["content-encoding"], &small.headers()["content-type"]),
        (&"gzip".parse().unwrap(), &"text/csv".parse().unwrap())
    );
    let mut unpacked = Vec::new();
    flate2::read::GzDecoder::new(small.body().as_slice()).read_to_end(&mut unpacked).unwrap();
    assert!(unpacked == *plain.body() && small.body().len() < plain.body().len());
    assert_eq!(std::str::from_utf8(plain.body()).unwrap().lines().count(), 1201);

    let refusal = trace(&[("accept", "application/x-hdf5")]);
    let problem: Value = serde_json::from_slice(refusal.body()).unwrap();
    assert_eq!(refusal.status(), 406);
    assert!(problem["detail"].as_str().unwrap().contains("`text/csv`"), "{problem}");
}

#[test]
fn events_show_the_progress_until_the_end() {
    let service = Service::start();
    let mut scenario = short(&service);
    scenario["duration_s"] = json!(2.0);
    let address = start(&service, &json!({"scenario": scenario}));
    let answer = service.get(&format!("{address}/events"));
    assert_eq!(answer.media_type, "text/event-stream");
    let field = |name: &'static str| answer.text.lines().filter_map(move |line| line.strip_prefix(name));
    let names: Vec<&str> = field("event: ").collect();
    let data: Vec<Value> = field("data: ").map(|text| serde_json::from_str(text).unwrap()).collect();
    assert!(names.len() > 1 && names.len() == data.len());
    assert!(
        names[..names.len() - 1].iter().all(|name| *name == "progress") && names.last() == Some(&"end"),
        "{names:?}"
    );
    let progress: Vec<f64> = data.iter().map(|status| status["progress"].as_f64().unwrap()).collect();
    assert!(progress.is_sorted() && progress.last() == Some(&1.0), "{progress:?}");
    assert_eq!(data.last(), Some(&service.get(&address).accepted()));
    assert_eq!(data.last().unwrap()["state"], "finished");
}

#[test]
fn delete_cancels_a_running_simulation_and_then_deletes_it() {
    let service = Service::start();
    let address = start(&service, &json!({"scenario": "force_tracking"}));
    until(&service, &address, is_running);
    service.get(&format!("{address}/trace")).assert_refused(409, None);
    assert_eq!(service.delete(&address).status, 204);
    let cancelled = service.get(&address).accepted();
    assert_eq!(cancelled["state"], "cancelled");
    sleep(Duration::from_millis(50));
    assert_eq!(service.get(&address).accepted(), cancelled);
    service.get(&format!("{address}/trace")).assert_refused(409, None);
    assert_eq!(service.delete(&address).status, 204);
    for answer in [service.get(&address), service.delete(&address), service.get(&format!("{address}/events"))] {
        answer.assert_refused(404, None);
    }
}

#[test]
fn simulations_wait_and_are_refused_above_the_quota() {
    let service = Service::start();
    // Many substeps: the run does not end before the test.
    let mut scenario = service.get("/v1/scenarios/force_tracking").accepted();
    scenario["substeps"] = json!(50);
    let long = json!({"scenario": scenario});
    let runs: Vec<String> = (0..12).map(|_| start(&service, &long)).collect();
    let refusal = service.exchange(
        "POST",
        "/v1/simulations",
        &[("content-type", "application/json")],
        long.to_string().as_bytes(),
    );
    assert_eq!((refusal.status().as_u16(), &refusal.headers()["retry-after"]), (503, &"1".parse().unwrap()));
    assert_eq!(service.get(&runs[11]).accepted()["state"], "queued");
    // The last run starts when the others are cancelled.
    runs[..11].iter().for_each(|run| assert_eq!(service.delete(run).status, 204));
    until(&service, &runs[11], is_running);
    // New runs replace cancelled ones, the oldest first.
    start(&service, &json!({"scenario": short(&service)}));
    start(&service, &long);
    service.get(&runs[0]).assert_refused(404, None);
    service.get(&runs[10]).accepted();
}

#[test]
fn a_run_that_diverges_fails_with_the_time_of_the_failure() {
    let service = Service::start();
    let mut scenario = short(&service);
    // An unstable loop without limits: soon the force is out of range.
    scenario["contacts"][0]["stiffness"] = json!(1e9);
    scenario["controller"]["limits"] = json!("none");
    let address = start(&service, &json!({"scenario": scenario}));
    let status = until(&service, &address, |status| status["state"] == "failed");
    assert!(status["error"].as_str().unwrap().contains("at t = "), "{status}");
    service.get(&format!("{address}/trace")).assert_refused(409, None);
}

#[test]
fn a_service_with_running_simulations_ends_promptly() {
    let service = Service::with_long_drain();
    let address = start(&service, &json!({"scenario": "force_tracking"}));
    until(&service, &address, is_running);
    let begin = Instant::now();
    drop(service);
    assert!(begin.elapsed() < LONG_DRAIN / 2, "{:?}", begin.elapsed());
}

#[test]
fn a_scenario_may_be_sent_as_message_pack() {
    let service = Service::start();
    let format = "application/msgpack";
    let scenario = service.exchange("GET", "/v1/scenarios/stiff_wall", &[("accept", format)], &[]);
    let scenario: Value = rmp_serde::from_slice(scenario.body()).unwrap();
    let request = rmp_serde::to_vec_named(&json!({"scenario": scenario})).unwrap();
    let started = service.exchange("POST", "/v1/simulations", &[("content-type", format)], &request);
    assert_eq!(started.status(), 202);
    let status: Value = rmp_serde::from_slice(started.body()).unwrap();
    assert_eq!(status["scenario"], "stiff_wall");
}

#[test]
fn the_example_is_started() {
    let service = Service::start();
    let address = start(&service, &example("simulation.json"));
    assert_eq!(service.get(&address).accepted()["solver"], "closed_form");
}

#[test]
fn wrong_simulations_are_refused_before_they_start() {
    let service = Service::start();
    let refused = |change: &dyn Fn(&mut Value), pointer: &str| {
        let mut request = json!({"scenario": short(&service)});
        change(&mut request);
        service.post("/v1/simulations", &request.to_string()).assert_refused(422, Some(pointer));
    };
    refused(&|r| r["scenario"] = json!("force_trackin"), "/scenario");
    refused(&|r| r["scenario"] = json!("fixtures/scenarios/stiff_wall.toml"), "/scenario");
    refused(&|r| r["scenario"] = json!(3), "/scenario");
    refused(&|r| r["scenario"] = json!([]), "/scenario");
    refused(&|r| r["method"] = json!("magic"), "/method");
    refused(&|r| r["bogus"] = json!(1), "/bogus");
    refused(&|r| r["scenario"]["bogus"] = json!(1), "/scenario/bogus");
    refused(&|r| r["scenario"]["duration_s"] = json!(100.1), "/scenario/duration_s");
    refused(&|r| r["scenario"]["duration_s"] = json!(1e308), "/scenario/duration_s");
    refused(&|r| r["scenario"]["duration_s"] = json!(-1), "/scenario/duration_s");
    refused(&|r| r["scenario"]["start_joint_position"] = json!([0]), "/scenario/start_joint_position");
    refused(&|r| r["scenario"]["velocity_loop"] = json!([0.0, 0]), "/scenario/velocity_loop");
    refused(&|r| r["scenario"]["velocity_loop"] = json!({"lag_s": -1}), "/scenario/velocity_loop/lag_s");
    refused(&|r| r["scenario"]["contacts"][0]["axis"] = json!("w"), "/scenario/contacts/0/axis");
    refused(&|r| r["scenario"]["contacts"][0]["stiffness"] = json!(-1), "/scenario/contacts/0/stiffness");
    refused(&|r| r["scenario"]["controller"]["robot"] = json!("puma"), "/scenario/controller/robot");
    refused(&|r| r["scenario"]["controller"]["period_s"] = json!(0), "/scenario/controller/period_s");
    refused(&|r| r["scenario"]["controller"]["tasks"] = json!([]), "/scenario/controller/tasks");
}

#[test]
fn scenarios_are_listed_and_shown_completely() {
    let service = Service::start();
    let list = service.get("/v1/scenarios").accepted();
    let list = list["scenarios"].as_array().unwrap();
    assert!(list.len() >= 4);
    for entry in list {
        let name = entry["name"].as_str().unwrap();
        assert_eq!(entry["scenario"], service.get(&format!("/v1/scenarios/{name}")).accepted());
        assert_eq!(entry["scenario"]["name"], name);
        assert_eq!(entry["robot"], entry["scenario"]["controller"]["robot"]);
        assert_eq!(entry["description"], entry["scenario"]["description"]);
        // A shown scenario can be sent back.
        let address = start(&service, &json!({"scenario": entry["scenario"]}));
        service.delete(&address);
    }
    service.get("/v1/scenarios/nothing").assert_refused(404, None);
    service.get("/v1/scenarios/..%2f..%2fCargo.toml").assert_refused(404, None);
}
