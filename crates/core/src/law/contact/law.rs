//! The contact law of a task.

use revprio_robot::profile::Profile;

use super::axis::ContactAxis;
use super::report::ContactReport;
use super::settings::ContactSettings;
use super::step::{AxisInput, Step};
use super::timing::ContactTiming;
use crate::surface::SurfaceSettings;

/// The contact law: it presses with F_d on a surface of unknown stiffness, each axis by itself.
///
/// The sign of the target force is the pressing direction of its axis. A target that is smaller than what the law tells from
/// no contact, f₅, is raised to it, and so is a later one of the other sign.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactLaw {
    target_force: Profile,
    axes: Vec<ContactSettings>,
    directions: Vec<f64>,
    surface: Option<SurfaceSettings>,
}

/// Why a contact law is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ContactLawError {
    /// The numbers of axes differ.
    #[error("{given} target forces for {expected} axes; give one per axis")]
    Size {
        /// Number of axes.
        expected: usize,
        /// Number of target forces.
        given: usize,
    },
    /// A number is out of its range.
    #[error("{value} is out of range; `{field}` must be {must_be}")]
    Range {
        /// Its name.
        field: &'static str,
        /// Row, from 0.
        row: usize,
        /// The value.
        value: f64,
        /// The range in words.
        must_be: &'static str,
    },
    /// A law with several axes, or with a rotation, is to follow a normal.
    #[error("a task that follows the normal of a surface presses along one axis of translation; give it one axis")]
    Surface,
    /// An axis has no target force, so it has no direction.
    #[error("the target force is zero; its sign is the direction in which the tool presses")]
    NoDirection {
        /// Row, from 0.
        row: usize,
    },
}

impl ContactLaw {
    /// Largest time constant of the force sensor, s. A sensor has milliseconds.
    pub const MOST_SENSOR_LAG: f64 = 1.0;

    /// Checks and builds a law with F_d = `target_force` (N, N·m) and the settings of each axis.
    pub fn new(target_force: Profile, axes: Vec<ContactSettings>) -> Result<Self, ContactLawError> {
        let (expected, given) = (axes.len(), target_force.rows());
        if given != expected {
            return Err(ContactLawError::Size { expected, given });
        }
        for (row, settings) in axes.iter().enumerate() {
            check(row, settings)?;
        }
        let largest = target_force.largest();
        let direction = |(row, value): (usize, &f64)| match *value {
            0.0 => Err(ContactLawError::NoDirection { row }),
            value => Ok(value.signum()),
        };
        let directions = largest.iter().enumerate().map(direction).collect::<Result<_, _>>()?;
        Ok(Self { target_force, axes, directions, surface: None })
    }

    /// Returns the law with axes that follow the normal of the surface. It has one row, a translation.
    pub fn with_surface(self, surface: SurfaceSettings) -> Result<Self, ContactLawError> {
        let value = surface.max_tilt;
        if !(value > 0.0 && value <= SurfaceSettings::MOST_TILT) {
            let must_be = "above 0, and at most 1.4 rad";
            return Err(ContactLawError::Range { field: "max_tilt_rad", row: 0, value, must_be });
        }
        match *self.axes {
            [axis] if !axis.is_angular() => Ok(Self { surface: Some(surface), ..self }),
            _ => Err(ContactLawError::Surface),
        }
    }

    /// Returns how the axes follow the normal of the surface; `None`: they do not.
    pub fn surface(&self) -> Option<&SurfaceSettings> {
        self.surface.as_ref()
    }

    /// Returns m, the number of rows.
    pub fn rows(&self) -> usize {
        self.axes.len()
    }

    /// Returns F_d over time, N and N·m.
    pub fn target_force(&self) -> &Profile {
        &self.target_force
    }

    /// Returns what is known of the axes.
    pub fn axes(&self) -> &[ContactSettings] {
        &self.axes
    }

    /// Returns the pressing direction of a row along its axis, 1 or −1.
    pub fn direction(&self, row: usize) -> f64 {
        self.directions[row]
    }

    /// Returns the force with which a row presses for a target (N, N·m) along its axis: in its direction, and at least f₅.
    pub fn pressing_force(&self, row: usize, target: f64) -> f64 {
        (self.directions[row] * target).max(self.axes[row].threshold())
    }

    /// Updates an axis; returns the velocity that it wants along its pressing direction, m/s or rad/s, and its report.
    pub fn step(
        &self,
        row: usize,
        timing: &ContactTiming,
        input: AxisInput,
        axis: &mut ContactAxis,
    ) -> (f64, ContactReport) {
        Step { settings: &self.axes[row], timing, input, axis }.run()
    }
}

/// Checks the numbers of an axis.
fn check(row: usize, settings: &ContactSettings) -> Result<(), ContactLawError> {
    let ContactSettings { stiffest, noise, bias, max_force, .. } = *settings;
    let ContactSettings { sensor_lag, retreat_speed, max_acceleration, .. } = *settings;
    let speed = settings.approach_speed.unwrap_or(1.0);
    let enough = "at least 1e-9";
    let [most_noise, most_bias] =
        [ContactSettings::MOST_NOISE, ContactSettings::MOST_BIAS].map(|most| most / settings.metre);
    let finite = |value: f64| value.is_finite() && value > 0.0;
    let is_enough = |value: f64| value.is_finite() && value >= ContactSettings::LEAST_MOTION;
    let checks = [
        ("approach_speed", speed, is_enough(speed), enough),
        ("noise", noise, finite(noise) && noise <= most_noise, "positive, and at most 10 N or 1 N·m"),
        ("bias", bias, (0.0..=most_bias).contains(&bias), "from 0 to 100 N or 10 N·m"),
        ("sensor_lag_s", sensor_lag, (0.0..=ContactLaw::MOST_SENSOR_LAG).contains(&sensor_lag), "from 0 to 1 s"),
        ("stiffest", stiffest, stiffest.is_finite() && stiffest >= settings.softest, "at least 300 N/m or 3 N·m/rad"),
        ("max_force", max_force, max_force > settings.threshold(), "larger than 5 times `noise` plus `bias`"),
        ("retreat_speed", retreat_speed, is_enough(retreat_speed), enough),
        ("max_acceleration", max_acceleration, is_enough(max_acceleration), enough),
    ];
    match checks.into_iter().find(|(_, _, is_valid, _)| !is_valid) {
        Some((field, value, _, must_be)) => Err(ContactLawError::Range { field, row, value, must_be }),
        None => Ok(()),
    }
}
