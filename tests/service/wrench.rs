//! Wrench sensors over HTTP: corrected wrenches, taring, and the identification of a payload.

use serde_json::{Value, json};

use crate::harness::{Service, numbers, without};

const START: [f64; 7] = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];
/// Mass, kg, and centre of mass, m, of the tool.
const MASS: f64 = 0.5;
const CENTER: [f64; 3] = [0.01, -0.02, 0.06];
/// Bias of the sensor.
const BIAS: [f64; 6] = [2.0, -1.0, 2.0, 0.1, 0.05, -0.08];

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A generator of numbers from −1 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / 4_503_599_627_370_496.0 - 1.0
    }

    fn posture(&mut self) -> Vec<f64> {
        (0..7).map(|_| 2.0 * self.next()).collect()
    }

    /// Noise of 0.2 N and 0.02 N·m rms.
    fn noise(&mut self, entry: usize) -> f64 {
        self.next() * 3.0_f64.sqrt() * if entry < 3 { 0.2 } else { 0.02 }
    }
}

/// Returns gravity along the axes of the tool, m/s².
fn gravity(service: &Service, q: &[f64]) -> [f64; 3] {
    let pose =
        &service.call("/v1/kinematics", &json!({"robot": "sawyer_dh", "joint_position": q}))["pose"]["orientation"];
    let [w, x, y, z] = ["w", "x", "y", "z"].map(|part| pose[part].as_f64().unwrap());
    // The third row of the rotation matrix, times −9.81.
    [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z].map(|entry| -9.81 * entry)
}

/// Returns what a sensor on the tool reads without contact: `on_tool`, with noise.
fn reading(service: &Service, q: &[f64], random: &mut Random) -> Value {
    let weight = gravity(service, q).map(|entry| MASS * entry);
    let clean = [weight, cross(CENTER, weight)].concat();
    let noisy: Vec<f64> = (0..6).map(|i| clean[i] + BIAS[i] + random.noise(i)).collect();
    json!({"force": noisy[..3], "torque": noisy[3..]})
}

fn controller(sensor: &Value) -> Value {
    json!({"robot": "sawyer_dh", "period_s": 0.002, "wrench_convention": "on_tool", "wrench_frame": "tool", "state_checks": {"position_tolerance": 10},
        "wrench_sensor": sensor, "tasks": [
        {"name": "press", "axes": ["z"], "law": {"kind": "contact", "target_force": {"kind": "constant", "value": -15}}},
        {"name": "hold", "axes": ["x", "y", "rx", "ry", "rz"], "law": {"kind": "pose", "gain": 3}}]})
}

fn state(sequence: u64, q: &[f64], wrench: &Value) -> Value {
    json!({"sequence": sequence, "time_s": sequence as f64 * 0.002, "joint_position": q, "wrench": wrench})
}

fn readings(service: &Service, q: &[f64], count: usize, random: &mut Random) -> Vec<Value> {
    let read = |random: &mut Random| json!({"joint_position": q, "wrench": reading(service, q, random)});
    (0..count).map(|_| read(random)).collect()
}

/// Returns the length of the corrected force in a posture without contact, N.
fn left(service: &Service, controller: &Value, q: &[f64], random: &mut Random) -> f64 {
    let request = json!({"controller": controller, "state": state(1, q, &reading(service, q, random)), "memory": null});
    let answer = service.call("/v1/step", &request);
    numbers(&answer["wrench"]["force"]).iter().map(|f| f * f).sum::<f64>().sqrt()
}

