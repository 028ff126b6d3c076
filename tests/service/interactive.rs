//! Interactive simulations: pausing, stepping, pushing, changing.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::harness::{Service, numbers};

/// Starts an interactive run of a scenario after `change`. Returns its path.
fn start(service: &Service, scenario: &str, change: impl FnOnce(&mut Value), paused: bool) -> String {
    let mut scenario = service.get(&format!("/v1/scenarios/{scenario}")).accepted();
    change(&mut scenario);
    let request = json!({"scenario": scenario, "interactive": {"speed": 1000, "paused": paused}});
    let answer = service.post("/v1/simulations", &request.to_string());
    assert_eq!(answer.status, 202, "{}", answer.text);
    answer.location.unwrap()
}

fn control(service: &Service, run: &str, command: &Value) -> Value {
    service.call(&format!("{run}/control"), command)
}

/// Reads the live view of a run.
struct Viewer(BufReader<TcpStream>);

impl Viewer {
    fn open(service: &Service, run: &str) -> Self {
        let mut stream = service.connect();
        write!(stream, "GET {run}/live HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n").unwrap();
        Self(BufReader::new(stream))
    }

    /// Returns name and data of the next event; `None` at the end.
    fn next(&mut self) -> Option<(String, Value)> {
        let (mut line, mut name) = (String::new(), String::new());
        while self.0.read_line(&mut line).unwrap() > 0 {
            if let Some(event) = line.strip_prefix("event: ") {
                event.trim().clone_into(&mut name);
            }
            if let Some(data) = line.strip_prefix("data: ") {
                return Some((name, serde_json::from_str(data).unwrap()));
            }
            line.clear();
        }
        None
    }

    /// Returns all frames up to the first that `fits`, including it.
    fn until(&mut self, fits: impl Fn(&Value) -> bool) -> Vec<Value> {
        let mut frames = Vec::new();
        while let Some((_, frame)) = self.next() {
            frames.push(frame);
            if fits(&frames[frames.len() - 1]) {
                return frames;
            }
        }
        panic!("none of {} frames fits", frames.len());
    }
}

/// Returns the samples of a whole run. It begins when somebody looks at it, because a run that has ended cannot be seen.
fn all_samples(service: &Service, scenario: &str, change: impl FnOnce(&mut Value)) -> Vec<Value> {
    let run = start(service, scenario, change, true);
    let mut viewer = Viewer::open(service, &run);
    viewer.next().unwrap();
    control(service, &run, &json!({"paused": false}));
    samples(&viewer.until(|frame| frame["run"]["state"] == "finished"))
}

fn samples(frames: &[Value]) -> Vec<Value> {
    frames.iter().flat_map(|frame| frame["samples"].as_array().unwrap().clone()).collect()
}

#[test]
fn a_paused_run_advances_by_steps_and_shows_each_of_them() {
    let service = Service::start();
    let run = start(&service, "stiff_wall", |_| (), true);
    let mut viewer = Viewer::open(&service, &run);
    let (name, first) = viewer.next().unwrap();
    service.get(&format!("{run}/cycle")).assert_refused(409, None);
    assert_eq!((name.as_str(), &first["done"], &first["samples"]), ("frame", &json!(0), &json!([])));
    let joints = first["arm"]["joints"].as_array().unwrap();
    assert_eq!(joints.len(), 7);
    assert!(joints.iter().all(|joint| joint["lower"].as_f64() < joint["upper"].as_f64()));

    control(&service, &run, &json!({"step": 5}));
    let frames = viewer.until(|frame| frame["done"] == 5);
    let times: Vec<f64> = samples(&frames).iter().map(|sample| sample["time_s"].as_f64().unwrap()).collect();
    assert_eq!(times, [0.0, 0.001, 0.002, 0.003, 0.004]);
    let last = frames.last().unwrap();
    let counts = |histogram: &Value| numbers(&histogram["counts"]).iter().sum::<f64>();
    assert_eq!((counts(&last["solve_time"]), counts(&last["round_trip"])), (5.0, 5.0));
    assert_eq!(last["paths"]["closed_form"], 5);
    assert_eq!(last["run"]["interactive"], json!({"speed": 1000.0, "paused": true}));

    // The shown cycle gives the shown answer.
    let cycle = service.get(&format!("{run}/cycle")).accepted();
    assert_eq!((&cycle["state"]["sequence"], &cycle["memory"]["sequence"]), (&json!(4), &json!(3)));
    let velocity = service.call("/v1/step", &cycle)["joint_velocity"].clone();

    // Nothing more happens before the next command.
    std::thread::sleep(Duration::from_millis(100));
    let status = control(&service, &run, &json!({"end": true}));
    // The period in which the run ends may already be over.
    assert!([json!(0.001), json!(0.0012)].contains(&status["progress"]), "{status}");
    let frames = viewer.until(|frame| frame["run"]["state"] == "finished");
    assert!(viewer.next().is_none());
    // The run ends one period after the command.
    assert_eq!(frames.last().unwrap()["done"], 6);
    let trace = service.exchange("GET", &format!("{run}/trace"), &[("accept", "application/json")], &[]);
    let trace: Value = serde_json::from_slice(trace.body()).unwrap();
    assert_eq!(trace["samples"].as_array().unwrap().len(), 6);
    assert_eq!(trace["samples"][4]["joint_velocity"], velocity);
}

