//! Virtual walls: planes that a point of the arm must not pass.

use nalgebra::Vector3;
use revprio_robot::kinematics::Configuration;

use super::Inequality;
use crate::linalg::{RANK_TOLERANCE, Vector};

/// Approach rate where none is given, 1/s: 0.5 m/s towards a wall slow down with at most 5 m/s².
pub const APPROACH_RATE: f64 = 10.0;

/// A point of the arm that is held back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PlanePoint {
    /// The tool point.
    #[default]
    Tool,
    /// The origin of a joint's frame (index from 0), for example the elbow.
    Joint(usize),
}

/// n·p ≤ d for a point p of the arm, approached no faster than its distance closes: n·ṗ ≤ γ (d − n·p).
///
/// The distance then never falls faster than e^(−γ t); beyond the plane, the inequality asks for the way back. It is a
/// linearisation, exact to second order in the way of one period.
#[derive(Debug, Clone, PartialEq)]
pub struct VirtualPlane {
    name: String,
    normal: Vector3<f64>,
    offset: f64,
    point: PlanePoint,
    rate: f64,
}

/// Why a plane is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum VirtualPlaneError {
    /// A number is NaN or infinite.
    #[error("normal, offset and rate must be finite numbers")]
    NotFinite,
    /// A normal without length has no direction.
    #[error("the normal must differ from zero")]
    Normal,
    /// Without a positive rate the arm could never approach.
    #[error("the rate must be positive")]
    Rate,
}

impl VirtualPlane {
    /// `normal`: n, base frame, pointing to the forbidden side, of any length; `offset`: d, m along the unit normal;
    /// `rate`: γ, 1/s, at most 1/T for a control period T: faster would pass the plane within a period.
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

    /// Name, for people and answers.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The point that is held back.
    pub fn point(&self) -> PlanePoint {
        self.point
    }

    /// γ, 1/s.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// The inequality at a posture; without content where no joint moves the point along the normal.
    pub fn at(&self, configuration: &Configuration) -> Inequality {
        let (position, jacobian) = match self.point {
            PlanePoint::Tool => {
                let jacobian = configuration.jacobian().fixed_rows::<3>(0).into_owned();
                (configuration.tool_pose().translation.vector, jacobian)
            }
            PlanePoint::Joint(joint) => configuration.joint_origin(joint),
        };
        let along = jacobian.transpose() * self.normal;
        if along.norm() <= RANK_TOLERANCE * jacobian.norm() {
            return Inequality::without_content(self.name.clone(), along.len());
        }
        let bound = self.rate * (self.offset - self.normal.dot(&position));
        Inequality { name: self.name.clone(), coefficients: Vector::from_column_slice(along.as_slice()), bound }
    }
}