#[test]
fn after_a_tare_a_session_computes_with_the_right_wrench() {
    let (service, mut random) = (Service::start(), Random(88_172_645_463_325_252));
    let payload = json!({"payload": {"mass_kg": MASS, "center_of_mass": CENTER}, "filter_time_s": 0.004});
    let session = service.open(&controller(&payload));
    let step = |sequence, random: &mut Random| {
        let wrench = reading(&service, &START, random);
        service.call(&format!("{session}/step"), &state(sequence, &START, &wrench))
    };
    let before = numbers(&step(1, &mut random)["wrench"]["force"]);
    assert!(before.iter().map(|f| f * f).sum::<f64>().sqrt() > 2.5, "{before:?}");
    let tare = json!({"readings": readings(&service, &START, 100, &mut random)});
    let found = service.call(&format!("{session}/tare"), &tare);
    let bias = [numbers(&found["bias"]["force"]), numbers(&found["bias"]["torque"])].concat();
    for (entry, (found, truth)) in bias.iter().zip(BIAS).enumerate() {
        assert!((found - truth).abs() < if entry < 3 { 0.1 } else { 0.01 }, "{bias:?}");
    }
    assert!((0.15..0.25).contains(&found["force_noise_n"].as_f64().unwrap()), "{found}");
    assert_eq!(found.get("warnings"), None);
    // The low-pass starts anew, so nothing of the old bias is left.
    let after = numbers(&step(2, &mut random)["wrench"]["force"]);
    assert!(after.iter().map(|f| f * f).sum::<f64>().sqrt() < 0.8, "{after:?}");
    let shown = service.get(&session).accepted()["controller"].clone();
    assert_eq!(shown["wrench_sensor"]["bias"], found["bias"]);
    assert_eq!(shown["wrench_sensor"]["filter_time_s"], 0.004);
    // What is left is the noise: at most 0.6 N of a single reading.
    for _ in 0..20 {
        let q = random.posture();
        assert!(left(&service, &shown, &q, &mut random) < 0.3 + 0.6);
    }
}

#[test]
fn a_tare_of_a_moving_arm_or_a_noisy_wrench_is_refused_and_changes_nothing() {
    let (service, mut random) = (Service::start(), Random(362_436_069));
    let session = service.open(&controller(&json!({})));
    let refused = |readings: &[Value], pointer: &str, part: &str| {
        let answer = service.post(&format!("{session}/tare"), &json!({"readings": readings}).to_string());
        answer.assert_refused(422, Some(pointer));
        assert!(answer.text.contains(part), "{}", answer.text);
    };
    let good = readings(&service, &START, 30, &mut random);
    refused(&good[..5], "/readings", "5 readings; give at least 20");
    let mut moves = good.clone();
    moves[7]["joint_position"][2] = json!(3.01);
    refused(&moves, "/readings", "joint 3 moves");
    let mut shaken = good.clone();
    for reading in shaken.iter_mut().step_by(2) {
        reading["wrench"]["force"][0] = json!(9.0);
    }
    refused(&shaken, "/readings", "something touches");
    let mut short = good.clone();
    short[3]["joint_position"] = json!([1.0]);
    refused(&short, "/readings/3/joint_position", "1 number");
    assert_eq!(service.get(&session).accepted()["controller"]["wrench_sensor"], json!({}));
    let answer = service.post(&format!("{session}/tare"), &json!({"readings": good, "tip": "left"}).to_string());
    answer.assert_refused(422, Some("/tip"));
    // Without a payload the bias is that of this posture, and the answer says so.
    let found = service.call(&format!("{session}/tare"), &json!({"readings": good}));
    assert!(found["warnings"][0].as_str().unwrap().contains("no payload"), "{found}");
    service.post("/v1/controllers/none/tare", &json!({"readings": good}).to_string()).assert_refused(404, None);
}

