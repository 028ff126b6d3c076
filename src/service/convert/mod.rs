//! Bodies to the library's types and back; wrong fields are named by JSON pointer.

mod controller;
mod kinematics;
mod memory;
mod numbers;
mod outcome;
mod resolve;
mod robot;
mod simulation;
mod stability;
mod step;
mod terms;

pub use controller::controller;
pub use kinematics::kinematics;
pub use memory::{memory, memory_answer};
pub use resolve::{question, resolution_problem, resolve_answer};
pub use robot::robot_answer;
pub use simulation::{metrics_answer, scenario};
pub use stability::{contact_loop, margin_answer};
pub use step::{measurement, step_answer, step_problem};
