//! Bodies to the library's types and back; wrong fields are named by JSON pointer.

mod controller;
mod environment;
mod inequalities;
mod kinematics;
mod memory;
mod null_space;
mod numbers;
mod outcome;
mod pose;
mod profile;
mod resolve;
mod robot;
mod simulation;
mod stability;
mod step;
mod task;
mod terms;

pub use controller::controller;
pub use environment::warnings;
pub use kinematics::kinematics;
pub use memory::{memory, memory_answer};
pub use resolve::{question, resolution_problem, resolve_answer};
pub use robot::{robot, robot_answer, robots_problem};
pub use simulation::{metrics_answer, scenario};
pub use stability::{contact_loop, margin_answer};
pub use step::{measurement, step_answer, step_problem};