/// A law that presses would lose its force into the bias, and press harder after each tare.
#[test]
fn a_tare_that_contradicts_the_session_is_refused_or_warned_of() {
    let (service, mut random) = (Service::start(), Random(77_232_917));
    let mut pressing = controller(&json!({}));
    pressing["tasks"] = json!([{"name": "press", "axes": ["z"],
        "law": {"kind": "contact", "target_force": {"kind": "constant", "value": -15.0}}}]);
    pressing["wrench_frame"] = json!("base");
    let session = service.open(&pressing);
    for sequence in 1..200 {
        let wrench = json!({"force": [0.0, 0.0, 15.0 + 0.1 * random.next()], "torque": [0.0, 0.0, 0.0]});
        service.call(&format!("{session}/step"), &state(sequence, &START, &wrench));
    }
    let good = readings(&service, &START, 30, &mut random);
    let answer = service.post(&format!("{session}/tare"), &json!({"readings": good}).to_string());
    answer.assert_refused(422, Some("/readings"));
    assert!(answer.text.contains("would count as bias"), "{}", answer.text);
    // Another name, and the tool as frame, which points downwards: the law knows nothing of its contact, and the session does.
    let rename = |pressing: &mut Value, name: &str| pressing["tasks"][0]["name"] = json!(name);
    rename(&mut pressing, "renamed");
    let put = |controller: &Value| {
        let headers = [("content-type", "application/json")];
        assert_eq!(service.send("PUT", &session, &headers, &controller.to_string()).status, 200);
    };
    let step = |sequence: u64, force: f64| {
        let wrench = json!({"force": [0.0, 0.0, force], "torque": [0.0, 0.0, 0.0]});
        service.call(&format!("{session}/step"), &state(sequence, &START, &wrench));
    };
    let tare = || service.post(&format!("{session}/tare"), &json!({"readings": good}).to_string());
    put(&pressing);
    tare().assert_refused(422, Some("/readings"));
    rename(&mut pressing, "again");
    put(&pressing);
    (200..210).for_each(|sequence| step(sequence, 15.0));
    tare().assert_refused(422, Some("/readings"));
    // Along another axis the law sees nothing of the surface, which is still there.
    let mut turned = pressing.clone();
    turned["tasks"][0]["axes"] = json!(["x"]);
    put(&turned);
    (210..230).for_each(|sequence| step(sequence, 15.0));
    tare().assert_refused(422, Some("/readings"));
    put(&pressing);
    // The tool leaves the surface.
    (230..280).for_each(|sequence| step(sequence, 0.0));
    assert_eq!(tare().status, 200);

    let mut bounded = controller(&json!({}));
    bounded["state_checks"] = json!({"max_force_n": 100.0});
    let session = service.open(&bounded);
    let mut wild = good.clone();
    wild[3]["wrench"]["force"][1] = json!(4000.0);
    let answer = service.post(&format!("{session}/tare"), &json!({"readings": wild}).to_string());
    answer.assert_refused(422, Some("/readings/3/wrench/force"));
    let mut in_degrees = good.clone();
    in_degrees[2]["joint_position"][1] = json!(-60.0);
    let answer = service.post(&format!("{session}/tare"), &json!({"readings": in_degrees}).to_string());
    answer.assert_refused(422, Some("/readings/2/joint_position"));
    assert!(answer.text.contains("not in degrees"), "{}", answer.text);
    // Thirty copies of one reading, of a posture in which the arm was not.
    let wrench = json!({"force": [0.0, 0.0, 0.0], "torque": [0.0, 0.0, 0.0]});
    service.call(&format!("{session}/step"), &state(1, &START, &wrench));
    let mut copy = good[0].clone();
    copy["joint_position"][1] = json!(START[1] + 0.5);
    let found = service.call(&format!("{session}/tare"), &json!({"readings": vec![copy; 30]}));
    let warnings = found["warnings"].to_string();
    assert!(warnings.contains("all readings are the same") && warnings.contains("away from the last state"), "{found}");
}

#[test]
fn a_deadband_or_a_noise_that_hides_the_force_is_told() {
    let service = Service::start();
    let mut blind = controller(&json!({"deadband_n": 20.0}));
    blind["tasks"] = json!([{"name": "push", "axes": ["z"],
        "law": {"kind": "force", "inertia": 15, "damping": 300, "target_force": {"kind": "constant", "value": -15.0}}}]);
    let warnings = service.call("/v1/controllers", &blind)["warnings"].to_string();
    assert!(warnings.contains("hides most of the target of 15 N"), "{warnings}");
    let law = json!({"kind": "contact", "noise": 20.0, "target_force": {"kind": "constant", "value": -15.0}});
    blind["tasks"][0]["law"] = law;
    let answer = service.post("/v1/controllers", &blind.to_string());
    answer.assert_refused(422, Some("/tasks/0/law/noise"));
}

