//! A robot with two arms: its registration, and tasks of any link, seen from any other one.

use serde_json::{Value, json};

use crate::harness::{Service, example, numbers};

const POSTURE: [f64; 7] = [0.1, 0.6, -0.9, 0.3, -0.5, 0.8, -0.2];

fn with_two_arms() -> Service {
    let service = Service::start();
    let created = service.post("/v1/robots", &example("robot_two_arms.json").to_string());
    assert_eq!(created.status, 201, "{}", created.text);
    service
}

fn kinematics(service: &Service, link: &str, relative_to: &Value) -> Value {
    let request = json!({"robot": "two-arms", "joint_position": POSTURE, "link": link, "relative_to": relative_to});
    service.call("/v1/kinematics", &request)
}

fn position(pose: &Value) -> Vec<f64> {
    numbers(&pose["position"])
}

#[test]
fn a_robot_with_two_arms_lists_its_tips_and_links() {
    let service = with_two_arms();
    let robot = service.get("/v1/robots/two-arms").accepted();
    let tips = json!([{"name": "left", "link": "left_hand"}, {"name": "right", "link": "right_hand"}]);
    assert_eq!((robot["joints"].as_array().unwrap().len(), &robot["tips"]), (7, &tips));
    assert!(robot["links"].as_array().unwrap().contains(&json!("right_lower")));
    assert!(robot.get("chain").is_none());
    let shown = service.call("/v1/kinematics", &json!({"robot": "two-arms", "joint_position": POSTURE}));
    let parents: Vec<_> = shown["links"].as_array().unwrap().iter().map(|link| link["parent"].clone()).collect();
    assert_eq!(parents[0], Value::Null);
    assert_eq!((&parents[1], &parents[4]), (&json!("waist"), &json!("waist")));
    assert_eq!(shown["tips"][0]["pose"], shown["pose"]);
    let right = kinematics(&service, "right", &Value::Null);
    assert_eq!(shown["tips"][1]["pose"], right["pose"]);
}

#[test]
fn the_jacobian_of_a_link_is_the_derivative_of_its_pose_seen_from_another() {
    let service = with_two_arms();
    for (link, relative_to) in [("right", Value::Null), ("right", json!("left")), ("left_lower", json!("right"))] {
        let rows = kinematics(&service, link, &relative_to)["jacobian"].clone();
        for joint in 0..7 {
            let at = |change: f64| {
                let mut q = POSTURE;
                q[joint] += change;
                let request =
                    json!({"robot": "two-arms", "joint_position": q, "link": link, "relative_to": relative_to});
                position(&service.call("/v1/kinematics", &request)["pose"])
            };
            for (row, (after, before)) in at(1e-6).into_iter().zip(at(-1e-6)).enumerate() {
                let found = rows[row][joint].as_f64().unwrap();
                assert!((found - (after - before) / 2e-6).abs() < 1e-8, "{link}, row {row}, joint {joint}");
            }
        }
    }
}

#[test]
fn a_problem_moves_one_hand_seen_from_the_other() {
    let service = with_two_arms();
    let task = |name: &str, more: Value| {
        let mut task = json!({"name": name, "axes": ["x", "y", "rz"]});
        task.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        task
    };
    let hold = task("hold", json!({"link": "right", "relative_to": "left", "velocity": [0, 0, 0]}));
    let lead = task("lead", json!({"link": "left", "velocity": [0.1, -0.05, 0.2]}));
    let problem = json!({"robot": "two-arms", "joint_position": POSTURE, "tasks": [hold, lead]});
    let answer = service.call("/v1/resolve", &problem);
    let velocity = numbers(&answer["joint_velocity"]);
    let rate = |link: &str, relative_to: &Value| {
        let rows = kinematics(&service, link, relative_to)["jacobian"].clone();
        let row = |row: usize| numbers(&rows[row]).iter().zip(&velocity).map(|(a, v)| a * v).sum::<f64>();
        [row(0), row(1), row(5)]
    };
    assert!(rate("right", &json!("left")).iter().all(|entry| entry.abs() < 1e-12), "{answer}");
    for (found, wanted) in rate("left", &Value::Null).into_iter().zip([0.1, -0.05, 0.2]) {
        assert!((found - wanted).abs() < 1e-12, "{answer}");
    }
}

