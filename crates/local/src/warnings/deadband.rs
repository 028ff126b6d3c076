//! Warnings about a deadband that hides the force which a law presses with.

use revprio_api::wire::{self, Axis, Law, Profile};

/// Share of a target force that a deadband may hide.
const HIDDEN: f64 = 0.5;

/// Returns a warning for each row whose constant target force is not well above the deadband of the sensor at the tool.
pub fn warnings(request: &wire::Controller) -> impl Iterator<Item = String> {
    let sensor = request.wrench_sensor.unwrap_or_default();
    request.tasks.iter().filter(|task| task.link.is_none()).flat_map(move |task| {
        let axes = task.axes.iter().flatten().enumerate();
        axes.filter_map(move |(row, axis)| {
            let target = target(task.law.as_ref()?, row)?.abs();
            let is_angular = matches!(axis, Axis::Rx | Axis::Ry | Axis::Rz);
            let (deadband, unit) = if is_angular { (sensor.deadband_nm, "N·m") } else { (sensor.deadband_n, "N") };
            (deadband > HIDDEN * target).then(|| {
                format!(
                    "task `{}`, axis {axis}: the deadband of {deadband} {unit} of the sensor hides most of the target of {target} {unit}, so \
                     the law presses with up to {} {unit}, and without an end if the deadband exceeds what the contact gives; state a \
                     smaller deadband",
                    task.name,
                    deadband + target
                )
            })
        })
    })
}

/// Returns the constant target force of a row of a law that controls force and does not know the deadband.
fn target(law: &Law, row: usize) -> Option<f64> {
    let profile = match law {
        Law::Force { target_force, .. } => target_force,
        Law::Hybrid { target_force, position_controlled, .. } => {
            position_controlled.at(row).filter(|is_position| !is_position).map(|_| target_force)?
        }
        _ => return None,
    };
    match profile {
        Profile::Constant { value } => value.at(row).filter(|value| *value != 0.0),
        _ => None,
    }
}