#[test]
fn the_payload_of_six_postures_makes_the_wrench_right_in_every_posture() {
    let (service, mut random) = (Service::start(), Random(521_288_629));
    let mut request = json!({"robot": "sawyer_dh", "wrench_convention": "on_tool", "readings": []});
    for _ in 0..8 {
        let q = random.posture();
        let read = readings(&service, &q, 25, &mut random);
        request["readings"].as_array_mut().unwrap().extend(read);
    }
    let found = service.call("/v1/payload", &request);
    assert_eq!((&found["axes_verified"], &found["readings"]), (&json!(true), &json!(200)));
    assert!((found["payload"]["mass_kg"].as_f64().unwrap() - MASS).abs() < 0.02, "{found}");
    let found_controller = controller(&json!({"bias": found["bias"], "payload": found["payload"]}));
    for _ in 0..20 {
        let q = random.posture();
        assert!(left(&service, &found_controller, &q, &mut random) < 0.3 + 0.6);
    }
    let mut in_degrees = request.clone();
    for reading in in_degrees["readings"].as_array_mut().unwrap() {
        let position: Vec<f64> = numbers(&reading["joint_position"]).into_iter().map(f64::to_degrees).collect();
        reading["joint_position"] = json!(position);
    }
    let answer = service.post("/v1/payload", &in_degrees.to_string());
    answer.assert_refused(422, Some("/readings/0/joint_position"));
    assert!(answer.text.contains("not in degrees"), "{}", answer.text);
    // The other sign, and two exchanged axes.
    request["wrench_convention"] = json!("on_environment");
    let answer = service.post("/v1/payload", &request.to_string());
    answer.assert_refused(422, Some("/readings"));
    assert!(answer.text.contains("the other sign"), "{}", answer.text);
    request["wrench_convention"] = json!("on_tool");
    for reading in request["readings"].as_array_mut().unwrap() {
        let force = numbers(&reading["wrench"]["force"]);
        reading["wrench"]["force"] = json!([force[1], force[0], force[2]]);
    }
    let answer = service.post("/v1/payload", &request.to_string());
    assert!(answer.text.contains("x measures y, y measures x, z measures z"), "{}", answer.text);
}

#[test]
fn poor_readings_are_refused_with_the_posture_to_add() {
    let (service, mut random) = (Service::start(), Random(5));
    let readings = readings(&service, &START, 10, &mut random);
    let request = json!({"robot": "sawyer_dh", "wrench_convention": "on_tool", "readings": readings});
    let answer = service.post("/v1/payload", &request.to_string());
    answer.assert_refused(422, Some("/readings"));
    assert!(answer.text.contains("add a posture with gravity along"), "{}", answer.text);
    for (change, pointer) in [
        (json!({"force_noise_n": 0}), "/force_noise_n"),
        (json!({"torque_noise_nm": 0}), "/torque_noise_nm"),
        (json!({"robot": "nobody"}), "/robot"),
        (json!({"robot": null}), "/readings/0"),
        (json!({"readings": []}), "/readings"),
        (json!({"gravity": [0, 0, 0]}), "/gravity"),
        (json!({"tip": "left"}), "/tip"),
    ] {
        let mut changed = request.clone();
        changed.as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
        service.post("/v1/payload", &changed.to_string()).assert_refused(422, Some(pointer));
    }
}

#[test]
fn sensors_that_are_none_are_refused_by_their_fields() {
    let service = Service::start();
    for (sensor, pointer) in [
        (json!({"payload": {"mass_kg": -1}}), "/wrench_sensor/payload/mass_kg"),
        (json!({"payload": {"mass_kg": 1e5}}), "/wrench_sensor/payload/mass_kg"),
        (json!({"payload": {"mass_kg": 1, "center_of_mass": [60, 0, 500]}}), "/wrench_sensor/payload/center_of_mass"),
        (json!({"filter_time_s": -0.1}), "/wrench_sensor/filter_time_s"),
        (json!({"filter_time_s": 5}), "/wrench_sensor/filter_time_s"),
        (json!({"deadband_n": -1}), "/wrench_sensor/deadband_n"),
        (json!({"bias": {"force": [0, 0, 1e30], "torque": [0, 0, 0]}}), "/wrench_sensor/bias/force/2"),
        (
            json!({"pose": {"position": [0, 0, 0], "orientation": {"w": 2, "x": 0, "y": 0, "z": 0}}}),
            "/wrench_sensor/pose/orientation",
        ),
    ] {
        service.post("/v1/controllers", &controller(&sensor).to_string()).assert_refused(422, Some(pointer));
    }
    let mut other = controller(&json!({}));
    other["wrench_sensors"] = json!({"left": {}});
    service.post("/v1/controllers", &other.to_string()).assert_refused(422, Some("/wrench_sensors/left"));
}

