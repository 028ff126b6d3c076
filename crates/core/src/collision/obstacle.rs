//! Shapes of the world.

use std::sync::Arc;

use nalgebra::Vector3;
use revprio_robot::collision::{OrientedBox, Segment, Separation};

/// Largest coordinate and size of an obstacle, m.
const MAX_LENGTH: f64 = 1e3;

/// Largest speed of an obstacle, m/s.
const MAX_SPEED: f64 = 100.0;

/// The shape of an obstacle, base frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ObstacleShape {
    /// All points within a radius of a segment; a sphere if both ends are the same.
    Capsule {
        /// The segment.
        core: Segment,
        /// Radius.
        radius: f64,
    },
    /// A box.
    Box(OrientedBox),
    /// All points x with n·x ≤ offset, for example the floor.
    HalfSpace {
        /// n, a unit vector towards the free side.
        normal: Vector3<f64>,
        /// Distance of the surface from the base origin along n.
        offset: f64,
    },
}

/// Something that stands or moves in the room.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// Name.
    pub name: Arc<str>,
    /// Shape, where it is.
    pub shape: ObstacleShape,
    /// Whether each state says where it is.
    pub moves: bool,
}

/// Where an obstacle is and how it moves.
#[derive(Debug, Clone, PartialEq)]
pub struct ObstacleState {
    /// Name of the obstacle.
    pub name: Arc<str>,
    /// Position of its middle, base frame, m.
    pub position: Vector3<f64>,
    /// Velocity, base frame, m/s.
    pub velocity: Vector3<f64>,
}

/// Why an obstacle is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ObstacleError {
    /// A number is NaN, infinite or too large.
    #[error("positions and sizes must be finite and at most 1000 m, speeds at most 100 m/s")]
    Number,
    /// A radius or an edge is not positive.
    #[error("radius and edges must be positive, at most 1000 m")]
    Size,
    /// The normal has length zero.
    #[error("the normal must differ from zero")]
    Normal,
    /// A half-space cannot move.
    #[error("a half-space cannot move; use a box")]
    HalfSpaceMoves,
}

impl ObstacleShape {
    /// Returns the distance of a capsule's segment to this shape less this shape's radius.
    #[inline]
    pub(super) fn separation(&self, core: &Segment, shift: Vector3<f64>) -> Separation {
        match self {
            Self::Capsule { core: own, radius } => {
                let found = core.to_segment(&own.shifted(shift));
                Separation { distance: found.distance - radius, ..found }
            }
            Self::Box(own) => core.to_box(&own.shifted(shift)),
            Self::HalfSpace { normal, offset } => core.to_half_space(normal, *offset),
        }
    }

    /// Returns the largest n·f over the points f of this shape, m; for a half-space n must be its normal.
    #[inline]
    pub(super) fn support(&self, normal: &Vector3<f64>, shift: Vector3<f64>) -> f64 {
        match self {
            Self::Capsule { core, radius } => core.support(normal) + normal.dot(&shift) + radius,
            Self::Box(own) => own.support(normal) + normal.dot(&shift),
            Self::HalfSpace { offset, .. } => *offset,
        }
    }

    /// Returns the position of its middle, m.
    pub fn middle(&self) -> Vector3<f64> {
        match self {
            Self::Capsule { core, .. } => 0.5 * (core.from + core.to),
            Self::Box(own) => own.pose.translation.vector,
            Self::HalfSpace { normal, offset } => normal * *offset,
        }
    }

    fn check(&self) -> Result<Self, ObstacleError> {
        let is_short = |point: &Vector3<f64>| point.iter().all(|entry| entry.abs() <= MAX_LENGTH);
        let is_size = |size: f64| size > 0.0 && size <= MAX_LENGTH;
        match *self {
            Self::Capsule { core, .. } if !core.ends().iter().all(is_short) => Err(ObstacleError::Number),
            Self::Capsule { radius, .. } if !is_size(radius) => Err(ObstacleError::Size),
            Self::Box(own) if !is_short(&own.pose.translation.vector) => Err(ObstacleError::Number),
            Self::Box(own) if !own.half.iter().all(|half| is_size(*half)) => Err(ObstacleError::Size),
            Self::HalfSpace { normal, offset } if !(is_short(&normal) && offset.abs() <= MAX_LENGTH) => {
                Err(ObstacleError::Number)
            }
            Self::HalfSpace { normal, offset } => match normal.try_normalize(f64::MIN_POSITIVE.sqrt()) {
                Some(normal) => Ok(Self::HalfSpace { normal, offset }),
                None => Err(ObstacleError::Normal),
            },
            Self::Capsule { .. } | Self::Box(_) => Ok(*self),
        }
    }
}

impl Obstacle {
    /// Checks and builds an obstacle; `moves`: each state says where it is.
    pub fn new(name: impl Into<Arc<str>>, shape: ObstacleShape, moves: bool) -> Result<Self, ObstacleError> {
        if moves && matches!(shape, ObstacleShape::HalfSpace { .. }) {
            return Err(ObstacleError::HalfSpaceMoves);
        }
        Ok(Self { name: name.into(), shape: shape.check()?, moves })
    }
}

impl ObstacleState {
    /// Returns why the state is refused.
    pub fn check(&self) -> Result<(), ObstacleError> {
        let is_within = |vector: &Vector3<f64>, most: f64| vector.iter().all(|entry| entry.abs() <= most);
        let is_valid = is_within(&self.position, MAX_LENGTH) && is_within(&self.velocity, MAX_SPEED);
        if is_valid { Ok(()) } else { Err(ObstacleError::Number) }
    }
}
