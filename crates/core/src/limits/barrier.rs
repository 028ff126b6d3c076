//! What the arm must obey beside its joint limits, posture by posture.

use revprio_robot::kinematics::Configuration;

use super::{Inequality, VirtualPlane};

/// A linear inequality, or what makes one at each posture.
#[derive(Debug, Clone, PartialEq)]
pub enum Barrier {
    /// a·q̇ ≤ b, the same at every posture.
    Fixed(Inequality),
    /// A virtual wall.
    Plane(VirtualPlane),
}

impl Barrier {
    /// Name, for people and answers.
    pub fn name(&self) -> &str {
        match self {
            Self::Fixed(inequality) => inequality.name(),
            Self::Plane(plane) => plane.name(),
        }
    }

    /// The inequality at a posture.
    pub fn at(&self, configuration: &Configuration) -> Inequality {
        match self {
            Self::Fixed(inequality) => inequality.clone(),
            Self::Plane(plane) => plane.at(configuration),
        }
    }
}
