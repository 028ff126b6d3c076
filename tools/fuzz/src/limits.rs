//! The speed limits that a request states.

use std::sync::{Arc, OnceLock};

use revprio_api::wire::{Controller, LimitKind, Limits, ResolveRequest, Solver};
use revprio_robot::{RobotModel, built_in};

/// Relative rounding error of a command at a limit.
const ROUNDING: f64 = 1e-9;

/// Lower and upper speed limits, one pair per joint.
pub type SpeedLimits = Vec<(f64, f64)>;

/// Returns a built-in robot.
pub fn known_robot(name: &str) -> Option<&'static Arc<RobotModel>> {
    static ROBOTS: OnceLock<Vec<Arc<RobotModel>>> = OnceLock::new();
    ROBOTS.get_or_init(|| built_in().to_vec()).iter().find(|robot| robot.name() == name)
}

/// Returns the number of joints of a built-in robot, or the largest one of the built-in robots.
pub fn joint_count(robot: &str) -> usize {
    known_robot(robot).map_or(7, |robot| robot.joint_count())
}

/// Returns the speed limits of a problem; `None` if it has none that the solver respects.
pub fn of_problem(request: &ResolveRequest) -> Option<SpeedLimits> {
    let robot = request.robot.as_deref().and_then(known_robot);
    let default = robot.map(|_| Limits::Robot(LimitKind::Velocity));
    let limits = request.limits.clone().or(default)?;
    of(&limits, request.solver, robot)
}

/// Returns the speed limits of a controller; `None` if it has none that the solver respects.
pub fn of_controller(controller: &Controller) -> Option<SpeedLimits> {
    of(&controller.limits, controller.solver, known_robot(&controller.robot))
}

fn of(limits: &Limits, solver: Solver, robot: Option<&Arc<RobotModel>>) -> Option<SpeedLimits> {
    match limits {
        _ if solver == Solver::ClosedForm => None,
        Limits::Robot(kind) if !kind.includes_velocity() => None,
        Limits::Robot(_) => {
            let joints = robot?.joints().iter();
            Some(joints.map(|joint| (-joint.limits.velocity, joint.limits.velocity)).collect())
        }
        Limits::Box { lower, upper } => Some(lower.iter().copied().zip(upper.iter().copied()).collect()),
    }
}

/// Returns how a command leaves its limits; `None` if it does not.
pub fn violation(command: &[f64], limits: &SpeedLimits) -> Option<String> {
    if command.len() != limits.len() {
        return Some(format!("{} joint velocities for {} limits", command.len(), limits.len()));
    }
    let outside = |(joint, (velocity, (lower, upper))): (usize, (&f64, &(f64, f64)))| {
        let slack = |bound: f64| ROUNDING * bound.abs().max(1.0);
        let is_inside = *velocity >= lower - slack(*lower) && *velocity <= upper + slack(*upper);
        (!is_inside).then(|| format!("joint {joint} moves at {velocity:e}, outside {lower:e} to {upper:e}"))
    };
    command.iter().zip(limits).enumerate().find_map(outside)
}
