//! `POST /v1/stability`: how near one axis in contact is to bouncing for ever.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::object;

/// One axis of a law in contact. Linear: kg, N·s/m, N/m; angular: kg·m², N·m·s/rad, N·m/rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StabilityRequest {
    /// M_d > 0.
    pub inertia: f64,
    /// B_d.
    pub damping: f64,
    /// K_d; 0 (left out) where a force is followed.
    #[serde(default)]
    pub stiffness: f64,
    /// What the tool touches.
    #[serde(deserialize_with = "object::deserialize")]
    pub environment: EnvironmentAxis,
    /// T, s.
    pub period_s: f64,
    /// τ of the arm's velocity loop, s.
    #[serde(default)]
    pub lag_s: f64,
    /// Whole periods that a command waits.
    #[serde(default)]
    pub delay_periods: usize,
    /// Whether states carry the measured joint velocity; otherwise the last command stands for it.
    #[serde(default = "measured")]
    pub velocity_measured: bool,
}

fn measured() -> bool {
    true
}

/// M_e Ẍ + B_e Ẋ + K_e X on one axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct EnvironmentAxis {
    /// K_e.
    pub stiffness: f64,
    /// B_e.
    #[serde(default)]
    pub damping: f64,
    /// M_e.
    #[serde(default)]
    pub inertia: f64,
}

/// What a controller's tool touches and how the arm follows, as far as it is known: enough to be warned of a loop that
/// bounces for ever. It changes no command.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    /// Along x, base axes.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub x: Option<EnvironmentAxis>,
    /// Along y.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub y: Option<EnvironmentAxis>,
    /// Along z.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub z: Option<EnvironmentAxis>,
    /// About x.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub rx: Option<EnvironmentAxis>,
    /// About y.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub ry: Option<EnvironmentAxis>,
    /// About z.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub rz: Option<EnvironmentAxis>,
    /// τ of the arm's velocity loop, s.
    #[serde(default)]
    pub lag_s: f64,
    /// Whole periods that a command waits.
    #[serde(default)]
    pub delay_periods: usize,
    /// Whether states will carry the measured joint velocity; otherwise the last command stands for it.
    #[serde(default = "measured")]
    pub velocity_measured: bool,
}

/// How stable the loop is, and how far it could go.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StabilityAnswer {
    /// Whether the loop is stable.
    pub stable: bool,
    /// Largest |eigenvalue| from period to period; stable below 1.
    pub spectral_radius: f64,
    /// Largest lag at which it is stable, s; `null` if at none, or at any (see `stable_at_any_lag`).
    pub largest_lag_s: Option<f64>,
    /// Whether no lag makes it unstable.
    pub stable_at_any_lag: bool,
    /// Largest delay at which it is stable, periods; `null` if at none.
    pub largest_delay_periods: Option<usize>,
    /// Smallest B_d that makes it stable; `null` if none does.
    pub smallest_damping: Option<f64>,
}
