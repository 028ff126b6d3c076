//! The shapes of a robot at a posture.

use nalgebra::IsometryMatrix3;

use crate::kinematics::Configuration;
use crate::shape::CollisionModel;
use crate::shape::Segment;

/// The capsules of a robot and the frames that its joints move, at a posture, in the base frame.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedBody {
    frames: Vec<IsometryMatrix3<f64>>,
    cores: Vec<Segment>,
}

impl PlacedBody {
    /// Returns the body at a posture.
    pub fn new(model: &CollisionModel, configuration: &Configuration) -> Self {
        let mut placed = Self { frames: Vec::new(), cores: Vec::new() };
        placed.update(model, configuration);
        placed
    }

    /// Updates the body to another posture of the same robot, without allocating.
    pub fn update(&mut self, model: &CollisionModel, configuration: &Configuration) {
        self.frames.clear();
        self.frames.extend(configuration.moved_frames());
        self.cores.clear();
        let place = |capsule: usize| {
            let core = model.carried_core(capsule);
            model.joint(capsule).map_or(*core, |joint| core.moved(&self.frames[joint]))
        };
        self.cores.extend((0..model.capsules().len()).map(place));
    }

    /// Copies another body of the same robot, without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.frames.clone_from(&other.frames);
        self.cores.clone_from(&other.cores);
    }

    /// Returns the segment of a capsule, m.
    pub fn core(&self, capsule: usize) -> &Segment {
        &self.cores[capsule]
    }

    /// Returns the frame that a moving joint moves; the base for `None`.
    pub fn frame(&self, joint: Option<usize>) -> IsometryMatrix3<f64> {
        joint.map_or_else(IsometryMatrix3::identity, |joint| self.frames[joint])
    }
}
