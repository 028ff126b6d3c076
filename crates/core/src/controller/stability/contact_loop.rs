//! One axis in contact, as a map from period to period.

use nalgebra::Complex;

use super::spectrum::{EigenvalueError, eigenvalues};
use crate::linalg::{Matrix, Vector};

/// One axis of a law in contact. Linear axes: kg, N·s/m, N/m; angular axes: kg·m², N·m·s/rad, N·m/rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLoop {
    /// M_d > 0, inertia of the law.
    pub inertia: f64,
    /// B_d, damping of the law.
    pub damping: f64,
    /// K_d, stiffness of the law; 0 on a force-controlled axis.
    pub stiffness: f64,
    /// M_e, inertia of the environment.
    pub environment_inertia: f64,
    /// B_e, damping of the environment.
    pub environment_damping: f64,
    /// K_e, stiffness of the environment.
    pub environment_stiffness: f64,
    /// T, control period, s.
    pub period_s: f64,
    /// τ, lag of the arm's velocity loop, s.
    pub lag_s: f64,
    /// d, delay between command and motion, periods.
    pub delay_periods: usize,
    /// Whether the law damps the measured velocity; otherwise it damps the last command.
    pub velocity_measured: bool,
}

impl ContactLoop {
    /// Returns the largest |eigenvalue| of the map from period to period.
    pub fn spectral_radius(&self) -> Result<f64, EigenvalueError> {
        Ok(1.0 + self.growth()?)
    }

    /// Returns whether the loop is stable. It is much faster than [`Self::margin`].
    pub fn is_stable(&self) -> Result<bool, EigenvalueError> {
        Ok(self.growth()? < 0.0)
    }

    /// Returns the spectral radius − 1, from the eigenvalues δ of (map − identity).
    ///
    /// For short periods the eigenvalues of the map itself are all near 1, and rounding would hide their differences.
    pub(super) fn growth(&self) -> Result<f64, EigenvalueError> {
        Ok(eigenvalues(&self.change_map())?.iter().map(growth).fold(-1.0, f64::max))
    }

    /// Returns (map − identity). Its columns are the changes of the unit states (x, v, v⁻, u, …, u of d periods ago).
    pub(super) fn change_map(&self) -> Matrix {
        let size = 4 + self.delay_periods;
        let columns: Vec<Vector> =
            (0..size).map(|i| self.change(&Matrix::identity(size, size).column(i).into())).collect();
        let map = Matrix::from_columns(&columns);
        // Without stiffness nothing depends on the position. Its eigenvalue 1 is not one of the loop, so it is removed.
        if self.environment_stiffness + self.stiffness == 0.0 { map.remove_row(0).remove_column(0) } else { map }
    }

    /// Returns the change of a state in one period.
    fn change(&self, state: &Vector) -> Vector {
        let (x, v, v_before, u) = (state[0], state[1], state[2], state[3]);
        let period = self.period_s;
        let force = self.environment_inertia * (v - v_before) / period
            + self.environment_damping * v
            + self.environment_stiffness * x;
        let damped_velocity = if self.velocity_measured { v } else { u };
        let command_change = -period / self.inertia * (force + self.damping * damped_velocity + self.stiffness * x);
        let acting = if self.delay_periods == 0 { u + command_change } else { state[2 + self.delay_periods] };
        // 1 − e^(−T/τ): the fraction of the gap between velocity and command that closes in a period.
        let closed_fraction = if self.lag_s > 0.0 { -(-period / self.lag_s).exp_m1() } else { 1.0 };
        let gap = v - acting;
        let mut change = Vector::zeros(state.len());
        change[0] = period * acting + gap * self.lag_s * closed_fraction;
        change[1] = -gap * closed_fraction;
        change[2] = v - v_before;
        change[3] = command_change;
        for i in 4..state.len() {
            change[i] = state[i - 1] - state[i];
        }
        change
    }
}

/// Returns |1 + δ| − 1 for an eigenvalue δ of (map − identity), without cancellation.
pub(super) fn growth(delta: &Complex<f64>) -> f64 {
    let radius = (1.0 + delta.re).hypot(delta.im);
    if radius > 2.0 {
        return radius - 1.0;
    }
    (2.0 * delta.re + delta.norm_sqr()) / (radius + 1.0)
}
