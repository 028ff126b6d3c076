//! Hard problems: every answer is finite and inside the limits.

use serde_json::{Value, json};

use crate::harness::{Service, example, numbers};

const METHODS: [&str; 6] = [
    "pseudoinverse",
    "damped_least_squares",
    "task_priority",
    "singularity_robust",
    "reverse_priority",
    "strict_reverse_priority",
];

/// Solvers that respect limits.
const SOLVERS: [&str; 2] = ["auto", "qp"];

/// Rounding error of the last operation on a limit.
const ROUNDING: f64 = 1e-12;

/// Returns irregular numbers in −1 … 1.
fn scattered(count: usize, seed: usize) -> Vec<f64> {
    (0..count).map(|i| ((i * i + 13 * i * seed + 7 * seed) as f64 * 12.9898).sin()).collect()
}

/// Returns a problem with explicit Jacobian rows, with entries up to `scale`.
fn explicit_rows(tasks: usize, rows: usize, joints: usize, scale: f64) -> Value {
    let row = |seed: usize| scattered(joints, seed).iter().map(|entry| entry * scale).collect::<Vec<_>>();
    let task = |k: usize| {
        let jacobian: Vec<_> = (0..rows).map(|i| row(1 + k * rows + i)).collect();
        json!({"jacobian": jacobian, "velocity": scattered(rows, 100 + k)})
    };
    json!({"tasks": (0..tasks).map(task).collect::<Vec<_>>()})
}

/// Replaces the velocities of every other task by bounds of this width around them. Every third row has no upper bound.
fn with_bounds(mut problem: Value, width: f64) -> Value {
    for task in problem["tasks"].as_array_mut().unwrap().iter_mut().step_by(2) {
        let velocity = numbers(&task["velocity"]);
        let upper = |(row, velocity): (usize, &f64)| (row % 3 != 2).then_some(velocity + width);
        task["lower"] = velocity.iter().map(|velocity| velocity - width).collect();
        task["upper"] = json!(velocity.iter().enumerate().map(upper).collect::<Vec<_>>());
        task.as_object_mut().unwrap().remove("velocity");
    }
    problem
}

/// Resolves with every method and solver. Asserts that each answer has finite numbers inside ±`limit`.
fn assert_always_safe(service: &Service, problem: &Value, joints: usize, limit: f64) {
    for (method, solver) in METHODS.iter().flat_map(|method| SOLVERS.map(|solver| (method, solver))) {
        let mut problem = problem.clone();
        (problem["method"], problem["solver"]) = (json!(method), json!(solver));
        problem["limits"] = json!({"lower": vec![-limit; joints], "upper": vec![limit; joints]});
        let answer = service.call("/v1/resolve", &problem);
        let context = format!("{method}, {solver}, {answer}");
        let velocity = numbers(&answer["joint_velocity"]);
        assert!(velocity.len() == joints && velocity.iter().all(|v| v.abs() <= limit + ROUNDING), "{context}");
        assert!(answer["violated_limits"].as_array().unwrap().is_empty(), "{context}");
        assert_finite(&answer, &context);
    }
}

/// Asserts that all numbers are finite: JSON writes infinity and NaN as `null`.
fn assert_finite(answer: &Value, context: &str) {
    let uncertain = answer["solver"]["status"] != "optimal";
    assert!(uncertain || !answer["solver"]["kkt_residual"].is_null(), "{context}");
    let rest = crate::harness::without(answer.clone(), &["solver"]).to_string();
    assert!(!rest.contains("null"), "{context}");
}

#[test]
fn zero_limits_allow_only_zero_velocity() {
    let service = Service::start();
    assert_always_safe(&service, &example("resolve.json"), 7, 0.0);
    assert_always_safe(&service, &explicit_rows(3, 2, 5, 1.0), 5, 0.0);
}

#[test]
fn singular_postures_are_resolved() {
    let service = Service::start();
    let singular = [0.521, 1.867, 0.793, -0.671, 0.707, -2.336, -0.273];
    for posture in [[0.0; 7], singular, [1e9; 7], [std::f64::consts::FRAC_PI_2; 7]] {
        let mut problem = example("resolve.json");
        problem["joint_position"] = json!(posture);
        assert_always_safe(&service, &problem, 7, 1.0);
    }
}

#[test]
fn one_joint_and_thirty_joints_are_resolved() {
    let service = Service::start();
    for (tasks, rows, joints) in [(1, 1, 1), (3, 2, 1), (1, 40, 30), (5, 4, 30), (1, 1, 32)] {
        for limit in [0.01, 100.0] {
            assert_always_safe(&service, &explicit_rows(tasks, rows, joints, 1.0), joints, limit);
        }
    }
}

#[test]
fn sixty_four_tasks_are_resolved() {
    let service = Service::start();
    assert_always_safe(&service, &explicit_rows(64, 1, 7, 1.0), 7, 0.1);
    assert_always_safe(&service, &explicit_rows(64, 1, 7, 1.0), 7, 0.0);
}

