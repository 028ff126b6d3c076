//! Long work, while the service answers steps.

use std::time::Duration;

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
        assert!((1..=4).contains(&refused.len()), "{} refused", refused.len());
        for answer in refused {
            answer.assert_refused(503, None);
        }
    });
}
