//! Times the steps of `benchmarks/steps.py` in Rust, with `revprio-core` alone: core_step CONTROLLER.json POSITIONS.json
//!
//! Prints the median time of the steps with active limits, µs: of three rounds the smallest time of each step.

use std::error::Error;
use std::time::Instant;

use revprio::service::{Robots, controller};
use revprio_api::wire;
use revprio_core::controller::{Measurement, Stepper};

const ROUNDS: usize = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let mut files = std::env::args().skip(1);
    let mut read = || -> Result<Vec<u8>, Box<dyn Error>> {
        Ok(std::fs::read(files.next().ok_or("usage: core_step CONTROLLER.json POSITIONS.json")?)?)
    };
    let request: wire::Controller = serde_json::from_slice(&read()?)?;
    let positions: Vec<Vec<f64>> = serde_json::from_slice(&read()?)?;
    let mut micros = vec![f64::INFINITY; positions.len()];
    let mut limited = vec![false; positions.len()];
    for _ in 0..ROUNDS {
        let controller = controller(&request, &Robots::built_in()).map_err(|error| error.into_wire().detail)?;
        let mut stepper = Stepper::new(controller)?;
        let mut memory = None;
        for (i, q) in positions.iter().enumerate() {
            let (time_s, joint_position) = (i as f64 * request.period_s, q.clone());
            let start = Instant::now();
            let measurement = Measurement {
                channels: Vec::new(),
                chunks: Vec::new(),
                wrenches: Vec::new(),
                obstacles: Vec::new(),
                time_s,
                joint_position,
                joint_velocity: None,
                wrench: [0.0; 6],
                targets: Vec::new(),
            };
            let command = stepper.step(&mut memory, &measurement)?;
            micros[i] = micros[i].min(start.elapsed().as_secs_f64() * 1e6);
            limited[i] = command.resolution.active_limits().next().is_some();
        }
    }
    let mut times: Vec<f64> = micros.iter().zip(&limited).filter(|(_, limited)| **limited).map(|(t, _)| *t).collect();
    times.sort_by(f64::total_cmp);
    println!("{:.2}", times.get(times.len() / 2).ok_or("no limit is active")?);
    Ok(())
}
