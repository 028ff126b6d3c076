//! Shapes of robots, obstacles of controllers and states, and what answers say about distances.

use serde_json::{Value, json};

use crate::harness::{Service, example, numbers};

const PERIOD: f64 = 0.004;

/// Returns a controller that pulls the hand of a Panda into the post.
fn controller(collisions: Value) -> Value {
    let mut controller = example("controller_room.json");
    controller["collisions"] = collisions;
    controller["tasks"][0]["law"]["target_pose"] =
        json!({"position": [0.5, -0.35, 0.4], "orientation": {"w": 0, "x": 1, "y": 0, "z": 0}});
    controller
}

fn post() -> Value {
    json!({"name": "post", "capsule": {"start": [0.5, -0.35, 0], "end": [0.5, -0.35, 0.7], "radius": 0.05}})
}

fn state(sequence: u64, q: &[f64]) -> Value {
    json!({"sequence": sequence, "time_s": (sequence as f64) * PERIOD, "joint_position": q})
}

const HOME: [f64; 7] = [0.0, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8];

#[test]
fn a_session_rests_before_a_post_and_says_which_pair_holds_it() {
    let service = Service::start();
    let mut controller = controller(json!({"min_distance_m": 0.02, "obstacles": [post()]}));
    controller["drive"] = json!({"lag_s": 0.0, "delay_periods": 0});
    let id = service.open(&controller);
    let mut q = HOME.to_vec();
    let (mut least, mut last, mut held) = (f64::INFINITY, Value::Null, Value::Null);
    for sequence in 1..1500 {
        let answer = service.call(&format!("{id}/step"), &state(sequence, &q));
        let speeds = numbers(&answer["joint_velocity"]);
        q.iter_mut().zip(speeds).for_each(|(q, speed)| *q += PERIOD * speed);
        least = least.min(answer["collisions"]["least_distance_m"].as_f64().unwrap());
        if answer.get("active_inequalities").is_some() {
            held = answer.clone();
        }
        last = answer;
    }
    assert!((0.02 - 1e-6..0.022).contains(&least), "{least}");
    let nearest = &last["collisions"]["pairs"][0];
    assert_eq!((&nearest["b"], &last["collisions"]["violated"]), (&json!("post"), &json!(false)), "{last}");
    let points: Vec<Vec<f64>> = nearest["points"].as_array().unwrap().iter().map(numbers).collect();
    let apart: f64 = points[0].iter().zip(&points[1]).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    assert!((apart - nearest["distance_m"].as_f64().unwrap()).abs() < 1e-9);
    let name = held["active_inequalities"][0]["name"].as_str().unwrap();
    assert!(name.starts_with("collision:panda_link") && name.ends_with("/post"), "{name}");
    let link = name.trim_start_matches("collision:").trim_end_matches("/post");
    assert!(held["why"].to_string().contains(&format!("`{link}` keeps clear of `post`")), "{}", held["why"]);
}

/// An answer that was made continuous lies beside the bounds of its rows. One task alone is in no conflict.
#[test]
fn a_single_task_is_told_what_is_in_its_way_in_every_period() {
    let service = Service::start();
    for displacement in [[0.3, 0.0, -0.2], [0.0, 0.4, 0.0], [0.4, 0.0, 0.0]] {
        let obstacles: Vec<Value> = [[0.6, 0.0], [0.4, 0.4]]
            .iter()
            .enumerate()
            .map(|(k, [x, y])| json!({"name": format!("post{k}"), "capsule": {"start": [x, y, 0], "end": [x, y, 1], "radius": 0.05}}))
            .collect();
        let law =
            json!({"kind": "pose", "gain": 3, "target_displacement": {"kind": "constant", "value": displacement}});
        let id = service.open(&json!({"robot": "panda", "period_s": PERIOD, "why": true,
            "collisions": {"min_distance_m": 0.02, "obstacles": obstacles}, "tasks": [{"name": "p", "axes": ["x", "y", "z"], "law": law}]}));
        let (mut q, mut stands) = (HOME.to_vec(), 0);
        for sequence in 0..1000 {
            let answer = service.call(&format!("{id}/step"), &state(sequence, &q));
            q.iter_mut().zip(numbers(&answer["joint_velocity"])).for_each(|(q, speed)| *q += PERIOD * speed);
            let why: Vec<&str> = answer["why"].as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect();
            assert!(!why.contains(&"the tasks are in conflict"), "{sequence}: {why:?}");
            let mut once = why.clone();
            once.sort_unstable();
            once.dedup();
            assert_eq!(once.len(), why.len(), "{sequence}: {why:?}");
            let is_told = why.iter().any(|text| text.contains("keeps clear of") || text.contains("is near `"));
            stands += usize::from(sequence > 500 && is_told);
        }
        assert!(stands > 100, "{displacement:?}: {stands}");
    }
}

