//! The capsules of a robot and the pairs that must keep clear.

use std::sync::Arc;

use super::separation::Segment;
use crate::LinkId;

/// A capsule that a link carries: all points within a radius of a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkCapsule {
    /// The link that carries it.
    pub link: LinkId,
    /// The segment in the frame of the link, m.
    pub core: Segment,
    /// Radius, m.
    pub radius: f64,
}

/// A pair of links that the user leaves out.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedPair {
    /// The links.
    pub links: [LinkId; 2],
    /// Why, as it was stated; may be empty.
    pub reason: String,
}

/// Why a pair is not watched.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum PairReason {
    /// At most one moving joint lies between the links.
    Neighbours,
    /// The shapes touch in all of some thousand postures.
    AlwaysTouch,
    /// The user says so.
    Stated(String),
}

/// A pair of capsules that must keep clear of each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WatchedPair {
    /// Indices of the capsules.
    pub capsules: [usize; 2],
    /// Their largest distance in a sample of postures, m.
    pub farthest_m: f64,
}

/// A pair of links that is not watched.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct LeftOutPair {
    /// Names of the links; of bodies that fixed joints connect with a link of the robot, those of the text.
    pub links: [Arc<str>; 2],
    /// Why.
    pub reason: PairReason,
}

/// The shapes of a robot, and the pairs of them that must keep clear of each other.
///
/// [`RobotModel::with_capsules`](crate::RobotModel::with_capsules) builds it.
#[derive(Debug, Clone, PartialEq)]
pub struct CollisionModel {
    capsules: Vec<LinkCapsule>,
    /// The link of the robot's text that each capsule belongs to.
    names: Vec<String>,
    /// The moving joint that carries each capsule, and the capsule's segment in the frame that this joint moves, m.
    carried: Vec<(Option<usize>, Segment)>,
    pairs: Vec<WatchedPair>,
    left_out: Vec<LeftOutPair>,
    uncovered: Vec<String>,
}

impl CollisionModel {
    /// Builds a model without pairs from capsules with the names of their links, and their joints with their segments in the frames that
    /// these move.
    pub(crate) fn new(capsules: Vec<LinkCapsule>, names: Vec<String>, carried: Vec<(Option<usize>, Segment)>) -> Self {
        Self { capsules, names, carried, pairs: Vec::new(), left_out: Vec::new(), uncovered: Vec::new() }
    }

    /// Returns the same model with these pairs.
    pub(crate) fn with_pairs(self, pairs: Vec<WatchedPair>, left_out: Vec<LeftOutPair>) -> Self {
        Self { pairs, left_out, ..self }
    }

    /// Returns the same model with these links that no capsule covers.
    pub(crate) fn with_uncovered(self, uncovered: Vec<String>) -> Self {
        Self { uncovered, ..self }
    }

    /// Returns the capsules.
    pub fn capsules(&self) -> &[LinkCapsule] {
        &self.capsules
    }

    /// Returns the link of the robot's text that each capsule belongs to. Another link carries it where fixed joints connect both.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the pairs that must keep clear of each other.
    pub fn pairs(&self) -> &[WatchedPair] {
        &self.pairs
    }

    /// Returns the pairs of links that are left out, with the reasons. Pairs of one link with itself are not listed.
    pub fn left_out(&self) -> &[LeftOutPair] {
        &self.left_out
    }

    /// Returns the links of the robot's text that have a form which no capsule covers, as far as it is known.
    pub fn uncovered(&self) -> &[String] {
        &self.uncovered
    }

    /// Returns the moving joint that carries a capsule; `None`: it stands still.
    pub fn joint(&self, capsule: usize) -> Option<usize> {
        self.carried[capsule].0
    }

    /// Returns the segment of a capsule in the frame that its joint moves, or in the base, m.
    pub(crate) fn carried_core(&self, capsule: usize) -> &Segment {
        &self.carried[capsule].1
    }
}
