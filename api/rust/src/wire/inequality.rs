//! Linear inequalities beside the joint limits.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What the joint velocities must obey beside the box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Inequality {
    /// a·q̇ ≤ b.
    Joints {
        /// Name, unique in the list; `inequality 1`, `inequality 2`, … if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        name: Option<String>,
        /// a, one per joint, in joint order.
        coefficients: Vec<f64>,
        /// b, rad/s times the unit of a.
        upper: f64,
    },
    /// A point of the arm stays on one side of a plane: n·ṗ ≤ rate (offset − n·p).
    Plane {
        /// Name, unique in the list; `inequality 1`, `inequality 2`, … if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        name: Option<String>,
        /// n, base frame, towards the forbidden side; its length does not matter.
        normal: [f64; 3],
        /// Distance of the plane from the base along n, m.
        offset_m: f64,
        /// `tool`, or the name of a joint whose frame origin is held back.
        #[serde(default = "tool")]
        point: String,
        /// How fast the distance may close, 1/s; 10 if left out, at most one over the period.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rate_per_s: Option<f64>,
    },
}

fn tool() -> String {
    "tool".to_owned()
}

/// An inequality that holds the answer back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ActiveInequality {
    /// Its name.
    pub name: String,
    /// b.
    pub bound: f64,
    /// How much ½ residual² of the highest task that it holds back would fall per unit of a larger b.
    pub multiplier: f64,
}

/// An inequality that the answer breaks: by the solver `closed_form`, or because the joint limits leave no other way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ViolatedInequality {
    /// Its name.
    pub name: String,
    /// b.
    pub bound: f64,
    /// a·q̇.
    pub value: f64,
}
