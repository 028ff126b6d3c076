//! How near one axis in contact is to bouncing for ever.
//!
//! The force, impedance and hybrid laws on one axis against M_e Ẍ + B_e Ẋ + K_e X, through an inner velocity loop with a
//! first-order lag τ and a delay of d whole periods, are a linear map from period to period:
//!
//! - F_e = M_e (v − v⁻)/T + B_e v + K_e x,
//! - u ← u + T M_d⁻¹ (−F_e − B_d Ẋ − K_d x), the integrator of the law (its set-point does not matter for stability),
//!   with Ẋ = v where the joint velocity is measured and Ẋ = u, the last command, where it is not,
//! - the arm follows a = u (d periods ago) exactly: v ← a + (v − a) e^(−T/τ), x ← its integral.
//!
//! For T → 0 and no delay, M_d τ s³ + M_d s² + B_d s + K_e (measured) and M_d τ s³ + (M_d + B_d τ) s² + B_d s + K_e
//! (commanded) give the largest lags B_d/K_e and M_d B_d/(M_d K_e − B_d²).
//!
//! The loop is stable if the spectral radius of that map is below 1. Nothing is approximated: it is the recursion that
//! controller and arm carry out.

use nalgebra::Complex;

use crate::linalg::{EigenvalueError, Matrix, Vector, eigenvalues};

/// Longest delay that is looked at, periods; the cost grows with its cube.
pub const LONGEST_DELAY: usize = 64;

/// Relative accuracy of the margins.
const ACCURACY: f64 = 1e-9;

/// One axis of a law in contact; linear axes in kg, N·s/m, N/m, angular ones in kg·m², N·m·s/rad, N·m/rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLoop {
    /// M_d > 0.
    pub inertia: f64,
    /// B_d.
    pub damping: f64,
    /// K_d; 0 where a force is followed.
    pub stiffness: f64,
    /// M_e.
    pub environment_inertia: f64,
    /// B_e.
    pub environment_damping: f64,
    /// K_e.
    pub environment_stiffness: f64,
    /// T, s.
    pub period_s: f64,
    /// τ, s.
    pub lag_s: f64,
    /// d.
    pub delay_periods: usize,
    /// Whether the law damps the measured velocity; otherwise the last command stands for it.
    pub velocity_measured: bool,
}

/// How stable a loop is, and how far it could go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// Largest |eigenvalue| of the map from period to period; stable below 1.
    pub spectral_radius: f64,
    /// Largest τ, s, at which the loop, with its delay, is still stable; `None` if it is not even at τ = 0.
    pub largest_lag_s: Option<f64>,
    /// Largest d, up to [`LONGEST_DELAY`], at which the loop, with its lag, is still stable; `None` if it is not even
    /// without delay.
    pub largest_delay_periods: Option<usize>,
    /// Smallest B_d that makes the loop, with its lag and delay, stable; `None` if none does.
    pub smallest_damping: Option<f64>,
}

impl Margin {
    /// Whether the loop is stable.
    pub fn is_stable(&self) -> bool {
        self.spectral_radius < 1.0
    }
}

impl ContactLoop {
    /// Spectral radius and margins.
    pub fn margin(&self) -> Result<Margin, EigenvalueError> {
        Ok(Margin {
            spectral_radius: 1.0 + self.growth()?,
            largest_lag_s: self.largest_lag()?,
            largest_delay_periods: self.largest_delay()?,
            smallest_damping: self.smallest_damping()?,
        })
    }

    /// Whether the loop is stable; far quicker than all its margins.
    pub fn is_stable(&self) -> Result<bool, EigenvalueError> {
        Ok(self.growth()? < 0.0)
    }

    /// Spectral radius − 1, from the eigenvalues δ of (map − identity): those of the map itself crowd around 1 for short
    /// periods, where rounding would blur them.
    fn growth(&self) -> Result<f64, EigenvalueError> {
        Ok(eigenvalues(&self.change_map())?.iter().map(growth).fold(-1.0, f64::max))
    }

    /// (Map − identity), column by column: how each unit state (x, v, v⁻, u, …, u d periods ago) changes in a period.
    fn change_map(&self) -> Matrix {
        let size = 4 + self.delay_periods;
        let columns: Vec<Vector> =
            (0..size).map(|i| self.change(&Matrix::identity(size, size).column(i).into())).collect();
        let map = Matrix::from_columns(&columns);
        // Without any stiffness nothing depends on the position, and its eigenvalue of 1 says nothing about the loop.
        if self.environment_stiffness + self.stiffness == 0.0 { map.remove_row(0).remove_column(0) } else { map }
    }