/// Stateless and in a session: the relative pose is held while the left hand follows a streamed target.
#[test]
fn a_controller_carries_with_two_hands() {
    let service = with_two_arms();
    let law = json!({"kind": "pose", "gain": 8});
    let axes = json!(["x", "y", "rz"]);
    let tasks = json!([
        {"name": "hold", "link": "right", "relative_to": "left", "axes": axes, "law": law},
        {"name": "lead", "link": "left", "axes": axes, "law": law}
    ]);
    let controller =
        json!({"robot": "two-arms", "period_s": 0.01, "tasks": tasks, "drive": {"lag_s": 0, "delay_periods": 0}});
    let path = service.open(&controller) + "/step";
    let start = kinematics(&service, "left", &Value::Null)["pose"].clone();
    let held = position(&kinematics(&service, "right", &json!("left"))["pose"]);
    let (mut q, mut memory) = (POSTURE.to_vec(), Value::Null);
    let mut target = start.clone();
    target["position"][0] = json!(position(&start)[0] - 0.05);
    for period in 0..300_u32 {
        let state = json!({"sequence": period, "time_s": 0.01 * f64::from(period), "joint_position": q,
                           "targets": {"lead": {"pose": target}}});
        let answer = service.call(&path, &state);
        let again = service.call("/v1/step", &json!({"controller": controller, "state": state, "memory": memory}));
        assert_eq!(answer["joint_velocity"], again["joint_velocity"], "period {period}");
        memory = again["memory"].clone();
        q.iter_mut().zip(numbers(&answer["joint_velocity"])).for_each(|(q, v)| *q += 0.01 * v);
    }
    let at = |link: &str, relative_to: Value| {
        let request = json!({"robot": "two-arms", "joint_position": q, "link": link, "relative_to": relative_to});
        position(&service.call("/v1/kinematics", &request)["pose"])
    };
    let distance = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(distance(at("left", Value::Null), position(&target)) < 1e-4);
    assert!(distance(at("right", json!("left")), held) < 1e-4);
}

#[test]
fn a_plane_holds_back_any_tip_or_link() {
    let service = with_two_arms();
    let place = |link: &str| position(&kinematics(&service, link, &Value::Null)["pose"])[0];
    let pushed = |point: &str, offset: f64| {
        let plane = json!({"kind": "plane", "normal": [1, 0, 0], "offset_m": offset, "point": point});
        let task = json!({"link": "right", "axes": ["x"], "velocity": [0.2]});
        json!({"robot": "two-arms", "joint_position": POSTURE, "tasks": [task], "inequalities": [plane]}).to_string()
    };
    // 5 mm before the plane, the hand approaches it with 10/s · 5 mm.
    let answer = service.post("/v1/resolve", &pushed("right", place("right") + 0.005)).accepted();
    assert!((answer["tasks"][0]["achieved"][0].as_f64().unwrap() - 0.05).abs() < 1e-9, "{answer}");
    assert_eq!(answer["active_inequalities"].as_array().unwrap().len(), 1);
    let answer = service.post("/v1/resolve", &pushed("left", place("left") + 0.005)).accepted();
    assert!((answer["tasks"][0]["achieved"][0].as_f64().unwrap() - 0.2).abs() < 1e-9, "{answer}");
    service.post("/v1/resolve", &pushed("none", 0.0)).assert_refused(422, Some("/inequalities/0/point"));
}

