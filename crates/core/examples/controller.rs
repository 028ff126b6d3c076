//! Controls an arm in a loop: a measured state in, a command out, a thousand times per second, without a server.
//!
//! The tool pushes against a spring of 1000 N/m until it measures 30 N. Run with
//! `cargo run -p revprio-core --example controller`.

use std::sync::Arc;

use revprio_core::controller::{Controller, ControllerConfig, Measurement, Stepper, TaskConfig};
use revprio_core::law::{ForceLaw, Gains, Law, Profile};
use revprio_core::robot::built_in;
use revprio_core::robot::kinematics::{Axis, AxisSelection, Configuration};
use revprio_core::rows::{TaskRows, ToolRows};
use revprio_core::streaming::Streaming;

/// Pushes for three seconds with an arm that follows its commands exactly.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (sawyer, period) = (Arc::clone(&built_in()[0]), 0.001);
    let gains = Gains::new(1, &[15.0], &[150.0], &[0.0])?; // kg, N·s/m, N/m
    let law = ForceLaw::new(gains, Profile::constant(vec![30.0])?).ok_or("gains and force differ in size")?;
    let rows = TaskRows::Tool(ToolRows::new(AxisSelection::new(&[Axis::X])?));
    let push = TaskConfig {
        name: "push".to_owned(),
        rows,
        law: Law::Force(law),
        scaled: false,
        streaming: Streaming::default(),
    };
    let controller = Controller::new(ControllerConfig::new(Arc::clone(&sawyer), period, vec![push]))?;
    let mut stepper = Stepper::new(controller)?;

    let mut q = vec![2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2]; // rad
    let surface = Configuration::new(&sawyer, &q)?.tool_pose().translation.x;
    let (mut memory, mut force) = (None, 0.0);
    for cycle in 0..3000 {
        force = 1000.0 * (Configuration::new(&sawyer, &q)?.tool_pose().translation.x - surface);
        let wrench = [force, 0.0, 0.0, 0.0, 0.0, 0.0]; // of the tool on the environment
        let time_s = period * f64::from(cycle);
        let measured = Measurement {
            channels: Vec::new(),
            chunks: Vec::new(),
            wrenches: Vec::new(),
            obstacles: Vec::new(),
            time_s,
            joint_position: q.clone(),
            joint_velocity: None,
            wrench,
            targets: Vec::new(),
        };
        let command = stepper.step(&mut memory, &measured)?;
        q.iter_mut().zip(&command.resolution.joint_velocity).for_each(|(q, speed)| *q += period * speed);
    }
    println!("force after 3 s: {force:.2} N");
    Ok(())
}
