//! Work that takes long, beside the steps of others.

use std::time::Duration;

use serde_json::{Value, json};

use crate::harness::{Service, example};

/// Takes a second or so: the cost of a margin grows with the cube of the delay.
fn long_margin() -> Value {
    let mut request = example("stability.json");
    (request["delay_periods"], request["damping"]) = (json!(64), json!(1e4));
    request
}

#[test]
fn steps_are_answered_while_a_margin_is_computed() {
    let service = Service::start();
    std::thread::scope(|scope| {
        let margin = scope.spawn(|| service.ask("/v1/stability", &long_margin()));
        std::thread::sleep(Duration::from_millis(50));
        let mut steps = 0;
        while !margin.is_finished() {
            service.ask("/v1/step", &example("step.json"));
            steps += 1;
        }
        assert!(margin.join().unwrap()["spectral_radius"].is_number());
        // On the thread of the steps it would have held up the first one until its own end.
        assert!(steps > 3, "{steps} steps while the margin was computed");
    });
}

#[test]
fn more_margins_than_there_is_room_for_are_refused_at_once() {
    let service = Service::start();
    std::thread::scope(|scope| {
        let ask = || service.post("/v1/stability", &long_margin().to_string());
        let asked: Vec<_> = (0..12).map(|_| scope.spawn(ask)).collect();
        let answers: Vec<_> = asked.into_iter().map(|answer| answer.join().unwrap()).collect();
        let refused: Vec<_> = answers.iter().filter(|answer| answer.status != 200).collect();
        assert!((1..=4).contains(&refused.len()), "{} refused", refused.len());
        for answer in refused {
            answer.assert_refused(503, None);
        }
    });
}