#[test]
fn wrong_links_and_tips_are_refused_with_the_place() {
    let service = with_two_arms();
    let problem = |link: Value| {
        let mut task = json!({"axes": ["x"], "velocity": [0.1]});
        task.as_object_mut().unwrap().extend(link.as_object().unwrap().clone());
        json!({"robot": "two-arms", "joint_position": POSTURE, "tasks": [task]}).to_string()
    };
    let refused = service.post("/v1/resolve", &problem(json!({"link": "rihgt"})));
    refused.assert_refused(422, Some("/tasks/0/link"));
    assert!(refused.text.contains("\"left\""), "the names are listed: {}", refused.text);
    service
        .post("/v1/resolve", &problem(json!({"relative_to": "none"})))
        .assert_refused(422, Some("/tasks/0/relative_to"));
    let rows = json!({"tasks": [{"link": "left", "jacobian": [[1, 0]], "velocity": [0.1]}]}).to_string();
    service.post("/v1/resolve", &rows).assert_refused(422, Some("/tasks/0/link"));

    let controller = |task: Value| json!({"robot": "two-arms", "period_s": 0.01, "tasks": [task]}).to_string();
    let force =
        json!({"kind": "force", "inertia": 15, "damping": 150, "target_force": {"kind": "constant", "value": 5}});
    service
        .post(
            "/v1/controllers",
            &controller(json!({"name": "push", "link": "right_lower", "axes": ["x"], "law": &force})),
        )
        .assert_refused(422, Some("/tasks/0/law"));
    let posture = json!({"kind": "posture", "gain": 1, "target_position": "mid_range"});
    service
        .post("/v1/controllers", &controller(json!({"name": "rest", "link": "right", "law": posture})))
        .assert_refused(422, Some("/tasks/0/link"));

    let with = |change: &dyn Fn(&mut Value)| {
        let mut registration = example("robot_two_arms.json");
        registration["name"] = json!("other");
        change(&mut registration);
        service.post("/v1/robots", &registration.to_string())
    };
    with(&|robot| robot["tip"] = json!("left_hand")).assert_refused(422, Some("/tip"));
    with(&|robot| robot["tips"] = json!([])).assert_refused(422, Some("/tips"));
    with(&|robot| robot["tips"][1]["name"] = json!("left")).assert_refused(422, Some("/tips"));
    with(&|robot| robot["tips"][1]["link"] = json!("hand")).assert_refused(422, Some("/tips"));
    with(&|robot| robot["tips"][1]["link"] = json!("floor")).assert_refused(422, Some("/tips"));
    // Names that mean something else, and no names.
    for name in ["tool", "base", "left_elbow", "left_lower", "", "a\nb", &"x".repeat(65)] {
        with(&|robot| robot["tips"][1]["name"] = json!(name)).assert_refused(422, Some("/tips/1/name"));
    }
    // The base is what tasks are seen from without `relative_to`: the law of the tool is accepted.
    let from_base = json!({"name": "push", "relative_to": "floor", "axes": ["x"], "law": force});
    assert_eq!(service.post("/v1/controllers", &controller(from_base)).status, 201);
    with(&|robot| robot["tips"][1]["offset"]["orientation"]["w"] = json!(2))
        .assert_refused(422, Some("/tips/1/offset/orientation"));
}

/// Returns the body of a stateless step in which both hands yield, with wrenches.
fn yielding(wrenches: &Value) -> Value {
    let hand = |name: &str| {
        let law = json!({"kind": "impedance", "stiffness": [500], "damping": [50], "inertia": [1]});
        json!({"name": name, "link": name, "axes": ["x"], "law": law})
    };
    let controller = json!({"robot": "two-arms", "period_s": 0.004, "tasks": [hand("left"), hand("right")]});
    let state = json!({"sequence": 0, "time_s": 0, "joint_position": POSTURE, "wrenches": wrenches});
    json!({"controller": controller, "state": state})
}

