//! Resolves prioritised tasks at one posture into joint velocities, without a server.
//!
//! Run with `cargo run -p revprio-core --example library`.

use revprio_core::linalg::Vector;
use revprio_core::resolution::{Problem, resolve};
use revprio_core::robot::built_in;
use revprio_core::robot::kinematics::{Axis, AxisSelection, Configuration};
use revprio_core::task::{Task, TaskStack};

/// Moves the tool along x at 0.05 m/s and holds the other axes.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sawyer = &built_in()[0];
    let configuration = Configuration::new(sawyer, &[2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2])?;
    let rows = |axes: &[Axis]| AxisSelection::new(axes).map(|axes| axes.rows_of(configuration.jacobian()));
    let push = Task::new("push", rows(&[Axis::X])?, Vector::from_vec(vec![0.05]));
    let hold = Task::new("hold", rows(&[Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz])?, Vector::zeros(5));
    let answer = resolve(&Problem::new(TaskStack::new(vec![push, hold])?), &[])?;
    println!("joint velocities, rad/s: {:.4?}", answer.joint_velocity.as_slice());
    Ok(())
}
