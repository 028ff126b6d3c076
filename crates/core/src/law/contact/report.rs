//! What the contact law tells about an axis.

use super::axis::ContactPhase;
use crate::surface::NormalReport;

/// The contact along one axis in one period. For an axis of rotation read N·m for N and rad for m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactReport {
    /// The state.
    pub phase: ContactPhase,
    /// Whether the state began in this period.
    pub is_new: bool,
    /// F, measured force along the pressing direction, N.
    pub force: f64,
    /// F_d, target force along the pressing direction, N.
    pub target: f64,
    /// s K̂, the stiffness with which the law computes, N/m.
    pub stiffness_bound: f64,
    /// K_l, estimated stiffness with its rms uncertainty, N/m; `None`: not known yet.
    pub stiffness: Option<[f64; 2]>,
    /// F + s K̂ (p − x_s), the predicted force if all later commands are zero, N; 0 without contact.
    pub predicted_force: f64,
    /// Velocity of the surface, m/s.
    pub surface_velocity: f64,
    /// Energy that the tank still has, J.
    pub energy: f64,
    /// v_app, m/s.
    pub approach_speed: f64,
    /// Peak force that no controller avoids that brakes with the acceleration of this law, at this approach speed in the stiffest contact, N.
    pub unavoidable_peak: f64,
    /// The normal of the surface; `None`: the law does not follow it.
    pub normal: Option<NormalReport>,
}
