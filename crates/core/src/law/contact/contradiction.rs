//! Numbers of a contact law that contradict each other: the law presses, but not as they say.

use std::fmt;

use super::law::ContactLaw;

/// Peak of a good contact over its target: what a limit of the force must leave.
const PEAK_SHARE: f64 = 1.2;

/// Numbers of one axis that contradict each other. For an axis of rotation read N·m for N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactContradiction {
    /// The limit of the force is below its target, so the tool retreats from every contact.
    LimitBelowTarget {
        /// The limit, N.
        max_force: f64,
        /// The target, N.
        target: f64,
    },
    /// The limit is so near the target that the peak of an impact exceeds it.
    LimitNearTarget {
        /// The limit, N.
        max_force: f64,
        /// The target, N.
        target: f64,
    },
    /// The target is below what is told from noise and bias, so the law presses harder.
    TargetBelowNoise {
        /// The target, N.
        target: f64,
        /// f₅, the smallest force that the law presses with, N.
        least: f64,
    },
    /// The target has both signs, and the law presses in one direction.
    OtherSign {
        /// The target that is farthest from zero, N.
        target: f64,
        /// The target of the other sign that is farthest from zero, N.
        other: f64,
        /// f₅, the force with which the law presses instead, N.
        least: f64,
    },
    /// The deadband of the sensor hides the end of a contact.
    Deadband {
        /// The deadband, N.
        deadband: f64,
        /// f_off, the force below which a contact ends, N.
        release: f64,
    },
}

impl fmt::Display for ContactContradiction {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match *self {
            Self::LimitBelowTarget { max_force, target } => write!(
                f,
                "`max_force` {max_force} is below the target force {target}, so the tool retreats from every contact; give more"
            ),
            Self::LimitNearTarget { max_force, target } => write!(
                f,
                "`max_force` {max_force} is less than {PEAK_SHARE} times the target force {target}, and an impact may reach that; \
                 give more, or the tool retreats from it"
            ),
            Self::Deadband { deadband, release } => write!(
                f,
                "the deadband {deadband} of `wrench_sensor` is above {release}, below which a contact ends, so contacts are told late \
                 and lost early; give less"
            ),
            Self::OtherSign { target, other, least } => write!(
                f,
                "the target force changes its sign, from {target} to {other}, and the tool presses with {least} in the direction of \
                 {target} instead; give targets of one sign, or press the other way with another controller"
            ),
            Self::TargetBelowNoise { target, least } => write!(
                f,
                "the target force {target} is below 5 times `noise` plus `bias`, so the tool presses with {least}; use a better \
                 sensor, or state less noise if it has less"
            ),
        }
    }
}

impl ContactLaw {
    /// Returns the numbers that contradict each other, with their row, from 0; `deadband`: that of the sensor, N and N·m.
    pub fn contradictions(&self, deadband: [f64; 2]) -> impl Iterator<Item = (usize, ContactContradiction)> {
        let (largest, [lower, upper]) = (self.target_force().largest(), self.target_force().range());
        let axes = self.axes().iter().zip(largest).enumerate();
        axes.flat_map(move |(row, (settings, target))| {
            let other = if target > 0.0 { lower[row] } else { upper[row] };
            let least = settings.threshold();
            let sign = (other != 0.0).then_some(ContactContradiction::OtherSign { target, other, least });
            let (target, max_force) = (target.abs(), settings.max_force);
            let limit = if max_force < target.max(least) {
                Some(ContactContradiction::LimitBelowTarget { max_force, target: target.max(least) })
            } else if max_force < PEAK_SHARE * target {
                Some(ContactContradiction::LimitNearTarget { max_force, target })
            } else {
                None
            };
            let noise = (target < least).then_some(ContactContradiction::TargetBelowNoise { target, least });
            let (deadband, release) = (deadband[usize::from(settings.is_angular())], settings.release());
            let deadband = (deadband > release).then_some(ContactContradiction::Deadband { deadband, release });
            [limit, noise, sign, deadband].into_iter().flatten().map(move |found| (row, found))
        })
    }
}
