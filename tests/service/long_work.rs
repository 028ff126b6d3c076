//! Long work, while the service answers steps.

use std::time::Duration;

use revprio::service::ServiceConfig;
use serde_json::{Value, json};

use crate::harness::{Service, example, numbers};

/// Returns a request that takes about one second: the cost of a margin grows with the cube of the delay.
fn long_margin() -> Value {
    let mut request = example("stability.json");
    (request["delay_periods"], request["damping"]) = (json!(64), json!(1e4));
    request
}

#[test]
fn steps_are_answered_while_a_margin_is_computed() {
    let service = Service::start();
    std::thread::scope(|scope| {
        let margin = scope.spawn(|| service.call("/v1/stability", &long_margin()));
        std::thread::sleep(Duration::from_millis(50));
        let mut steps = 0;
        while !margin.is_finished() {
            service.call("/v1/step", &example("step.json"));
            steps += 1;
        }
        assert!(margin.join().unwrap()["spectral_radius"].is_number());
        // On the thread of the steps, the margin would delay the first step until its own end.
        assert!(steps > 3, "{steps} steps while the margin was computed");
    });
}

/// Large states are decoded on another thread, and not on the one that checks new controllers.
#[test]
fn large_states_do_not_wait_for_new_controllers() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    let state = |step: u32| {
        let mut state = example("state.json");
        (state["sequence"], state["time_s"]) = (json!(step), json!(0.001 * f64::from(step)));
        state.to_string() + &" ".repeat(20_000)
    };
    let mut slow = example("controller.json");
    let stiff = json!({"stiffness": 1e6, "inertia": 1});
    slow["environment"] = json!({"x": stiff, "y": stiff, "z": stiff, "lag_s": 0.05, "delay_periods": 8});
    std::thread::scope(|scope| {
        let created: Vec<_> =
            (0..24).map(|_| scope.spawn(|| service.post("/v1/controllers", &slow.to_string()).accepted())).collect();
        let mut steps = 0;
        while !created.iter().all(std::thread::ScopedJoinHandle::is_finished) {
            let answer = service.post(&format!("{session}/step"), &state(steps));
            assert!(answer.accepted()["joint_velocity"].is_array());
            steps += 1;
        }
        assert!(steps > 24, "{steps} steps while 24 controllers were checked");
    });
}

