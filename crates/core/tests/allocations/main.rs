//! After the first few periods a control period allocates nothing: every kind of task, law, limit, constraint and method.
//! `exceptions.rs` counts what allocates nevertheless.

use allocation_counter::measure;
use revprio_core::controller::Limits;
use revprio_core::limits::LimitKind;

use arm::{Arm, config, push_and_hold};

mod arm;
mod bounds;
mod exceptions;
mod methods;
#[path = "../solvers/mod.rs"]
mod solvers;
mod streams;
mod tasks;

#[test]
fn the_first_step_allocates_and_is_counted() {
    let mut arm = Arm::new(config(Limits::Robot(LimitKind::Velocity), push_and_hold()));
    let counted = measure(|| drop(arm.stepper.step(&mut arm.memory, &arm.measured).cloned()));
    assert!(counted.count_total > 10);
}