#[test]
fn a_run_that_everybody_left_makes_room_for_a_new_one() {
    let service = Service::start();
    let run = || start(&service, "stiff_wall", |_| (), true);
    let left = run();
    let watched = [run(), run(), run()].map(|run| (Viewer::open(&service, &run), run));
    let scenario = service.get("/v1/scenarios/stiff_wall").accepted();
    let request = json!({"scenario": scenario, "interactive": {"paused": true}}).to_string();
    service.post("/v1/simulations", &request).assert_refused(503, None);
    std::thread::sleep(Duration::from_secs(6));
    let next = service.post("/v1/simulations", &request).location.unwrap();
    // The new one was not left alone for long, so the next one finds no room.
    service.post("/v1/simulations", &request).assert_refused(503, None);
    let state = |run: &String| service.get(run).accepted()["state"].clone();
    // Its thread ends the run.
    while state(&left) != "finished" {
        std::thread::sleep(Duration::from_millis(5));
    }
    let states = [&watched[0].1, &watched[1].1, &watched[2].1, &next].map(state);
    assert_eq!(states, ["running", "running", "running", "running"]);
}

#[test]
fn an_interactive_run_without_commands_equals_the_run_of_a_client() {
    let service = Service::start();
    let shorten = |scenario: &mut Value| scenario["duration_s"] = json!(0.3);
    let run = start(&service, "force_tracking_singular", shorten, false);
    let mut viewer = Viewer::open(&service, &run);
    viewer.until(|frame| frame["run"]["state"] == "finished");
    let mut scenario = service.get("/v1/scenarios/force_tracking_singular").accepted();
    shorten(&mut scenario);
    let other = service.post("/v1/simulations", &json!({"scenario": scenario}).to_string()).location.unwrap();
    while service.get(&other).accepted()["state"] != "finished" {
        std::thread::sleep(Duration::from_millis(5));
    }
    let trace = |run: &str| service.get(&format!("{run}/trace")).text;
    assert!(trace(&run) == trace(&other));
}

#[test]
fn samples_say_why_and_have_the_contacts_of_the_law_contact() {
    let service = Service::start();
    let press = |scenario: &mut Value| {
        let controller = &mut scenario["controller"];
        controller["why"] = json!(true);
        controller["tasks"] = json!([
            {"name": "press", "axes": ["x"], "law": {"kind": "contact", "target_force": {"kind": "constant", "value": 20}}},
            {"name": "hold", "axes": ["y", "z"], "law": {"kind": "pose", "gain": 2}}
        ]);
        scenario["contacts"][0]["offset_m"] = json!(0.001);
        scenario["duration_s"] = json!(2.0);
    };
    let seen = all_samples(&service, "stiff_wall", press);
    let contacts = |sample: &Value| sample["contacts"].as_array().unwrap().clone();
    assert!(seen.iter().all(|sample| contacts(sample).len() == 1 && !sample["why"].as_array().unwrap().is_empty()));
    let last = contacts(seen.last().unwrap()).remove(0);
    assert_eq!((&last["task"], &last["row"], &last["state"]), (&json!(0), &json!(0), &json!("contact")), "{last}");
    assert!((last["force"].as_f64().unwrap() - 20.0).abs() < 1.0 && last["target_force"] == 20.0, "{last}");
    // Without `why` and without the law, samples do not become longer.
    let seen = all_samples(&service, "stiff_wall", |scenario| scenario["duration_s"] = json!(0.1));
    assert!(!seen.is_empty());
    assert!(seen.iter().all(|sample| sample.get("why").is_none() && sample.get("contacts").is_none()));
}

#[test]
fn a_run_has_the_requested_speed() {
    let service = Service::start();
    let run = start(&service, "stiff_wall", |scenario| scenario["duration_s"] = json!(0.2), true);
    let begin = Instant::now();
    control(&service, &run, &json!({"paused": false, "speed": 0.5}));
    let frames = Viewer::open(&service, &run).until(|frame| frame["run"]["state"] == "finished");
    assert!(begin.elapsed() >= Duration::from_millis(390), "{:?}", begin.elapsed());
    assert!(frames.len() >= 3, "{}", frames.len());
}

