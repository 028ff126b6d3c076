//! The shapes of a robot, which of them must keep clear of each other, and their distances.
//!
//! A link is covered by *capsules*: all points within a radius of a segment. A sphere is a capsule of length zero. A pair of
//! capsules is watched unless a reason speaks against it, and every pair that is left out is listed with its reason.

mod build;
mod fit;
mod gradient;
mod lever;
mod pairs;
mod placed;

pub use self::build::{CollisionError, MAX_CAPSULES};
pub use self::fit::{
    ColladaError, FitError, FittedCapsule, FittedShapes, MeshDirectory, MeshError, StlError, Triangle,
};
pub use self::gradient::BodyPoint;
pub use self::lever::{Levers, last_common, levers};
pub use self::placed::PlacedBody;
pub use crate::shape::{
    CollisionModel, LeftOutPair, LinkCapsule, OrientedBox, PairReason, Segment, Separation, StatedPair, WatchedPair,
};