#[test]
fn an_obstacle_that_comes_too_near_is_a_reason() {
    let service = Service::start();
    let ball = json!({"name": "ball", "sphere": {"radius": 0.08}, "moves": true});
    let mut controller = controller(json!({"min_distance_m": 0.02, "obstacles": [ball]}));
    controller["why"] = json!(true);
    controller["tasks"] = json!([{"name": "hold", "axes": ["x", "y", "z"], "law": {"kind": "pose", "gain": 2}}]);
    let why = |x: f64, velocity: f64| {
        let mut state = state(1, &HOME);
        state["obstacles"] = json!([{"name": "ball", "position": [x, 0.0, 0.5], "velocity": [velocity, 0.0, 0.0]}]);
        let answer = service.call("/v1/step", &json!({"controller": controller, "state": state}));
        (answer["collisions"]["violated"].clone(), answer["why"].to_string())
    };
    let (violated, sentences) = why(0.752, -2.0);
    assert_eq!(violated, json!(true), "{sentences}");
    assert!(sentences.contains("comes nearer to a shape than `min_distance_m`"), "{sentences}");
    let (violated, sentences) = why(3.0, 0.0);
    assert!(violated == json!(false) && !sentences.contains("min_distance_m"), "{sentences}");
}

#[test]
fn stateless_steps_give_the_commands_of_a_session() {
    let service = Service::start();
    let controller = controller(json!({"obstacles": [post()]}));
    let id = service.open(&controller);
    let (mut q, mut memory) = (HOME.to_vec(), Value::Null);
    for sequence in 1..200 {
        let state = state(sequence, &q);
        let session = service.call(&format!("{id}/step"), &state);
        let stateless = service.call("/v1/step", &json!({"controller": controller, "state": state, "memory": memory}));
        for field in ["joint_velocity", "collisions", "valid_for_ms", "active_inequalities"] {
            assert_eq!(session[field], stateless[field], "{field}, step {sequence}");
        }
        memory = stateless["memory"].clone();
        q.iter_mut().zip(numbers(&session["joint_velocity"])).for_each(|(q, speed)| *q += PERIOD * speed);
    }
}

#[test]
fn what_is_wrong_with_a_room_is_named() {
    let service = Service::start();
    let sphere = |radius: f64| json!({"name": "ball", "sphere": {"radius": radius}});
    let cases = [
        (json!({"min_distance_m": -1}), "/collisions/min_distance_m"),
        (json!({"rate_per_s": 0}), "/collisions/rate_per_s"),
        (json!({"obstacles": [{"name": "ball"}]}), "/collisions/obstacles/0"),
        (json!({"obstacles": [sphere(0.0)]}), "/collisions/obstacles/0/sphere"),
        (json!({"obstacles": [sphere(0.1), sphere(0.1)]}), "/collisions/obstacles/1/name"),
        (json!({"obstacles": [{"name": "", "sphere": {"radius": 1}}]}), "/collisions/obstacles/0/name"),
        (
            json!({"obstacles": [{"name": "floor", "half_space": {"normal": [0, 0, 0], "offset_m": 0}}]}),
            "/collisions/obstacles/0/half_space",
        ),
        (
            json!({"obstacles": [{"name": "floor", "half_space": {"normal": [0, 0, 1], "offset_m": 0}, "moves": true}]}),
            "/collisions/obstacles/0/half_space",
        ),
        (json!({"min_distance_m": 0.9}), "/collisions"),
    ];
    for (collisions, pointer) in cases {
        let refused = service.post("/v1/controllers", &controller(collisions.clone()).to_string());
        assert_eq!(refused.refusal_difference(422, Some(pointer)), None, "{collisions}: {}", refused.text);
    }
    let mut bare = controller(json!({}));
    bare["robot"] = json!("sawyer_dh");
    let refused = service.post("/v1/controllers", &bare.to_string());
    refused.assert_refused(422, Some("/collisions"));
    assert!(refused.text.contains("has no shapes"), "{}", refused.text);
    let link = json!({"obstacles": [{"name": "panda_link5", "sphere": {"radius": 0.1}}]});
    let refused = service.post("/v1/controllers", &controller(link).to_string());
    refused.assert_refused(422, Some("/collisions/obstacles/0/name"));
    let mut closed_form = controller(json!({}));
    closed_form["solver"] = json!("closed_form");
    service.post("/v1/controllers", &closed_form.to_string()).assert_refused(422, Some("/collisions"));
}

