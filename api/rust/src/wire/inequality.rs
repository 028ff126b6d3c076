//! Linear inequalities on the joint velocities.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A linear inequality on the joint velocities, besides the joint limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Inequality {
    /// The inequality a·q̇ ≤ b.
    Joints {
        /// Name, unique in the list; default `inequality 1`, `inequality 2`, …
        #[serde(skip_serializing_if = "Option::is_none")]
        name: Option<String>,
        /// Coefficients a, one per joint, in joint order, any unit; zero for joints that the inequality is not about.
        coefficients: Vec<f64>,
        /// Upper bound b, rad/s (or m/s) times the unit of a. For a lower bound, change the sign of `coefficients` and
        /// `upper`.
        upper: f64,
    },
    /// A virtual wall: a point p of the arm stays on one side of a plane, n·ṗ ≤ rate (offset − n·p).
    Plane {
        /// Name, unique in the list; default `inequality 1`, `inequality 2`, …
        #[serde(skip_serializing_if = "Option::is_none")]
        name: Option<String>,
        /// Normal n of the plane in the base frame, towards the forbidden side, of any length; n is the vector of length one.
        normal: [f64; 3],
        /// Distance of the plane from the base origin along n, m.
        offset_m: f64,
        /// Point p that is held back: `tool`, the name of a joint for the origin of its frame, or that of a tip or a link for the
        /// origin of that frame; default `tool`.
        #[serde(default = "tool")]
        point: String,
        /// Maximum rate at which the distance to the plane decreases, 1/s; at most 1/T. A smaller one slows the arm
        /// earlier; default 10.
        #[serde(skip_serializing_if = "Option::is_none")]
        rate_per_s: Option<f64>,
    },
}

fn tool() -> String {
    "tool".to_owned()
}

/// An active inequality: it restricts the answer. It holds with equality, or as nearly as the others permit if it is among the violated ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ActiveInequality {
    /// Name of the inequality.
    pub name: String,
    /// Upper bound b.
    pub bound: f64,
    /// Lagrange multiplier: decrease of ½ residual² of the highest restricted task per unit of a larger b.
    pub multiplier: f64,
}

/// An inequality that the answer violates: the solver is `closed_form`, or the inequalities contradict the joint
/// limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ViolatedInequality {
    /// Name of the inequality.
    pub name: String,
    /// Upper bound b.
    pub bound: f64,
    /// Value a·q̇ of the answer.
    pub value: f64,
}