/// Returns 512 rows for 128 joints with all digits: equations for some joints, bounds for all.
fn largest_problem() -> Value {
    let mut bits = 1_u64;
    let mut random = || {
        bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut rows = |count: usize| (0..count).map(|_| (0..128).map(|_| random()).collect()).collect::<Vec<Vec<f64>>>();
    json!({"tasks": [
        {"name": "bounds", "jacobian": rows(416), "lower": vec![-1.0; 416], "upper": vec![1.0; 416]},
        {"name": "equations", "jacobian": rows(96), "velocity": vec![0.2; 96]}
    ]})
}

#[test]
fn the_largest_problem_is_solved_while_steps_are_answered() {
    let service = Service::start();
    let body = largest_problem().to_string();
    assert!(body.len() > 1 << 20, "{} bytes", body.len());
    std::thread::scope(|scope| {
        let answer = scope.spawn(|| service.post("/v1/resolve", &body).accepted());
        let mut steps = 0;
        while !answer.is_finished() {
            service.call("/v1/step", &example("step.json"));
            steps += 1;
        }
        assert!(steps > 3, "{steps} steps while the problem was solved");
        let answer = answer.join().unwrap();
        assert_eq!(numbers(&answer["joint_velocity"]).len(), 128);
        let achieved = numbers(&answer["tasks"][0]["achieved"]);
        assert!(achieved.len() == 416 && achieved.iter().all(|speed| speed.abs() <= 1.0 + 1e-6));
        assert_eq!(answer["solver"]["status"], "optimal");
    });
}

#[test]
fn margins_above_the_quota_are_refused_at_once() {
    let service = Service::start();
    std::thread::scope(|scope| {
        let call = || service.post("/v1/stability", &long_margin().to_string());
        let calls: Vec<_> = (0..12).map(|_| scope.spawn(call)).collect();
        let answers: Vec<_> = calls.into_iter().map(|answer| answer.join().unwrap()).collect();
        let refused: Vec<_> = answers.iter().filter(|answer| answer.status != 200).collect();
        // On a busy machine, admitted ones may miss their deadline as well.
        let above_the_quota = refused.iter().filter(|answer| answer.text.contains("/problems/busy")).count();
        assert!((1..=4).contains(&above_the_quota), "{above_the_quota} of {} refused", refused.len());
        for answer in refused {
            answer.assert_refused(503, None);
        }
    });
}

/// Returns the URDF of a chain of joints about changing axes.
fn chain(joints: usize) -> String {
    let link = |i: usize| format!(r#"<link name="l{i}"/>"#);
    let joint = |i: usize| {
        let axis = ["1 0 0", "0 1 0", "0 0 1"][i % 3];
        format!(
            r#"<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{}"/><origin xyz="0.1 0 0.1"/>
            <axis xyz="{axis}"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>"#,
            i + 1
        )
    };
    let parts: String = (0..=joints).map(link).chain((0..joints).map(joint)).collect();
    format!("<robot name=\"chain\">{parts}</robot>")
}

#[test]
fn a_step_above_the_budget_runs_elsewhere_with_the_same_answer() {
    const JOINTS: usize = 60;
    let service = Service::start();
    let registered = service.post("/v1/robots", &json!({"name": "chain", "urdf": chain(JOINTS)}).to_string());
    assert_eq!(registered.status, 201, "{}", registered.text);
    let push = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": 0.5}});
    let controller = json!({"robot": "chain", "period_s": 0.01, "limits": "velocity", "tasks": [
        {"name": "tool", "axes": ["x", "y", "z"], "law": push},
        {"name": "turn", "axes": ["rx", "ry", "rz"], "law": push},
        {"name": "rest", "law": {"kind": "posture", "gain": 1, "target_position": {"kind": "constant", "value": 0.3}}}
    ]});
    let session = service.open(&controller);
    let state = json!({"sequence": 0, "time_s": 0, "joint_position": vec![0.1; JOINTS],
        "wrench": {"force": [0, 0, 0], "torque": [0, 0, 0]}});
    std::thread::scope(|scope| {
        let steps = scope.spawn(|| {
            let mut answers = (0..20).map(|sequence| {
                let mut state = state.clone();
                state["sequence"] = json!(sequence);
                service.call(&format!("{session}/step"), &state)
            });
            answers.next_back().unwrap()
        });
        // Every route that looks at sessions waits for their steps without holding the others up.
        while !steps.is_finished() {
            assert_eq!(service.get("/v1/controllers").accepted()["controllers"].as_array().unwrap().len(), 1);
            service.get(&session).accepted();
            service.call("/v1/step", &example("step.json"));
        }
        steps.join().unwrap();
    });
    let fresh = format!("{}/step", service.open(&controller));
    let stateless = json!({"controller": controller, "state": state});
    let velocity = |path: &str, body: &Value| service.call(path, body)["joint_velocity"].clone();
    assert_eq!(velocity(&fresh, &state), velocity("/v1/step", &stateless));
}

#[test]
fn work_that_misses_its_deadline_is_refused() {
    let config = ServiceConfig { work_timeout: Duration::from_millis(1), ..ServiceConfig::default() };
    let service = Service::with(config);
    let answer = service.post("/v1/stability", &long_margin().to_string());
    answer.assert_refused(503, None);
    assert_eq!(answer.json()["type"], "/problems/deadline");
    assert_eq!(answer.header("retry-after"), Some("1"));
    service.call("/v1/step", &example("step.json"));
}

/// Clarabel needs seconds for tens of levels with hundreds of rows that cannot be kept: several times the deadline, and more than all attempts
/// afterwards together.
#[test]
fn abandoned_work_of_the_solver_qp_does_not_keep_others_waiting() {
    let config = ServiceConfig { work_timeout: Duration::from_millis(300), ..ServiceConfig::default() };
    let service = Service::with(config);
    let entry = |seed: usize| (seed as f64 * 12.9898).sin();
    let row = |seed: usize| (0..32).map(|j| entry(32 * seed + j * j)).collect::<Vec<_>>();
    let task = |k: usize| {
        let jacobian: Vec<_> = (0..8).map(|i| row(8 * k + i)).collect();
        json!({"jacobian": jacobian, "lower": vec![0.2; 8], "upper": vec![0.3; 8]})
    };
    let problem = |tasks: usize| {
        let limits = json!({"lower": vec![-0.05; 32], "upper": vec![0.05; 32]});
        json!({"solver": "qp", "tasks": (0..tasks).map(task).collect::<Vec<_>>(), "limits": limits}).to_string()
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let answer = service.post("/v1/resolve", &problem(64));
                answer.assert_refused(503, None);
                assert_eq!(answer.json()["type"], "/problems/deadline");
            });
        }
    });
    // On a busy machine, a thread needs some time for the call of Clarabel that it is in.
    let mut attempts = (0..5).map(|_| service.post("/v1/resolve", &problem(1)).status);
    assert!(attempts.any(|status| status == 200), "the abandoned work goes on");
}