#[test]
fn rows_of_any_magnitude_give_finite_answers() {
    let service = Service::start();
    for scale in [0.0, 5e-324, 1e-300, 1e-160, 1e-20, 1e9] {
        assert_always_safe(&service, &explicit_rows(2, 2, 4, scale), 4, 1.0);
    }
    assert_always_safe(&service, &explicit_rows(1, 32, 32, 1e9), 32, 1.0);
    assert_always_safe(&service, &explicit_rows(1, 32, 32, 1e-9), 32, 1.0);
}

#[test]
fn bounds_of_any_width_on_rows_of_any_magnitude_give_finite_answers() {
    let service = Service::start();
    for scale in [0.0, 5e-324, 1e-300, 1e-160, 1e-20, 1.0, 1e9] {
        for width in [0.0, 1e-300, 1e-9, 1.0, 9e8] {
            let problem = with_bounds(explicit_rows(3, 3, 4, scale), width);
            assert_always_safe(&service, &problem, 4, 1.0);
        }
    }
    for width in [0.0, 0.1] {
        assert_always_safe(&service, &with_bounds(explicit_rows(64, 1, 7, 1.0), width), 7, 0.1);
        assert_always_safe(&service, &with_bounds(explicit_rows(5, 4, 30, 1.0), width), 30, 0.01);
        assert_always_safe(&service, &with_bounds(explicit_rows(3, 40, 128, 1.0), width), 128, 1.0);
    }
}

#[test]
fn repeated_and_contradictory_bounds_are_resolved() {
    let service = Service::start();
    let task = |row: [f64; 3], lower: f64, upper: f64| json!({"jacobian": [row], "lower": [lower], "upper": [upper]});
    let row = [1.0, 2.0, -1.0];
    let nearly = [1.0, 2.0, -1.0 + 1e-13];
    let (above, below, zero) = (task(row, 1.0, 2.0), task(nearly, -2.0, -1.0), task([0.0; 3], 1.0, 2.0));
    let exact = json!({"jacobian": [row], "velocity": [1.0]});
    for tasks in [json!([above, below, zero]), json!([exact, below, above, exact, zero]), json!([zero, above, exact])] {
        for limit in [0.1, 1e9] {
            assert_always_safe(&service, &json!({"tasks": tasks}), 3, limit);
        }
    }
}

#[test]
fn repeated_and_contradictory_rows_are_resolved() {
    let service = Service::start();
    let task = |row: [f64; 3], velocity: f64| json!({"jacobian": [row], "velocity": [velocity]});
    let row = [1.0, 2.0, -1.0];
    let nearly = [1.0, 2.0, -1.0 + 1e-13];
    let problem = json!({"tasks": [task(row, 1.0), task(row, -1.0), task(nearly, 5.0), task([0.0; 3], 1.0)]});
    for limit in [0.1, 1e9] {
        assert_always_safe(&service, &problem, 3, limit);
    }
}

#[test]
fn the_closed_form_is_finite_and_lists_violated_limits() {
    let service = Service::start();
    for scale in [0.0, 5e-324, 1e-300, 1e-160, 1e9] {
        let mut problem = explicit_rows(2, 2, 4, scale);
        problem["solver"] = json!("closed_form");
        let answer = service.call("/v1/resolve", &problem);
        assert_finite(&answer, &answer.to_string());
    }
    let mut problem = example("resolve.json");
    problem["solver"] = json!("closed_form");
    problem["limits"] = json!({"lower": vec![0; 7], "upper": vec![0; 7]});
    assert!(!service.call("/v1/resolve", &problem)["violated_limits"].as_array().unwrap().is_empty());
}

#[test]
fn a_controller_stays_inside_its_limits_for_any_measurement() {
    let service = Service::start();
    let mut controller = example("controller.json");
    controller["state_checks"] = json!({"position_tolerance": 1e9});
    for limits in ["velocity", "position_velocity", "position_velocity_acceleration"] {
        controller["limits"] = json!(limits);
        let address = format!("{}/step", service.open(&controller));
        for sequence in 0..60_usize {
            let size = [1e0, 1e3, 1e6, 1e9][sequence % 4];
            let wild: Vec<_> = scattered(7, 3 + sequence).iter().map(|entry| entry * size).collect();
            let force = [size, -size, 0.0];
            let state = json!({"sequence": sequence, "time_s": size, "joint_position": wild, "joint_velocity": wild,
                "wrench": {"force": force, "torque": force}});
            let velocity = numbers(&service.call(&address, &state)["joint_velocity"]);
            // The fastest joint of the arm may move at 4.545 rad/s.
            assert!(velocity.iter().all(|v| v.abs() <= 4.545 + ROUNDING), "{limits}, {state}: {velocity:?}");
        }
    }
}
