//! Barriers: inequalities that a controller must obey besides the joint limits, such as virtual walls.

use nalgebra::{Matrix3xX, Vector3};
use revprio_robot::kinematics::Configuration;

use super::Inequality;
use crate::linalg::{RANK_TOLERANCE, Vector};

/// A linear inequality on the joint velocities, constant or derived from the posture.
#[derive(Debug, Clone, PartialEq)]
pub enum Barrier {
    /// a·q̇ ≤ b, the same at every posture.
    Fixed(Inequality),
    /// A virtual wall, which gives another inequality at each posture.
    Plane(VirtualPlane),
}

impl Barrier {
    /// Returns the name that answers use.
    pub fn name(&self) -> &str {
        match self {
            Self::Fixed(inequality) => inequality.name(),
            Self::Plane(plane) => &plane.name,
        }
    }

    /// Returns whether the barrier is possible for an arm of `joints` joints.
    pub fn fits(&self, joints: usize) -> bool {
        match self {
            Self::Fixed(inequality) => inequality.coefficients().len() == joints,
            Self::Plane(plane) => !matches!(plane.point, PlanePoint::Joint(joint) if joint >= joints),
        }
    }

    /// Returns the inequality if it is the same at every posture.
    pub fn constant(&self) -> Option<&Inequality> {
        match self {
            Self::Fixed(inequality) => Some(inequality),
            Self::Plane(_) => None,
        }
    }

    /// Returns the inequality at a posture; `ahead`: where the next command moves the arm, if it is known; `braking`: how the
    /// joints brake, if it is known.
    pub fn at(&self, configuration: &Configuration, ahead: Option<Ahead>, braking: Option<JointBraking>) -> Inequality {
        match self {
            Self::Fixed(inequality) => inequality.clone(),
            Self::Plane(plane) => plane.at(configuration, ahead, braking),
        }
    }
}

/// Where the next command moves the arm: from its position of rest p to p + T u, see [`DriveState`](super::DriveState).
#[derive(Debug, Clone, Copy)]
pub struct Ahead<'a> {
    /// The arm at p, where the Jacobians of the tasks are taken.
    pub rest: &'a Configuration,
    /// The arm at m = p + ½ T q̇⁻, half of the way if the last command continues.
    pub half_way: &'a Configuration,
    /// q̇⁻, the last command, n, rad/s or m/s.
    pub last_command: &'a [f64],
}

/// How the joints brake before a plane.
#[derive(Debug, Clone, Copy)]
pub struct JointBraking<'a> {
    /// a_j, n, rad/s² or m/s²; infinite for a joint without limit.
    pub deceleration: &'a [f64],
    /// τ, time for which the point may move on before it brakes, s.
    pub reaction_s: f64,
}

/// Default approach rate γ, 1/s: an approach at 0.5 m/s slows down with at most 5 m/s².
pub const APPROACH_RATE: f64 = 10.0;

/// The point of the arm that a virtual plane holds back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PlanePoint {
    /// The tool point.
    #[default]
    Tool,
    /// The origin of a joint's frame (index from 0), for example the elbow.
    Joint(usize),
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
    name: String,
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
        name: impl Into<String>,
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
        let distance_at = |point: &Vector3<f64>| self.offset - self.normal.dot(point);
        let (present, jacobian) = self.point_at(configuration);
        let (rest, jacobian) = ahead.map_or((present, jacobian), |ahead| self.point_at(ahead.rest));
        let along = jacobian.transpose() * self.normal;
        if along.norm() <= RANK_TOLERANCE * jacobian.norm() {
            return Inequality::always_satisfied(self.name.clone(), along.len());
        }
        let distance = distance_at(&present).min(distance_at(&rest));
        let turning = ahead.map_or(0.0, |Ahead { half_way, last_command, .. }| {
            let turned = self.point_at(half_way).1.transpose() * self.normal - &along;
            turned.iter().zip(last_command).map(|(turned, speed)| turned * speed).sum::<f64>().max(0.0)
        });
        let coefficients = Vector::from_column_slice(along.as_slice());
        let speed = braking.map_or(f64::INFINITY, |joints| joints.stopping_speed(&coefficients, distance.abs()));
        let by_rate = self.rate * distance;
        let bound = by_rate.clamp(-speed, speed) - turning;
        let mut inequality = Inequality::always_satisfied(self.name.clone(), coefficients.len());
        inequality.overwrite(|along| {
            along.copy_from_slice(coefficients.as_slice());
            bound
        });
        inequality
    }

    /// Returns the point (m) and its Jacobian, 3 × n.
    fn point_at(&self, configuration: &Configuration) -> (Vector3<f64>, Matrix3xX<f64>) {
        match self.point {
            PlanePoint::Tool => {
                let jacobian = configuration.jacobian().fixed_rows::<3>(0).into_owned();
                (configuration.tool_pose().translation.vector, jacobian)
            }
            PlanePoint::Joint(joint) => configuration.joint_origin(joint),
        }
    }
}

impl JointBraking<'_> {
    /// Returns s(D) of [`VirtualPlane`], m/s, infinite if the deceleration is; `along`: g, n; `distance`: D ≥ 0, m.
    fn stopping_speed(&self, along: &Vector, distance: f64) -> f64 {
        let decelerations = self.deceleration.iter().zip(along).map(|(a, along)| a / along.abs());
        let deceleration = BRAKING_SHARE * along.norm_squared() * decelerations.fold(f64::INFINITY, f64::min);
        // Infinite and NaN: nothing is known.
        if !deceleration.is_finite() {
            return f64::INFINITY;
        }
        let time = self.reaction_s + (self.reaction_s * self.reaction_s + 2.0 * distance / deceleration).sqrt();
        if distance > 0.0 { 2.0 * distance / time } else { 0.0 }
    }
}