    fn change(&self, state: &Vector) -> Vector {
        let (x, v, v_before, u) = (state[0], state[1], state[2], state[3]);
        let period = self.period_s;
        let force = self.environment_inertia * (v - v_before) / period
            + self.environment_damping * v
            + self.environment_stiffness * x;
        let felt = if self.velocity_measured { v } else { u };
        let command_change = -period / self.inertia * (force + self.damping * felt + self.stiffness * x);
        let acting = if self.delay_periods == 0 { u + command_change } else { state[2 + self.delay_periods] };
        // 1 − e^(−T/τ): the part of the gap between velocity and command that closes in a period.
        let closed = if self.lag_s > 0.0 { -(-period / self.lag_s).exp_m1() } else { 1.0 };
        let gap = v - acting;
        let mut change = Vector::zeros(state.len());
        change[0] = period * acting + gap * self.lag_s * closed;
        change[1] = -gap * closed;
        change[2] = v - v_before;
        change[3] = command_change;
        for place in 4..state.len() {
            change[place] = state[place - 1] - state[place];
        }
        change
    }

    fn largest_lag(&self) -> Result<Option<f64>, EigenvalueError> {
        let with_lag = |lag_s: f64| Self { lag_s, ..*self }.is_stable();
        if !with_lag(0.0)? {
            return Ok(None);
        }
        let mut stable = 0.0;
        let mut lag = self.period_s * 1e-3;
        // Longer than any inner loop: 10^9 periods count as "any lag".
        while with_lag(lag)? {
            if lag > 1e9 * self.period_s {
                return Ok(Some(f64::INFINITY));
            }
            stable = lag;
            lag *= 1.25;
        }
        bisect(stable, lag, with_lag).map(Some)
    }

    fn largest_delay(&self) -> Result<Option<usize>, EigenvalueError> {
        let with_delay = |delay_periods: usize| Self { delay_periods, ..*self }.is_stable();
        if !with_delay(0)? {
            return Ok(None);
        }
        let (mut stable, mut unstable) = (0, 1);
        while unstable <= LONGEST_DELAY && with_delay(unstable)? {
            (stable, unstable) = (unstable, 2 * unstable);
        }
        while stable < LONGEST_DELAY && unstable - stable > 1 {
            let middle = usize::midpoint(stable, unstable);
            if with_delay(middle)? {
                stable = middle;
            } else {
                unstable = middle;
            }
        }
        Ok(Some(stable))
    }

    fn smallest_damping(&self) -> Result<Option<f64>, EigenvalueError> {
        let with_damping = |damping: f64| Self { damping, ..*self }.is_stable();
        if with_damping(0.0)? {
            return Ok(Some(0.0));
        }
        // More than M_d/T per period turns the velocity round; no loop is stable far beyond.
        let most = 10.0 * self.inertia / self.period_s;
        let mut unstable = 0.0;
        let mut damping = 1e-9 * most;
        while damping < most {
            if with_damping(damping)? {
                return bisect(damping, unstable, with_damping).map(Some);
            }
            unstable = damping;
            damping *= 1.1;
        }
        Ok(None)
    }
}

/// |1 + δ| − 1 of an eigenvalue δ of (map − identity), without cancellation.
fn growth(delta: &Complex<f64>) -> f64 {
    let radius = (1.0 + delta.re).hypot(delta.im);
    (2.0 * delta.re + delta.norm_sqr()) / (radius + 1.0)
}

/// The boundary between a stable and an unstable value, on its stable side.
fn bisect(
    mut stable: f64,
    mut unstable: f64,
    is_stable: impl Fn(f64) -> Result<bool, EigenvalueError>,
) -> Result<f64, EigenvalueError> {
    while (stable - unstable).abs() > ACCURACY * stable.abs().max(unstable.abs()) {
        let middle = f64::midpoint(stable, unstable);
        if is_stable(middle)? {
            stable = middle;
        } else {
            unstable = middle;
        }
    }
    Ok(stable)
}

#[cfg(test)]
mod tests {
    use nalgebra::linalg::balancing::balance_parlett_reinsch;
    use proptest::prelude::*;

    use super::*;

    /// The paper's gains on x against the stiff wall.
    const WALL: ContactLoop = ContactLoop {
        inertia: 15.0,
        damping: 150.0,
        stiffness: 0.0,
        environment_inertia: 0.0,
        environment_damping: 0.0,
        environment_stiffness: 1e5,
        period_s: 0.001,
        lag_s: 0.0,
        delay_periods: 0,
        velocity_measured: true,
    };

