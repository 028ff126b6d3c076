//! When each joint arrives: those that need less time than the slowest one move more slowly.
//!
//! The slowest joint decides when the tool arrives. If the others arrived earlier, the tool would leave the straight line further, and
//! could pass its target on the way.

use super::joint_law::Capability;

/// Joints aim to arrive this much earlier than the slowest one: the estimate of its time is one from rest.
const EARLIER: f64 = 1.3;

/// Smallest share of the speed limit. Joints that have almost arrived must follow small changes.
const LEAST: f64 = 0.3;

/// Returns the time of a joint to a position at this distance, from rest to rest, s: its trapezoid of V and A.
pub(super) fn time(distance: f64, can: Capability) -> f64 {
    let Capability { speed, acceleration, .. } = can;
    let distance = distance.abs();
    if distance > speed * speed / acceleration {
        distance / speed + speed / acceleration
    } else {
        2.0 * (distance / acceleration).sqrt()
    }
}

/// Returns the share of its speed limit that a joint uses, and whose square it uses of its acceleration limit, from its time and that of
/// the slowest joint, s.
pub(super) fn share(time: f64, slowest: f64) -> f64 {
    let share = EARLIER * time / slowest;
    // NaN: all joints have arrived.
    if share < 1.0 { share.max(LEAST) } else { 1.0 }
}
