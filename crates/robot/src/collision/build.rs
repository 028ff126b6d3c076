//! Checks the capsules of a robot.

use nalgebra::Vector3;

use super::fit::FittedShapes;
use super::pairs::choose_pairs;
use crate::shape::{CollisionModel, LinkCapsule, StatedPair};
use crate::{DisabledPair, RobotModel};

/// Maximum number of capsules of a robot.
pub const MAX_CAPSULES: usize = 256;

/// Largest coordinate and radius of a capsule, m.
const MAX_LENGTH: f64 = 100.0;

/// Why the shapes of a robot are refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CollisionError {
    /// The numbers of a capsule are no capsule.
    #[error(
        "capsule {index} needs ends within {MAX_LENGTH} m of its link and a positive radius of at most {MAX_LENGTH} m"
    )]
    Capsule {
        /// Index of the capsule, from 0.
        index: usize,
    },
    /// There are too many capsules.
    #[error("{given} capsules; at most {MAX_CAPSULES} are allowed")]
    TooMany {
        /// Their number.
        given: usize,
    },
}

impl RobotModel {
    /// Returns the same robot with capsules from its text, as [`Self::with_capsules`] does. `disabled`: pairs of links of the text that
    /// are left out, too.
    pub fn with_fitted(
        self,
        shapes: FittedShapes,
        stated: &[StatedPair],
        disabled: &[DisabledPair],
    ) -> Result<Self, CollisionError> {
        let FittedShapes { capsules, names, uncovered } = shapes;
        let model = self.collision_model(capsules, names, (stated, disabled))?.with_uncovered(uncovered);
        Ok(self.with_collision(model))
    }

    /// Returns the same robot with these capsules; those it had before are forgotten. `stated`: pairs of links that are left out.
    ///
    /// A pair is watched unless its links are the same or neighbours, it is stated, or it touches in every posture of a fixed
    /// sample.
    pub fn with_capsules(self, capsules: Vec<LinkCapsule>, stated: &[StatedPair]) -> Result<Self, CollisionError> {
        let names: Vec<String> =
            capsules.iter().map(|capsule| self.links()[capsule.link.index()].name.clone()).collect();
        let model = self.collision_model(capsules, names, (stated, &[]))?;
        Ok(self.with_collision(model))
    }

    /// Builds the model of checked capsules with the names of their links.
    fn collision_model(
        &self,
        capsules: Vec<LinkCapsule>,
        names: Vec<String>,
        left_out: (&[StatedPair], &[DisabledPair]),
    ) -> Result<CollisionModel, CollisionError> {
        if capsules.len() > MAX_CAPSULES {
            return Err(CollisionError::TooMany { given: capsules.len() });
        }
        if let Some(index) = capsules.iter().position(|capsule| !is_valid(capsule)) {
            return Err(CollisionError::Capsule { index });
        }
        let carried = |capsule: &LinkCapsule| {
            let link = &self.links()[capsule.link.index()];
            (link.joint, capsule.core.moved(&link.placement))
        };
        let carried = capsules.iter().map(carried).collect();
        Ok(choose_pairs(self, CollisionModel::new(capsules, names, carried), left_out))
    }
}

fn is_valid(capsule: &LinkCapsule) -> bool {
    let is_short = |point: &Vector3<f64>| point.iter().all(|entry| entry.abs() <= MAX_LENGTH);
    capsule.core.ends().iter().all(is_short) && capsule.radius > 0.0 && capsule.radius <= MAX_LENGTH
}
