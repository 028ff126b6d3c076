//! `POST /v1/stability`: stability margins of one axis in contact.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Axis, defaults, integer, object};

/// One axis of a law in contact. Linear: kg, N·s/m, N/m; angular: kg·m², N·m·s/rad, N·m/rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StabilityRequest {
    /// Inertia M_d > 0 of the law, as in the task.
    pub inertia: f64,
    /// Damping B_d of the law, as in the task; the answer names the minimum.
    pub damping: f64,
    /// Stiffness K_d of the law; default 0, as on a force-controlled axis.
    #[serde(default)]
    pub stiffness: f64,
    /// Environment that the tool touches. Take the stiffest one that it can meet.
    #[serde(deserialize_with = "object::deserialize")]
    pub environment: EnvironmentAxis,
    /// Control period T, s, as in the controller.
    pub period_s: f64,
    /// Lag τ of the arm's velocity loop, s. Take a measured one; 0 is an ideal arm. Default 0.
    #[serde(default)]
    pub lag_s: f64,
    /// Delay of a command, control periods: from the measurement to the motion that its answer causes. Default 0.
    #[serde(default, deserialize_with = "integer::deserialize")]
    pub delay_periods: usize,
    /// Whether states contain the measured joint velocity; otherwise the last command replaces it. Default `true`.
    #[serde(default = "defaults::yes")]
    pub velocity_measured: bool,
}

/// The environment on one axis, F_e = M_e Ẍ + B_e Ẋ + K_e X.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct EnvironmentAxis {
    /// Stiffness K_e, N/m or N·m/rad.
    pub stiffness: f64,
    /// Damping B_e, N·s/m or N·m·s/rad; default 0.
    #[serde(default)]
    pub damping: f64,
    /// Inertia M_e, kg or kg·m²; default 0.
    #[serde(default)]
    pub inertia: f64,
}

/// The environment of the tool and the response of the arm, as far as known. It causes warnings of unstable loops and
/// changes no command.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    /// Environment along x of the base; default: none.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub x: Option<EnvironmentAxis>,
    /// Environment along y of the base; default: none.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub y: Option<EnvironmentAxis>,
    /// Environment along z of the base; default: none.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub z: Option<EnvironmentAxis>,
    /// Environment about x of the base; default: none.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub rx: Option<EnvironmentAxis>,
    /// Environment about y of the base; default: none.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub ry: Option<EnvironmentAxis>,
    /// Environment about z of the base; default: none.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub rz: Option<EnvironmentAxis>,
    /// Lag τ of the arm's velocity loop, s. Take a measured one; 0 is an ideal arm. Default 0. A larger `lag_s` of the
    /// controller's `drive` counts, unless that is the default one.
    #[serde(default)]
    pub lag_s: f64,
    /// Delay of a command, control periods: from the measurement to the motion that its answer causes. Default 0. A
    /// larger `delay_periods` of the controller's `drive` counts, unless that is the default one.
    #[serde(default, deserialize_with = "integer::deserialize")]
    pub delay_periods: usize,
    /// Whether states contain the measured joint velocity; otherwise the last command replaces it. Default `true`.
    #[serde(default = "defaults::yes")]
    pub velocity_measured: bool,
}

impl Environment {
    /// Returns the environment on one axis.
    pub fn along(&self, axis: Axis) -> Option<EnvironmentAxis> {
        match axis {
            Axis::X => self.x,
            Axis::Y => self.y,
            Axis::Z => self.z,
            Axis::Rx => self.rx,
            Axis::Ry => self.ry,
            Axis::Rz => self.rz,
        }
    }
}

/// The stability margins of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StabilityAnswer {
    /// Whether the loop is stable.
    pub stable: bool,
    /// Spectral radius of the loop from period to period; stable below 1.
    pub spectral_radius: f64,
    /// Maximum lag at which the loop is stable, s; `null` if there is none, or if `stable_at_any_lag`. A loop that is unstable at a
    /// shorter lag needs a longer one.
    pub largest_lag_s: Option<f64>,
    /// Whether the loop is stable at any lag.
    pub stable_at_any_lag: bool,
    /// Delay up to which the loop stays stable from the stated one on, or else from zero on, control periods, at most 64; `null` if it is
    /// stable at neither.
    pub largest_delay_periods: Option<usize>,
    /// Minimum damping B_d at which the loop is stable; `null` if there is none.
    pub smallest_damping: Option<f64>,
    /// Damping B_d above `smallest_damping` at which the loop becomes unstable again; `null` if there is none.
    pub largest_damping: Option<f64>,
}