#[test]
fn a_changed_method_takes_over_without_a_jump() {
    let service = Service::start();
    let run = start(&service, "force_tracking_singular", |_| (), true);
    let mut viewer = Viewer::open(&service, &run);
    let methods = ["damped_least_squares", "reverse_priority", "singularity_robust"];
    for (done, method) in (0..).step_by(500).zip(methods) {
        control(&service, &run, &json!({"step": 300}));
        viewer.until(|frame| frame["done"] == done + 300);
        let status = control(&service, &run, &json!({"method": method, "step": 200}));
        assert_eq!(status["method"], method);
        viewer.until(|frame| frame["done"] == done + 500);
    }
    control(&service, &run, &json!({"end": true}));
    viewer.until(|frame| frame["run"]["state"] == "finished");
    let trace = service.exchange("GET", &format!("{run}/trace"), &[("accept", "application/json")], &[]);
    let trace: Value = serde_json::from_slice(trace.body()).unwrap();
    let velocity: Vec<Vec<f64>> =
        trace["samples"].as_array().unwrap().iter().map(|sample| numbers(&sample["joint_velocity"])).collect();
    let largest = |velocity: &[Vec<f64>]| {
        let jump = |pair: &[Vec<f64>]| pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        velocity.windows(2).map(jump).fold(0.0, f64::max)
    };
    // Without the transition, the command would jump by up to 0.045 rad/s here.
    for switch in [300, 800, 1300] {
        let (before, after) = (largest(&velocity[switch - 50..switch]), largest(&velocity[switch - 1..switch + 150]));
        assert!(after < before + 1e-3, "{before} rad/s per period, then {after}");
    }
}

#[test]
fn a_target_leads_the_tool_and_samples_explain_the_tasks() {
    let service = Service::start();
    let run = start(&service, "stiff_wall", |_| (), true);
    let mut viewer = Viewer::open(&service, &run);
    control(&service, &run, &json!({"step": 1}));
    let first = samples(&viewer.until(|frame| frame["done"] == 1));
    let start = numbers(&first[0]["position"]);
    assert_eq!(numbers(&first[0]["orientation"]).len(), 4);
    assert_eq!(first[0]["task_residuals"].as_array().unwrap().len(), 2);
    assert_eq!(first[0]["active_inequalities"], json!([]));

    // The task `hold` follows y, z and the orientation.
    let target = json!({"hold": {"pose": {"position": [start[0], start[1] + 0.02, start[2]],
        "orientation": orientation(&first[0])}}});
    for _ in 0..30 {
        control(&service, &run, &json!({"targets": target, "step": 50}));
    }
    let last = samples(&viewer.until(|frame| frame["done"] == 1501));
    let reached = numbers(&last.last().unwrap()["position"]);
    assert!((reached[1] - start[1] - 0.02).abs() < 0.01, "{start:?}, {reached:?}");
}

#[test]
fn samples_say_where_obstacles_are_and_how_near() {
    let service = Service::start();
    let ball = json!({"name": "ball", "sphere": {"center": [0.3, 1.0, 0.5], "radius": 0.05}, "moves": true});
    let change = |scenario: &mut Value| {
        scenario["controller"]["robot"] = json!("sawyer");
        scenario["controller"]["collisions"] = json!({"obstacles": [ball]});
        let displacement =
            json!({"kind": "ramp", "start": [0, 0, 0], "end": [0, 1, 0], "start_time_s": 0, "duration_s": 10});
        scenario["obstacle_motions"] = json!([{"name": "ball", "displacement": displacement}]);
    };
    let run = start(&service, "stiff_wall", change, true);
    let mut viewer = Viewer::open(&service, &run);
    control(&service, &run, &json!({"step": 101}));
    let seen = samples(&viewer.until(|frame| frame["done"] == 101));
    let room = &seen.last().unwrap()["room"];
    assert_eq!(room["obstacles"][0]["name"], "ball");
    assert!((numbers(&room["obstacles"][0]["position"])[1] - 1.01).abs() < 1e-9, "{room}");
    assert_eq!(numbers(&room["obstacles"][0]["velocity"]), [0.0, 0.1, 0.0]);
    let pairs = room["report"]["pairs"].as_array().unwrap();
    assert!(!pairs.is_empty() && room["report"]["least_distance_m"].as_f64().unwrap() > 0.0, "{room}");
    let without = start(&service, "stiff_wall", |_| (), true);
    let mut viewer = Viewer::open(&service, &without);
    control(&service, &without, &json!({"step": 1}));
    assert!(samples(&viewer.until(|frame| frame["done"] == 1))[0]["room"].is_null());
}

fn orientation(sample: &Value) -> Value {
    let parts = numbers(&sample["orientation"]);
    json!({"w": parts[0], "x": parts[1], "y": parts[2], "z": parts[3]})
}

/// A command that the run could not follow is refused, and the run goes on.
#[test]
fn targets_in_the_wrong_order_do_not_end_a_run() {
    let service = Service::start();
    let run = start(&service, "stiff_wall", |_| {}, true);
    let pose = json!({"position": [0.5, 0.1, 0.3], "orientation": {"w": 0.0, "x": 0.0, "y": 1.0, "z": 0.0}});
    let ahead =
        |after_s: [f64; 2]| json!([{"after_s": after_s[0], "pose": pose}, {"after_s": after_s[1], "pose": pose}]);
    let command = |after_s| json!({"targets": {"hold": {"pose": pose, "ahead": ahead(after_s)}}, "step": 3});
    let refused = service.post(&format!("{run}/control"), &command([0.2, 0.1]).to_string());
    refused.assert_refused(422, Some("/targets/hold/ahead/1"));
    let mut viewer = Viewer::open(&service, &run);
    control(&service, &run, &command([0.1, 0.2]));
    viewer.until(|frame| frame["done"] == 3);
}