#[test]
fn a_stated_sensor_needs_its_reading() {
    let service = Service::start();
    let request = json!({"robot": "sawyer_dh", "period_s": 0.002, "wrench_sensor": {}, "tasks": [
        {"name": "hold", "axes": ["x", "y", "z"], "law": {"kind": "pose", "gain": 3}}]});
    let session = service.open(&request);
    let state = json!({"sequence": 1, "time_s": 0.0, "joint_position": START});
    let answer = service.post(&format!("{session}/step"), &state.to_string());
    answer.assert_refused(422, Some("/wrench"));
    assert!(answer.text.contains("the wrench sensor of the controller needs the wrench"), "{}", answer.text);
}

/// The memory of a low-pass and of an acceleration travels with stateless steps.
#[test]
fn sessions_and_stateless_steps_correct_with_the_same_bytes() {
    let (service, mut random) = (Service::start(), Random(7));
    let sensor = json!({"payload": {"mass_kg": MASS, "center_of_mass": CENTER}, "filter_time_s": 0.01, "compensate_inertia": true,
        "pose": {"position": [0, 0, -0.1], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}});
    let mut controller = controller(&sensor);
    controller["tool_offset"] = json!({"position": [0, 0, 0.2], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}});
    let session = service.open(&controller);
    let (mut q, mut memory) = (START.to_vec(), Value::Null);
    for sequence in 0..100 {
        let state = state(sequence, &q, &reading(&service, &q, &mut random));
        let by_session = service.call(&format!("{session}/step"), &state);
        let stateless = service.call("/v1/step", &json!({"controller": controller, "state": state, "memory": memory}));
        memory = stateless["memory"].clone();
        let velocity = numbers(&by_session["joint_velocity"]);
        q.iter_mut().zip(&velocity).for_each(|(q, v)| *q += 0.002 * v);
        let bytes = |answer: Value| without(answer, &["elapsed_us", "memory"]).to_string();
        assert_eq!(bytes(by_session), bytes(stateless));
    }
    assert!(memory["wrench_sensors"][0]["filtered"]["force"].is_array(), "{memory}");
}

/// Grams, millimetres, and gravity in g.
#[test]
fn numbers_of_a_sensor_in_another_unit_are_warned_of() {
    let service = Service::start();
    let warned = |sensor: Value| {
        let created = service.call("/v1/controllers", &controller(&sensor));
        created["warnings"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|text| text.as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    let usual = warned(json!({"payload": {"mass_kg": 0.8, "center_of_mass": [0, 0, 0.07]}}));
    let turned = json!({"w": 1, "x": 0, "y": 0, "z": 0});
    for (sensor, field) in [
        (json!({"payload": {"mass_kg": 800}}), "payload.mass_kg"),
        (json!({"payload": {"mass_kg": 0.8, "center_of_mass": [0, 0, 70]}}), "payload.center_of_mass"),
        (json!({"pose": {"position": [0, 0, 80], "orientation": turned}}), "pose"),
        (json!({"payload": {"mass_kg": 0.8}, "gravity": [0, 0, -1]}), "gravity"),
        (json!({"payload": {"mass_kg": 0.8}, "gravity": [0, 0, -9810]}), "gravity"),
    ] {
        let warnings = warned(sensor);
        assert_eq!(warnings.len(), usual.len() + 1, "{warnings:?}");
        assert!(warnings.iter().any(|text| text.starts_with(&format!("`wrench_sensor.{field}`"))), "{warnings:?}");
    }
    assert_eq!(warned(json!({"payload": {"mass_kg": 0.8}, "gravity": [0, 0, 0]})).len(), usual.len());
}
