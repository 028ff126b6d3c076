//! Warnings about laws that are unstable without any contact, behind the drive of the controller.

use revprio_api::wire::{self, Axis};
use revprio_core::controller::{ContactLoop, ControllerConfig, StabilityError, StableDamping};

use super::contact::{damping_unit, four_digits};
use crate::convert::{MAX_ENVIRONMENT_DELAY, NOT_COMPUTABLE};

/// A spectral radius of 1 is that of a law without damping. This is how far rounding moves it.
const ROUNDING: f64 = 1e-14;

/// Returns a warning for each task whose law is unstable in free space. The controller must be checked before.
pub fn warnings(request: &wire::Controller, config: &ControllerConfig) -> Vec<String> {
    request.tasks.iter().filter_map(|task| warning(task, config)).collect()
}

/// Describes the axis of a task with the largest spectral radius; `None` if all are stable.
fn warning(task: &wire::ControllerTask, config: &ControllerConfig) -> Option<String> {
    let (axes, law) = (task.axes.as_ref()?, task.law.as_ref()?);
    let (mut examined, mut worst) = (Vec::new(), None);
    for (row, axis) in axes.iter().enumerate() {
        let gains = law.contact_gains(row)?;
        if examined.contains(&gains) {
            continue;
        }
        examined.push(gains);
        let Ok(free) = FreeSpace::of(*axis, gains, config) else {
            return Some(format!("task `{}`, axis {axis}, in free space: {NOT_COMPUTABLE}", task.name));
        };
        if free.radius() > worst.as_ref().map_or(0.0, FreeSpace::radius) {
            worst = Some(free);
        }
    }
    let worst = worst.filter(|worst| is_unstable(worst.radius()))?;
    Some(format!("task `{}`, axis {}: {}", task.name, worst.axis, worst.describe(config)))
}

fn is_unstable(radius: f64) -> bool {
    radius >= 1.0 - ROUNDING
}

/// One axis of a law without contact.
struct FreeSpace {
    axis: Axis,
    /// With measured and with commanded velocity.
    loops: [ContactLoop; 2],
    /// Their spectral radii.
    radii: [f64; 2],
}

impl FreeSpace {
    fn of(axis: Axis, gains: [f64; 3], config: &ControllerConfig) -> Result<Self, StabilityError> {
        let [inertia, damping, stiffness] = gains;
        let loops = [true, false].map(|velocity_measured| ContactLoop {
            inertia,
            damping,
            stiffness,
            environment_inertia: 0.0,
            environment_damping: 0.0,
            environment_stiffness: 0.0,
            period_s: config.period_s,
            lag_s: config.drive.lag_s,
            delay_periods: config.drive.delay_periods,
            velocity_measured,
        });
        Ok(Self { axis, loops, radii: [loops[0].spectral_radius()?, loops[1].spectral_radius()?] })
    }

    fn radius(&self) -> f64 {
        self.radii[0].max(self.radii[1])
    }

    fn describe(&self, config: &ControllerConfig) -> String {
        let [measured, commanded] = self.radii.map(|radius| {
            if is_unstable(radius) { format!("spectral radius {radius:.6}") } else { "stable".to_owned() }
        });
        let remedy = self.remedy().unwrap_or_else(|_| NOT_COMPUTABLE.to_owned());
        format!(
            "with this `period_s` and this `drive` (lag {} ms, delay {} periods) the loop is unstable in free space: {measured} \
             if states contain `joint_velocity`, {commanded} if not; {remedy}",
            four_digits(1e3 * config.drive.lag_s),
            config.drive.delay_periods,
        )
    }

    /// Returns the changes that make both loops stable.
    fn remedy(&self) -> Result<String, StabilityError> {
        let own = self.loops[0];
        let softer = if own.stiffness > 0.0 { ", a smaller stiffness" } else { "" };
        // For longer delays the interval takes too long.
        if own.delay_periods > MAX_ENVIRONMENT_DELAY {
            return Ok(format!("choose another damping, a larger inertia{softer} or a shorter period"));
        }
        let Some((low, high)) = self.stable_dampings()? else {
            return Ok(format!("no damping makes it stable; choose a larger inertia{softer} or a shorter period"));
        };
        let range = format!("damping above {low} and up to {high} {} makes it stable", damping_unit(self.axis));
        Ok(if own.damping > high {
            format!("{range}, as may a larger inertia{softer} or a shorter period")
        } else if own.stiffness > 0.0 {
            format!("{range}, as may a smaller stiffness")
        } else {
            range
        })
    }

    /// Returns the dampings with which both loops are stable, 0.1 % inside their margins.
    fn stable_dampings(&self) -> Result<Option<(f64, f64)>, StabilityError> {
        let [Some(measured), Some(commanded)] = [self.loops[0].stable_dampings()?, self.loops[1].stable_dampings()?]
        else {
            return Ok(None);
        };
        let largest = |dampings: StableDamping| dampings.largest.unwrap_or(f64::INFINITY);
        let high = 0.999 * largest(measured).min(largest(commanded));
        let low = 1.001 * measured.smallest.max(commanded.smallest);
        // A law without stiffness needs any damping above zero, and the search begins a little above.
        let low = if low < 1e-6 * high { 0.0 } else { four_digits(low) };
        Ok((low < high).then(|| (low, four_digits(high))))
    }
}
