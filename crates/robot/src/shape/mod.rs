//! Shapes: capsules on the links of a robot, boxes, and the distance of two of them.

mod collision_model;
mod separation;

pub use self::collision_model::{CollisionModel, LeftOutPair, LinkCapsule, PairReason, StatedPair, WatchedPair};
pub use self::separation::{OrientedBox, Segment, Separation};
