//! Barriers: inequalities that a controller must obey besides the joint limits, such as virtual walls.

use nalgebra::Vector3;
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

    /// Returns the inequality at a posture; `distance_to_rest`: p − q of each joint, n, as in
    /// [`JointMotion`](super::JointMotion).
    pub fn at(&self, configuration: &Configuration, distance_to_rest: &[f64]) -> Inequality {
        match self {
            Self::Fixed(inequality) => inequality.clone(),
            Self::Plane(plane) => plane.at(configuration, distance_to_rest),
        }
    }
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

/// A virtual wall n·p ≤ d for a point p of the arm, kept by n·ṗ ≤ γ (d − n·p).
///
/// The distance to the wall decreases no faster than e^(−γ t). Behind the wall, the inequality demands a motion back.
/// It is a linearisation at the present posture; the error is of second order in the displacement of one period.
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
    /// `distance_to_rest`: p − q of each joint, n, or empty. The distance to the wall is that of the point at rest if the
    /// point still approaches.
    pub fn at(&self, configuration: &Configuration, distance_to_rest: &[f64]) -> Inequality {
        let (position, jacobian) = match self.point {
            PlanePoint::Tool => {
                let jacobian = configuration.jacobian().fixed_rows::<3>(0).into_owned();
                (configuration.tool_pose().translation.vector, jacobian)
            }
            PlanePoint::Joint(joint) => configuration.joint_origin(joint),
        };
        let along = jacobian.transpose() * self.normal;
        if along.norm() <= RANK_TOLERANCE * jacobian.norm() {
            return Inequality::always_satisfied(self.name.clone(), along.len());
        }
        let approach: f64 = along.iter().zip(distance_to_rest).map(|(along, to_rest)| along * to_rest).sum();
        let bound = self.rate * (self.offset - self.normal.dot(&position) - approach.max(0.0));
        Inequality { name: self.name.clone(), coefficients: Vector::from_column_slice(along.as_slice()), bound }
    }
}
