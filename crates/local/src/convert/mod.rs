//! Conversion of bodies to the types of the library and back. An error names the wrong field by its JSON pointer.
//!
//! A function that reads a part of a body names the field inside that part. Its caller adds the place of the part with
//! `inside`, or `each` for a list. Pointers are therefore built only for errors. Building them in advance took half of
//! the time of reading a controller.

mod arm;
mod channels;
mod checks;
mod chunks;
mod collisions;
mod contact;
mod control;
mod controller;
mod environment;
mod inequalities;
mod kinematics;
mod memory;
mod null_space;
mod numbers;
mod outcome;
mod payload;
mod pose;
mod profile;
mod resolve;
mod resolve_task;
mod rest_memory;
mod robot;
mod simulation;
mod solver;
mod stability;
mod step;
mod target_memory;
mod target_values;
mod targets;
mod task;
mod terms;
mod virtual_arm_memory;
mod wrench_sensor;
mod wrenches;

pub use arm::{arm_view, finite, single};
pub use collisions::{RATE_PER_S, shapes_answer, with_shapes};
pub use control::{MAX_SPEED, MAX_STEPS, MIN_SPEED, check_control, check_interactive};
pub use controller::{CHARACTERISTIC_LENGTH_M, MAX_LAG_S, MAX_TASKS, MAX_VALID_FOR_MS, controller, state_rules};
pub use environment::MAX_ENVIRONMENT_DELAY;
pub use inequalities::MAX_INEQUALITIES;
pub use kinematics::kinematics;
pub use memory::{last_state, memory, memory_answer};
pub use numbers::{MAX_MAGNITUDE, MAX_REMEMBERED, MAX_TIME_S, MIN_INERTIA, joint_vector};
pub use payload::identify as payload;
pub use profile::MAX_POINTS;
pub use resolve::{MAX_PERIOD_S, MIN_PERIOD_S, ResolveProblem, resolution_error, resolve_answer, resolve_problem};
pub use resolve_task::MAX_ROWS;
pub use robot::{
    MAX_TIPS, check_tip_names, frames_of_srdf, overrides, registered_tips, robot, robot_answer, robots_error,
};
pub use simulation::{metrics_answer, scenario};
pub use stability::{NOT_COMPUTABLE, contact_loop, margin, margin_answer};
pub use step::{
    MAX_SEQUENCE, check_sequence, measurement, step_answer, step_error, transition_error, valid_for_ms, watched_step,
};
pub use wrench_sensor::{MAX_FILTER_S, MAX_PAYLOAD_KG, MAX_READINGS, tared};
