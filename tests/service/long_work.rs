//! Long work, while the service answers steps.

use std::time::Duration;

use serde_json::{Value, json};

use crate::harness::{Service, example};

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
