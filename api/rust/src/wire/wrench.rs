//! A force with a torque.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Force and torque at the tool point, or at another tip, along the axes of the controller's `wrench_frame`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Wrench {
    /// Force x, y, z, N.
    pub force: [f64; 3],
    /// Torque x, y, z, N·m.
    pub torque: [f64; 3],
}
