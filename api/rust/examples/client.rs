//! Creates a controller on a service, steps it once and ends it, with the typed HTTP client.
//!
//! Start `revprio serve`, then run `cargo run -p revprio-api --example client [ADDRESS]`.

use std::collections::BTreeMap;

use revprio_api::wire::{Controller, JointVector, State, Wrench};
use revprio_api::{Client, Service};

/// The body that clients in any language send. A program may also build [`Controller`] field by field.
const CONTROLLER: &str = include_str!("../../examples/controller.json");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run(&std::env::args().nth(1).unwrap_or_else(|| "http://127.0.0.1:8080".to_owned()))
}

/// Opens a session, steps it once, and ends it.
pub fn run(address: &str) -> Result<(), Box<dyn std::error::Error>> {
    let client = Client::new(address);
    let controller: Controller = serde_json::from_str(CONTROLLER)?;
    let session = client.create_controller(&controller)?;
    let joint_position = JointVector::Ordered(vec![2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2]);
    let wrench = Some(Wrench { force: [12.5, 0.0, 0.0], torque: [0.0; 3] });
    let state = State {
        channels: BTreeMap::new(),
        wrenches: BTreeMap::new(),
        obstacles: Vec::new(),
        sequence: 1,
        time_s: 0.001,
        joint_position,
        joint_velocity: None,
        wrench,
        targets: BTreeMap::new(),
    };
    let answer = client.step_controller(&session.id, &state)?;
    println!("{:?}\nrad/s: {:.5?}", session.joints, answer.joint_velocity);
    println!("valid for {} ms from the measurement", answer.valid_for_ms);
    client.delete_controller(&session.id)?;
    Ok(())
}