#[test]
fn a_state_must_name_each_moving_obstacle() {
    let service = Service::start();
    let id =
        service.open(&controller(json!({"obstacles": [{"name": "ball", "sphere": {"radius": 0.1}, "moves": true}]})));
    let path = format!("{id}/step");
    let with = |obstacles: Value| {
        let mut state = state(1, &HOME);
        state["obstacles"] = obstacles;
        state.to_string()
    };
    let missing = service.post(&path, &with(json!([])));
    missing.assert_refused(422, Some("/obstacles"));
    assert!(missing.text.contains("`ball`"), "{}", missing.text);
    let ball = json!({"name": "ball", "position": [0.4, 0, 0.2]});
    let other = json!({"name": "bat", "position": [0, 0, 0]});
    service.post(&path, &with(json!([ball, other]))).assert_refused(422, Some("/obstacles/1/name"));
    service.post(&path, &with(json!([ball, ball]))).assert_refused(422, Some("/obstacles/1/name"));
    let far = json!({"name": "ball", "position": [1e6, 0, 0]});
    service.post(&path, &with(json!([far]))).assert_refused(422, Some("/obstacles/0"));
    let answer = service.post(&path, &with(json!([ball]))).accepted();
    assert!(answer["collisions"]["pairs"].to_string().contains("ball"));
}

#[test]
fn a_controller_that_watches_no_pair_gives_no_distance() {
    let service = Service::start();
    let id = service.open(&controller(json!({"own_links": false})));
    let answer = service.call(&format!("{id}/step"), &state(1, &HOME));
    assert!(answer["collisions"].get("least_distance_m").is_none(), "{answer}");
}

#[test]
fn a_registration_lists_its_shapes_and_the_pairs_that_are_left_out() {
    let service = Service::start();
    let created = service.post("/v1/robots", &example("robot_shapes.json").to_string());
    assert_eq!(created.status, 201, "{}", created.text);
    let shapes = service.get("/v1/robots/planar-shapes").accepted()["shapes"].clone();
    assert_eq!(
        (&shapes["shape_list"][0]["link"], &shapes["shape_list"][1]["sphere"]["radius"]),
        (&json!("upper"), &json!(0.04))
    );
    assert_eq!(shapes["left_out"][0]["reason"], "neighbours");
    let wrong = |change: &dyn Fn(&mut Value)| {
        let mut registration = example("robot_shapes.json");
        registration["name"] = json!("wrong");
        change(&mut registration);
        service.post("/v1/robots", &registration.to_string()).json()["pointer"].clone()
    };
    assert_eq!(wrong(&|robot| robot["shape_list"][0]["link"] = json!("uper")), "/shape_list/0/link");
    assert_eq!(wrong(&|robot| robot["shape_list"][1] = json!({"link": "tool"})), "/shape_list/1");
    assert_eq!(wrong(&|robot| robot["shape_list"][1]["sphere"]["radius"] = json!(0)), "/shape_list/1");
    assert_eq!(
        wrong(&|robot| robot["collision_pairs"]["leave_out"][0][1] = json!("jaw")),
        "/collision_pairs/leave_out/0/1"
    );
    let panda = service.get("/v1/robots/panda").accepted();
    assert!(panda["shapes"]["watched_pairs"].as_u64().unwrap() >= 15, "{}", panda["shapes"]);
}
