//! The command that stops a joint as fast as its limits of acceleration and jerk allow.

use revprio_robot::JointLimits;

use super::braking::braking_deceleration;
use super::jerk::JerkLimit;

/// Returns the command of full braking after the last command and its acceleration; `None`: the jerk is not kept. `period`: T, s.
///
/// It lies in the box of the limits of position, velocity, acceleration and jerk, see the module `limits`. A joint that may jump brakes at its
/// [`braking_deceleration`] too: a transition from another controller allows no more.
pub fn full_braking(limits: &JointLimits, (last, acceleration): (f64, Option<f64>), period: f64) -> f64 {
    if let Some((acceleration, jerk)) = acceleration.zip(JerkLimit::of(limits, period)) {
        return jerk.braking(last, acceleration);
    }
    let change = braking_deceleration(limits) * period;
    last - last.clamp(-change, change)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// A stop keeps the jerk and the acceleration, turns back nowhere, and ends.
        #[test]
        fn a_joint_stops_without_turning_back(
            speed in -2.0..2.0_f64,
            jerk in prop_oneof![Just(f64::INFINITY), 10.0..1e4_f64],
            period in prop_oneof![Just(0.001), Just(0.008)],
        ) {
            let limits = JointLimits { lower: -3.0, upper: 3.0, velocity: 2.0, acceleration: 8.0, jerk, ..JointLimits::NONE };
            let (mut last, mut acceleration, mut periods) = (speed, 0.0, 0);
            while last != 0.0 || acceleration != 0.0 {
                let next = full_braking(&limits, (last, Some(acceleration)), period);
                let change = (next - last) / period;
                prop_assert!(change.abs() <= 8.0 + 1e-9, "{change}");
                prop_assert!((change - acceleration).abs() <= jerk * period * (1.0 + 1e-9) + 1e-9);
                prop_assert!(next * speed >= -1e-12, "{next}");
                (last, acceleration, periods) = (next, change, periods + 1);
                prop_assert!(f64::from(periods) * period < 2.0 / 8.0 + 3.0 * 8.0 / jerk + 0.2, "{last} {acceleration}");
            }
        }
    }
}
