//! Surfaces whose direction is not known, and the task frames that follow their normals.

mod followed;
mod normal;

pub(crate) use followed::{FollowedSurface, KnownContact};
pub use normal::{NormalEstimate, NormalReport, SlidingInput, SurfaceSettings, Touch};
