//! Stability margins of one axis in contact or in free space: maximum lag, maximum delay, minimum and maximum damping.
//!
//! One axis of a force, impedance or hybrid law touches an environment M_e Ẍ + B_e Ẋ + K_e X. The inner velocity loop
//! of the arm has a first-order lag τ and a delay of d whole periods. Together they are a linear map from period to
//! period:
//!
//! - F_e = M_e (v − v⁻)/T + B_e v + K_e x,
//! - u ← u + T M_d⁻¹ (−F_e − B_d Ẋ − K_d x), the integrator of the law. Its set-point does not affect stability. Ẋ = v if
//!   the joint velocity is measured; otherwise Ẋ = u, the last command.
//! - the velocity follows the delayed command a (u of d periods ago): v ← a + (v − a) e^(−T/τ); x ← the integral of v.
//!
//! The loop is stable if the spectral radius of the map is below 1. The map is exact, not an approximation: controller
//! and arm carry out the same recursion.
//!
//! For T → 0 and no delay, the characteristic polynomials are M_d τ s³ + M_d s² + B_d s + K_e (measured velocity) and
//! M_d τ s³ + (M_d + B_d τ) s² + B_d s + K_e (commanded velocity). They give the maximum lags B_d/K_e and
//! M_d B_d/(M_d K_e − B_d²).
//!
//! Free space is the environment M_e = B_e = K_e = 0. The loop then still contains the drive, so too large a B_d or K_d makes
//! it unstable.

mod search;

use nalgebra::Complex;

use self::search::{largest_delay, largest_lag, stable_dampings};
use crate::linalg::{EigenvalueError, Matrix, Vector, eigenvalues};

/// Maximum delay that is examined, periods. The computation time grows with its cube.
pub const MAX_DELAY_PERIODS: usize = 64;

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

/// The stability margins of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// Largest |eigenvalue| of the map from period to period. The loop is stable below 1.
    pub spectral_radius: f64,
    /// Maximum τ, s, at which the loop is stable with its delay; infinite if any; `None` if unstable at τ = 0.
    pub largest_lag_s: Option<f64>,
    /// Maximum d, up to [`MAX_DELAY_PERIODS`], at which the loop is stable with its lag; `None` if unstable at d = 0.
    pub largest_delay_periods: Option<usize>,
    /// Minimum B_d at which the loop is stable with its lag and delay; `None` if there is none.
    pub smallest_damping: Option<f64>,
    /// B_d above the minimum at which the loop becomes unstable again; `None` if there is no minimum, or no such B_d.
    pub largest_damping: Option<f64>,
}

/// The interval of B_d in which a loop is stable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StableDamping {
    /// Minimum B_d.
    pub smallest: f64,
    /// B_d above the minimum at which the loop becomes unstable again; `None` if there is none.
    pub largest: Option<f64>,
}

/// The reason why margins are missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StabilityError {
    /// The eigenvalues of the loop cannot be computed.
    #[error(transparent)]
    Eigenvalues(#[from] EigenvalueError),
    /// The caller stopped the computation.
    #[error("the computation was stopped")]
    Stopped,
}

impl Margin {
    /// Returns whether the loop is stable.
    pub fn is_stable(&self) -> bool {
        self.spectral_radius < 1.0
    }
}

impl ContactLoop {
    /// Computes the spectral radius and the margins. It computes the eigenvalues of the loop at most 700 times.
    pub fn margin(&self) -> Result<Margin, StabilityError> {
        self.margin_unless(&|| false)
    }

    /// Computes the spectral radius and the margins, and ends early with an error once `stop` returns true.
    pub fn margin_unless(&self, stop: &dyn Fn() -> bool) -> Result<Margin, StabilityError> {
        let is_stable = |axis: Self| if stop() { Err(StabilityError::Stopped) } else { Ok(axis.is_stable()?) };
        let dampings = stable_dampings(self.max_damping(), |damping| is_stable(Self { damping, ..*self }))?;
        Ok(Margin {
            spectral_radius: self.spectral_radius()?,
            largest_lag_s: largest_lag(self.period_s, |lag_s| is_stable(Self { lag_s, ..*self }))?,
            largest_delay_periods: largest_delay(|delay_periods| is_stable(Self { delay_periods, ..*self }))?,
            smallest_damping: dampings.map(|dampings| dampings.smallest),
            largest_damping: dampings.and_then(|dampings| dampings.largest),
        })
    }

    /// Computes the interval of B_d in which the loop is stable; `None` if no B_d is. The loop's own B_d does not matter.
    pub fn stable_dampings(&self) -> Result<Option<StableDamping>, StabilityError> {
        stable_dampings(self.max_damping(), |damping| Ok(Self { damping, ..*self }.is_stable()?))
    }

    /// Returns a B_d above which no loop is stable.
    ///
    /// In free space and without delay, B_d = 2 (1 + e)/(1 − e) M_d/T is the limit if the velocity is measured, with
    /// e = exp(−T/τ), and 2 M_d/T otherwise. (1 + e)/(1 − e) is at most 1 + 2τ/T.
    fn max_damping(&self) -> f64 {
        10.0 * self.inertia / self.period_s * (1.0 + 2.0 * self.lag_s / self.period_s)
    }

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
    fn growth(&self) -> Result<f64, EigenvalueError> {
        Ok(eigenvalues(&self.change_map())?.iter().map(growth).fold(-1.0, f64::max))
    }

    /// Returns (map − identity). Its columns are the changes of the unit states (x, v, v⁻, u, …, u of d periods ago).
    fn change_map(&self) -> Matrix {
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
fn growth(delta: &Complex<f64>) -> f64 {
    let radius = (1.0 + delta.re).hypot(delta.im);
    if radius > 2.0 {
        return radius - 1.0;
    }
    (2.0 * delta.re + delta.norm_sqr()) / (radius + 1.0)
}

#[cfg(test)]
mod tests;
