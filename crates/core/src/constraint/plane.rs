//! A virtual wall for a point of the arm.

use std::sync::Arc;

use nalgebra::Vector3;
use revprio_problem::Inequality;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Configuration, LinkPoint};

use super::kind::ConstraintKind;
use crate::arm_state::{Ahead, ArmState, JointBraking};
use crate::linalg::RANK_TOLERANCE;

/// Default approach rate γ, 1/s: an approach at 0.5 m/s slows down with at most 5 m/s².
pub const APPROACH_RATE: f64 = 10.0;

/// The point of the arm that a virtual plane holds back.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum PlanePoint {
    /// The tool point.
    #[default]
    Tool,
    /// The origin of a joint's frame (index from 0), for example the elbow.
    Joint(usize),
    /// A point of a link, seen from the base, for example the tool point of a second arm.
    Link(LinkPoint),
}

impl PlanePoint {
    /// Returns the point at a posture, base frame, m.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such joint or link.
    pub fn position(&self, configuration: &Configuration) -> Vector3<f64> {
        match self {
            Self::Tool => configuration.tool_pose().translation.vector,
            Self::Joint(joint) => configuration.joint_origin(*joint),
            Self::Link(point) => configuration.point_pose(point).translation.vector,
        }
    }
}

/// Share of a_n that the approach to a plane uses. The rest is for what a_n leaves out: the Jacobian that changes on the
/// way, and joints that cannot help because of their own limits.
const BRAKING_SHARE: f64 = 0.5;

/// A virtual wall n·x ≤ d for a point x of the arm, kept by n·ẋ ≤ min(γ D, s(D)).
///
/// D = d − n·x is the distance to the wall. γ bounds the rate: the distance decreases no faster than e^(−γ t). s is the
/// speed from which the joints can stop the point, s τ + s²/2a = D, with half of the deceleration
///
/// a_n = min_j a_j |g|²/|g_j|, g = Jᵀ n,
///
/// which the shortest change of the joint velocities along n gives, Δq̇ = −(Δs/|g|²) g. Where the limits of the controller
/// do not say how the joints brake, the bound is γ D. Behind the wall, the inequality demands a motion back, with the
/// mirrored bound.
///
/// Behind a drive, D is the smaller one of the distances at the present posture q and at the position of rest p. A command u
/// moves p by T u, so n·x(p + T u) = n·x(p) + T g(m)·u up to terms of third order for u = q̇⁻, with m as in [`Ahead`]. The
/// coefficients of the inequality are g(p) nevertheless, because the tasks have their Jacobians there, and tasks would drive
/// the arm through the difference of g(m) and g(p). Instead, max(0, (g(m) − g(p))·q̇⁻) is subtracted from the bound.
#[derive(Debug, Clone, PartialEq)]
pub struct VirtualPlane {
    name: Arc<str>,
    normal: Vector3<f64>,
    offset: f64,
    point: PlanePoint,
    rate: f64,
}

/// Why a virtual plane is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum VirtualPlaneError {
    /// A number is NaN or infinite.
    #[error("normal, offset and rate must be finite numbers")]
    NotFinite,
    /// The normal has length zero.
    #[error("the normal must differ from zero")]
    Normal,
    /// The rate is zero or negative.
    #[error("the rate must be positive")]
    Rate,
}

impl VirtualPlane {
    /// Checks and builds a plane.
    ///
    /// - `normal`: n, base frame, towards the forbidden side, of any length.
    /// - `offset`: d, distance of the plane from the base origin along the unit normal, m.
    /// - `rate`: γ, 1/s. It must be at most 1/T for a control period T, or the point may pass the plane within a period.
    pub fn new(
        name: impl Into<Arc<str>>,
        normal: [f64; 3],
        offset: f64,
        point: PlanePoint,
        rate: f64,
    ) -> Result<Self, VirtualPlaneError> {
        let normal = Vector3::from(normal);
        if !(normal.iter().all(|entry| entry.is_finite()) && offset.is_finite() && rate.is_finite()) {
            return Err(VirtualPlaneError::NotFinite);
        }
        if !normal.norm().is_normal() {
            return Err(VirtualPlaneError::Normal);
        }
        if rate <= 0.0 {
            return Err(VirtualPlaneError::Rate);
        }
        Ok(Self { name: name.into(), normal: normal.normalize(), offset, point, rate })
    }

    /// Returns a row of n joints that [`Self::overwrite`] can overwrite.
    fn empty_row(&self, n: usize) -> Inequality {
        Inequality::always_satisfied(Arc::clone(&self.name), 0, n)
    }

    /// Returns the point that is held back.
    pub fn point(&self) -> PlanePoint {
        self.point
    }

