//! Bodies to the library's types and back; wrong fields are named by JSON pointer.

mod controller;
mod environment;
mod inequalities;
mod memory;
mod null_space;
mod numbers;
mod outcome;
mod pose;
mod profile;
mod resolve;
mod robot;
mod stability;
mod step;
mod task;
mod terms;

pub use controller::controller;
pub use environment::warnings;
pub use memory::{memory, memory_answer};
pub use resolve::{question, resolution_problem, resolve_answer};
pub use robot::{robot, robot_answer, robots_problem};
pub use stability::{contact_loop, margin_answer};
pub use step::{measurement, step_answer, step_problem};
