//! Warnings about control loops that are unstable in contact with the stated environment.

use revprio_api::wire::{self, Axis, Law};
use revprio_core::controller::{ContactLoop, Margin, StabilityError};

use crate::convert::NOT_COMPUTABLE;
use crate::error::ApiError;

/// Returns a warning for each axis with an unstable loop. The controller must be checked before.
///
/// Only the first task on an axis counts. It moves the axis, and the cost stays bounded.
pub fn warnings(request: &wire::Controller) -> Result<Vec<String>, ApiError> {
    unstable_axes(request).map_err(|_| ApiError::invalid("/environment", NOT_COMPUTABLE))
}

fn unstable_axes(request: &wire::Controller) -> Result<Vec<String>, StabilityError> {
    let mut warnings = Vec::new();
    for axis in Axis::ALL {
        let row = |task: &wire::ControllerTask| task.axes.as_ref()?.iter().position(|other| *other == axis);
        // A task with bounds has no law. It does not move the axis.
        let first = request.tasks.iter().find_map(|task| Some((task, task.law.as_ref()?, row(task)?)));
        // The environment is stated along the axes of the base frame.
        let first = first.filter(|(task, _, _)| task.frame == wire::Frame::Base);
        let contact = first.and_then(|(task, law, row)| Some((task, contact_loop(request, axis, law, row)?)));
        if let Some((task, contact)) = contact
            && !contact.is_stable()?
        {
            warnings.push(format!("task `{}`, axis {axis}: {}", task.name, advice(&contact, axis)?));
        }
    }
    Ok(warnings)
}

/// Returns the loop of one row of a law in contact with the environment. Returns `None` without an environment on this
/// axis, and for laws without force feedback.
fn contact_loop(request: &wire::Controller, axis: Axis, law: &Law, row: usize) -> Option<ContactLoop> {
    let environment = request.environment.as_ref()?;
    let contact = environment.along(axis)?;
    let [inertia, damping, stiffness] = law.contact_gains(row)?;
    let drive = stated_drive(request);
    Some(ContactLoop {
        inertia,
        damping,
        stiffness,
        environment_inertia: contact.inertia,
        environment_damping: contact.damping,
        environment_stiffness: contact.stiffness,
        period_s: request.period_s,
        lag_s: environment.lag_s.max(drive.lag_s) + request.wrench_sensor.map_or(0.0, |sensor| sensor.filter_time_s),
        delay_periods: environment.delay_periods.max(usize::try_from(drive.delay_periods).unwrap_or(usize::MAX)),
        velocity_measured: environment.velocity_measured,
    })
}

/// Returns the drive of the controller if it is not the default one, which is slower than most arms; otherwise an ideal one.
fn stated_drive(request: &wire::Controller) -> wire::JointDrive {
    let is_stated = request.drive != wire::JointDrive::default();
    if is_stated { request.drive } else { wire::JointDrive { lag_s: 0.0, delay_periods: 0 } }
}

/// Describes an unstable loop and the changes that make it stable.
fn advice(contact: &ContactLoop, axis: Axis) -> Result<String, StabilityError> {
    let Margin { spectral_radius, largest_lag_s, largest_delay_periods, smallest_damping, largest_damping } =
        contact.margin()?;
    let unit = damping_unit(axis);
    let lag = match largest_lag_s {
        Some(lag) if lag < contact.lag_s => format!("largest admissible lag {} ms", four_digits(0.999 * 1e3 * lag)),
        _ => "no lag is short enough".to_owned(),
    };
    let delay = match largest_delay_periods {
        _ if contact.delay_periods == 0 => String::new(),
        Some(periods) => format!("; largest admissible delay {periods} periods"),
        None => "; no delay is short enough".to_owned(),
    };
    let damping = match (smallest_damping, largest_damping) {
        (Some(_), Some(damping)) if contact.damping > damping => {
            format!("damping of at most {} {unit} makes it stable", four_digits(0.999 * damping))
        }
        (Some(damping), _) => format!("damping of at least {} {unit} makes it stable", four_digits(1.001 * damping)),
        (None, _) => "no damping makes it stable".to_owned(),
    };
    Ok(format!(
        "with this environment the loop is unstable: spectral radius {spectral_radius:.6}; {lag}{delay}; {damping}"
    ))
}

/// Returns the unit of a damping on an axis.
pub fn damping_unit(axis: Axis) -> &'static str {
    if matches!(axis, Axis::X | Axis::Y | Axis::Z) { "N·s/m" } else { "N·m·s/rad" }
}

/// Rounds to four significant digits. A number 0.1 % inside a margin stays inside.
pub fn four_digits(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}