    #[test]
    fn for_short_periods_the_largest_lags_are_those_of_the_continuous_loop() {
        let (m, b, k) = (WALL.inertia, WALL.damping, WALL.environment_stiffness);
        for (velocity_measured, continuous) in [(true, b / k), (false, m * b / (m * k - b * b))] {
            let axis = ContactLoop { period_s: 1e-7, velocity_measured, ..WALL };
            let lag = axis.margin().unwrap().largest_lag_s.unwrap();
            assert!((lag / continuous - 1.0).abs() < 1e-3, "{lag} instead of {continuous}");
        }
    }

    #[test]
    fn margins_are_boundaries() {
        let margin = WALL.margin().unwrap();
        assert!(margin.is_stable());
        let lag_s = margin.largest_lag_s.unwrap();
        let radius = |axis: ContactLoop| axis.margin().unwrap().spectral_radius;
        assert!(radius(ContactLoop { lag_s: 0.999 * lag_s, ..WALL }) < 1.0);
        assert!(radius(ContactLoop { lag_s: 1.001 * lag_s, ..WALL }) > 1.0);
        let lagging = ContactLoop { lag_s: 0.005, ..WALL };
        let damping = lagging.margin().unwrap().smallest_damping.unwrap();
        assert!(radius(lagging) > 1.0);
        assert!(radius(ContactLoop { damping: 1.001 * damping, ..lagging }) < 1.0);
        assert!(radius(ContactLoop { damping: 0.999 * damping, ..lagging }) > 1.0);
        let delay_periods = margin.largest_delay_periods.unwrap();
        assert!(radius(ContactLoop { delay_periods, ..WALL }) < 1.0);
        assert!(radius(ContactLoop { delay_periods: delay_periods + 1, ..WALL }) > 1.0);
    }

    #[test]
    fn in_free_space_the_velocity_alone_decides() {
        let free = ContactLoop { environment_stiffness: 0.0, ..WALL };
        // u ← u − T B/M v with v = u: one eigenvalue 1 − T B/M.
        assert!((free.margin().unwrap().spectral_radius - 0.99).abs() < 1e-9);
    }

    #[test]
    fn a_loop_that_nothing_stabilises_says_so() {
        // A period longer than the contact's own: no damping helps.
        let slow = ContactLoop { period_s: 1.0, ..WALL };
        let margin = slow.margin().unwrap();
        assert_eq!((margin.largest_lag_s, margin.largest_delay_periods, margin.smallest_damping), (None, None, None));
        assert!(!margin.is_stable());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]
        #[test]
        fn growth_agrees_with_an_independent_eigenvalue_solver(
            inertia in power(-2.0, 3.0),
            damping in power(-2.0, 5.0),
            stiffness in prop_oneof![Just(0.0), power(0.0, 4.0)],
            environment_inertia in prop_oneof![Just(0.0), power(-3.0, 1.0)],
            environment_damping in prop_oneof![Just(0.0), power(-2.0, 3.0)],
            environment_stiffness in prop_oneof![Just(0.0), power(0.0, 7.0)],
            period_s in power(-4.0, -1.0),
            lag_s in prop_oneof![Just(0.0), power(-4.0, 0.0)],
            delay_periods in 0..=LONGEST_DELAY,
            velocity_measured: bool,
        ) {
            let axis = ContactLoop {
                inertia, damping, stiffness, environment_inertia, environment_damping, environment_stiffness,
                period_s, lag_s, delay_periods, velocity_measured,
            };
            let mut map = axis.change_map();
            balance_parlett_reinsch(&mut map);
            let (rows, columns) = map.shape();
            let map = faer::MatRef::from_column_major_slice(map.as_slice(), rows, columns);
            let eigenvalues = map.eigenvalues().unwrap();
            let growths = eigenvalues.iter().map(|value| growth(&Complex::new(value.re, value.im)));
            let (expected, found) = (growths.fold(-1.0, f64::max), axis.growth().unwrap());
            // A delay line alone has a multiple eigenvalue 0 of the map. Rounding moves it to radii below 0.6.
            prop_assume!(expected > -0.3);
            prop_assert!((found - expected).abs() < 1e-10 * (1.0 + expected.abs()), "{found} instead of {expected}");
        }
    }

    /// 10^low … 10^high, each power of ten as likely as the others.
    fn power(low: f64, high: f64) -> impl Strategy<Value = f64> {
        (low..high).prop_map(|exponent| 10.0_f64.powf(exponent))
    }
}