    /// Returns γ, 1/s.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Returns the inequality at a posture. It always holds if no joint moves the point along the normal.
    ///
    /// `ahead`: where the next command moves the arm, if it is known; `braking`: how the joints brake, if it is known.
    pub fn at(&self, configuration: &Configuration, ahead: Option<Ahead>, braking: Option<JointBraking>) -> Inequality {
        let mut inequality = self.empty_row(configuration.joint_position().len());
        self.overwrite(configuration, ahead, braking, &mut inequality);
        inequality
    }

    /// Overwrites an inequality for as many joints with that of [`Self::at`], without allocating.
    fn overwrite(
        &self,
        configuration: &Configuration,
        ahead: Option<Ahead>,
        braking: Option<JointBraking>,
        inequality: &mut Inequality,
    ) {
        let rest = ahead.map_or(configuration, |ahead| ahead.rest);
        inequality.overwrite(|along| {
            let mut of_jacobian = 0.0;
            for (entry, column) in along.iter_mut().zip(self.columns(rest)) {
                *entry = column.dot(&self.normal);
                of_jacobian += column.norm_squared();
            }
            if square(along) <= RANK_TOLERANCE * RANK_TOLERANCE * of_jacobian {
                along.fill(0.0);
                return f64::INFINITY;
            }
            let distance = self.distance(configuration).min(self.distance(rest));
            let speed = braking.map_or(f64::INFINITY, |joints| stopping_speed(joints, along, distance.abs()));
            let by_rate = self.rate * distance;
            by_rate.clamp(-speed, speed) - ahead.map_or(0.0, |ahead| self.turning(along, ahead))
        });
    }

    /// Returns max(0, (g(m) − g(p))·q̇⁻), m/s; `along`: g(p), n.
    fn turning(&self, along: &[f64], ahead: Ahead) -> f64 {
        let half_way = self.columns(ahead.half_way).map(|column| column.dot(&self.normal));
        let turned = half_way.zip(along).zip(ahead.last_command);
        turned.map(|((half_way, along), speed)| (half_way - along) * speed).sum::<f64>().max(0.0)
    }

    /// Returns D, the distance of the point to the plane, m; negative behind it.
    fn distance(&self, configuration: &Configuration) -> f64 {
        self.offset - self.normal.dot(&self.point.position(configuration))
    }

    /// Returns the columns of the Jacobian of the point, n, m/s.
    fn columns(&self, configuration: &Configuration) -> impl Iterator<Item = Vector3<f64>> {
        let (tool, origin, link) = match self.point {
            PlanePoint::Tool => (Some(configuration.tool_point_jacobian()), None, None),
            PlanePoint::Joint(joint) => (None, Some(configuration.joint_origin_jacobian(joint)), None),
            PlanePoint::Link(point) => (None, None, Some(configuration.link_point_jacobian(point))),
        };
        let tool_or_origin = tool.into_iter().flatten().chain(origin.into_iter().flatten());
        tool_or_origin.chain(link.into_iter().flatten())
    }
}

impl ConstraintKind for VirtualPlane {
    fn name(&self) -> &str {
        &self.name
    }

    fn fits(&self, robot: &RobotModel) -> bool {
        match self.point {
            PlanePoint::Tool => true,
            PlanePoint::Joint(joint) => joint < robot.joint_count(),
            PlanePoint::Link(point) => point.link.max(point.relative_to).index() < robot.links().len(),
        }
    }

    fn row_count(&self) -> usize {
        1
    }

    fn depends_on_posture(&self) -> bool {
        true
    }

    fn push_rows(&self, n: usize, rows: &mut Vec<Inequality>) {
        rows.push(self.empty_row(n));
    }

    fn write(&self, arm: &ArmState, rows: &mut [Inequality]) {
        let (measured, braking) = (arm.measured().configuration, arm.capability.before_planes());
        self.overwrite(measured, arm.ahead(), Some(braking), &mut rows[0]);
    }

    fn rows_at(&self, configuration: Option<&Configuration>) -> Vec<Inequality> {
        configuration.map(|configuration| self.at(configuration, None, None)).into_iter().collect()
    }
}

/// Returns s(D) of [`VirtualPlane`], m/s, infinite if the deceleration is; `along`: g, n; `distance`: D ≥ 0, m.
fn stopping_speed(JointBraking { deceleration, reaction_s }: JointBraking, along: &[f64], distance: f64) -> f64 {
    let decelerations = deceleration.iter().zip(along).map(|(a, along)| a / along.abs());
    let deceleration = BRAKING_SHARE * square(along) * decelerations.fold(f64::INFINITY, f64::min);
    // Infinite and NaN: nothing is known.
    if !deceleration.is_finite() {
        return f64::INFINITY;
    }
    let time = reaction_s + (reaction_s * reaction_s + 2.0 * distance / deceleration).sqrt();
    if distance > 0.0 { 2.0 * distance / time } else { 0.0 }
}

/// Returns the square of the norm.
fn square(entries: &[f64]) -> f64 {
    entries.iter().map(|entry| entry * entry).sum()
}

#[cfg(test)]
mod tests;
