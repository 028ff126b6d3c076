//! `POST /v1/simulations/{id}/control`.

use revprio_api::wire;
use revprio_core::controller::Controller;
use revprio_lab::number::Exact;

use super::checks::{Result, check};
use super::numbers::{between, check_numbers};
use super::targets::{check_times, targets};
use crate::error::{ApiError, escape_pointer};

/// Minimum speed of an interactive run, simulated seconds per second.
pub const MIN_SPEED: f64 = 0.001;
/// Maximum speed of an interactive run, simulated seconds per second.
pub const MAX_SPEED: f64 = 1000.0;

/// Maximum number of control periods in one step of an interactive run.
pub const MAX_STEPS: usize = 100_000;

/// Checks a speed.
fn check_speed(speed: f64, pointer: &str) -> Result<()> {
    let detail = format_args!("{} is out of range; give a speed from {MIN_SPEED} to {MAX_SPEED}", Exact(speed));
    between(speed, MIN_SPEED..=MAX_SPEED, pointer, detail).map(drop)
}

/// Checks the speed of an interactive run.
pub fn check_interactive(interactive: Option<&wire::Interactive>) -> Result<()> {
    interactive.map_or(Ok(()), |interactive| check_speed(interactive.speed, "/interactive/speed"))
}

/// Checks the fields of a command to a run with this controller.
pub fn check_control(command: &wire::SimulationControl, controller: &Controller) -> Result<()> {
    command.speed.map_or(Ok(()), |speed| check_speed(speed, "/speed"))?;
    let is_possible = command.step.is_none_or(|step| (1..=MAX_STEPS as u64).contains(&step));
    check(is_possible, "/step", format_args!("give 1 to {MAX_STEPS} control periods"))?;
    let goes_on = command.step.is_some() && command.paused == Some(false);
    check(!goes_on, "/step", "a run pauses after a step; omit `paused`")?;
    if let Some((name, _)) = command.targets.iter().find(|(_, target)| target.time_s.is_some()) {
        let pointer = format!("/targets/{}/time_s", escape_pointer(name));
        return Err(ApiError::invalid(pointer, "omit it; the target belongs to the next state"));
    }
    if let Some((name, _)) = command.targets.iter().find(|(_, target)| target.chunk.is_some()) {
        let pointer = format!("/targets/{}/chunk", escape_pointer(name));
        return Err(ApiError::invalid(
            pointer,
            "a run takes single targets; send chunks with the states of a controller",
        ));
    }
    let (found, _) = targets(&command.targets, 0.0, controller)?;
    check_times(&found, 0.0, controller)?;
    command.external_force.map_or(Ok(()), |force| check_numbers(&force, "/external_force"))
}