#[test]
fn each_hand_yields_to_its_own_wrench() {
    let service = with_two_arms();
    let wrench = |force: f64| json!({"force": [force, 0, 0], "torque": [0, 0, 0]});
    let answer = service.call("/v1/step", &yielding(&json!({"left": wrench(0.0), "right": wrench(10.0)})));
    let velocity = |k: usize| answer["tasks"][k]["requested"][0].as_f64().unwrap();
    assert_eq!(velocity(0), 0.0);
    assert!(velocity(1) < -1e-3, "{}", velocity(1));
    // `wrench` is that of the first tip.
    let mut twice = yielding(&json!({"right": wrench(10.0)}));
    twice["state"]["wrench"] = wrench(0.0);
    assert_eq!(service.call("/v1/step", &twice)["joint_velocity"], answer["joint_velocity"]);
}

#[test]
fn wrenches_that_are_missing_given_twice_or_of_no_tip_are_refused() {
    let service = with_two_arms();
    let wrench = json!({"force": [0, 0, 0], "torque": [0, 0, 0]});
    let far = json!({"force": [1e5, 0, 0], "torque": [0, 0, 0]});
    let refused = |body: &Value, pointer: &str| {
        let answer = service.post("/v1/step", &body.to_string());
        assert_eq!(answer.refusal_difference(422, Some(pointer)), None, "{}", answer.text);
    };
    refused(&yielding(&json!({"left": wrench})), "/state/wrenches/right");
    refused(&yielding(&json!({"right": wrench})), "/state/wrench");
    refused(&yielding(&json!({"left": wrench, "right": wrench, "left_hand": wrench})), "/state/wrenches/left_hand");
    let mut twice = yielding(&json!({"left": wrench, "right": wrench}));
    twice["state"]["wrench"] = wrench.clone();
    refused(&twice, "/state/wrenches/left");
    let mut bounded = yielding(&json!({"left": wrench, "right": far}));
    bounded["controller"]["state_checks"] = json!({"max_force_n": 100});
    refused(&bounded, "/state/wrenches/right/force");
}

#[test]
fn a_hand_that_looks_at_a_point_has_two_rows_and_no_axes() {
    let service = with_two_arms();
    let look = |law: &Value, more: &Value| {
        let mut law = law.clone();
        law["kind"] = json!("look_at");
        let mut task = json!({"name": "watch", "link": "right", "relative_to": "left", "law": law});
        task.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let controller = json!({"robot": "two-arms", "period_s": 0.004, "tasks": [task]});
        json!({"controller": controller, "state": {"sequence": 0, "time_s": 0, "joint_position": POSTURE}})
    };
    let point = json!({"kind": "constant", "value": [0.3, 0.1, 0]});
    let law = json!({"gain": 3, "direction": [1, 0, 0], "target_point": point});
    let answer = service.call("/v1/step", &look(&law, &json!({})));
    assert_eq!(answer["tasks"][0]["requested"].as_array().unwrap().len(), 2);
    assert!(answer["tasks"][0]["achieved"][0].as_f64().unwrap() > 0.05, "{answer}");
    let refused = |law: Value, more: Value, pointer: &str| {
        let answer = service.post("/v1/step", &look(&law, &more).to_string());
        assert_eq!(answer.refusal_difference(422, Some(pointer)), None, "{}", answer.text);
    };
    refused(law.clone(), json!({"axes": ["x"]}), "/controller/tasks/0/axes");
    refused(law.clone(), json!({"frame": "tool"}), "/controller/tasks/0/frame");
    refused(law.clone(), json!({"link": "nose"}), "/controller/tasks/0/link");
    let with = |field: &str, value: Value| {
        let mut changed = law.clone();
        changed[field] = value;
        changed
    };
    refused(with("direction", json!([0, 0, 0])), json!({}), "/controller/tasks/0/law/direction");
    refused(with("gain", json!(-1)), json!({}), "/controller/tasks/0/law/gain");
    let two = json!({"kind": "constant", "value": [0, 0]});
    refused(with("target_point", two), json!({}), "/controller/tasks/0/law/target_point/value");
}
