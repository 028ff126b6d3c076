//! Bodies to the library's types and back; wrong fields are named by JSON pointer.
//!
//! What reads a part names the field inside that part; who called it says where the part stands, by `ApiError::inside`. So
//! pointers are put together for refusals only: made beforehand, they were half of the cost of reading a controller.

mod arm;
mod control;
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

pub use arm::{arm_view, finite, single};
pub use control::{FASTEST, MOST_STEPS, SLOWEST, changed_controller, control, interactive};
pub use controller::{MOST_TASKS, controller};
pub use environment::{LONGEST_STATED_DELAY, warnings};
pub use inequalities::MOST_INEQUALITIES;
pub use kinematics::kinematics;
pub use memory::{memory, memory_answer};
pub use numbers::LARGEST;
pub use profile::MOST_POINTS;
pub use resolve::{
    LONGEST_PERIOD_S, MOST_JOINTS, MOST_ROWS, SHORTEST_PERIOD_S, question, resolution_problem, resolve_answer,
};
pub use robot::{robot, robot_answer, robots_problem};
pub use simulation::{metrics_answer, scenario};
pub use stability::{contact_loop, margin, margin_answer};
pub use step::{LARGEST_SEQUENCE, measurement, step_answer, step_problem, watched_step};
