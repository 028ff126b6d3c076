//! Tests of the margins against continuous loops and an independent eigenvalue solver.

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use proptest::prelude::*;

use nalgebra::Complex;

use super::contact_loop::{ContactLoop, growth};
use super::search::{
    MAX_BISECTIONS, MAX_DAMPING_STEPS, MAX_DELAY_PERIODS, MAX_LAG_STEPS, bisect, largest_delay, largest_lag,
    stable_dampings,
};
use super::stability_error::StabilityError;

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
fn for_short_periods_the_maximum_lags_equal_those_of_the_continuous_loop() {
    let (m, b, k) = (WALL.inertia, WALL.damping, WALL.environment_stiffness);
    for (velocity_measured, continuous) in [(true, b / k), (false, m * b / (m * k - b * b))] {
        let axis = ContactLoop { period_s: 1e-7, velocity_measured, ..WALL };
        let lag = axis.margin().unwrap().largest_lag_s.unwrap();
        assert!((lag / continuous - 1.0).abs() < 1e-3, "{lag} instead of {continuous}");
    }
}

#[test]
fn margins_are_the_boundaries_of_stability() {
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
    let damping = lagging.margin().unwrap().largest_damping.unwrap();
    assert!(radius(ContactLoop { damping: 0.999 * damping, ..lagging }) < 1.0);
    assert!(radius(ContactLoop { damping: 1.001 * damping, ..lagging }) > 1.0);
    let delay_periods = margin.largest_delay_periods.unwrap();
    assert!(radius(ContactLoop { delay_periods, ..WALL }) < 1.0);
    assert!(radius(ContactLoop { delay_periods: delay_periods + 1, ..WALL }) > 1.0);
}

/// Odd delays are stable and even ones are not.
#[test]
fn the_largest_delay_ends_the_stable_ones_from_the_stated_one_on() {
    let axis = ContactLoop {
        inertia: 1.0,
        damping: 125.0,
        stiffness: 0.0,
        environment_inertia: 0.0,
        environment_damping: 88.9,
        environment_stiffness: 0.0,
        period_s: 0.01,
        lag_s: 0.004,
        delay_periods: 5,
        velocity_measured: false,
    };
    let radius = |delay_periods| ContactLoop { delay_periods, ..axis }.margin().unwrap().spectral_radius;
    assert!(radius(5) < 1.0 && radius(6) > 1.0 && radius(7) < 1.0);
    assert_eq!(axis.margin().unwrap().largest_delay_periods, Some(5));
}

#[test]
fn in_free_space_the_velocity_decides_stability() {
    let free = ContactLoop { environment_stiffness: 0.0, ..WALL };
    // u ← u − T B/M v with v = u: one eigenvalue 1 − T B/M.
    assert!((free.margin().unwrap().spectral_radius - 0.99).abs() < 1e-9);
}

#[test]
fn a_loop_that_cannot_be_stabilised_has_no_margins() {
    // The period is longer than that of the contact: no damping helps.
    let slow = ContactLoop { period_s: 1.0, ..WALL };
    let margin = slow.margin().unwrap();
    assert_eq!((margin.largest_lag_s, margin.largest_delay_periods), (None, None));
    assert_eq!((margin.smallest_damping, margin.largest_damping), (None, None));
    assert!(!margin.is_stable());
}

#[test]
fn a_loop_that_needs_a_lag_has_a_largest_one() {
    // B_d exceeds 2 M_d/T, the limit of an arm without lag.
    let axis =
        ContactLoop { inertia: 5.0, damping: 600.0, environment_stiffness: 1e3, period_s: 0.02, lag_s: 0.03, ..WALL };
    assert!(!ContactLoop { lag_s: 0.0, ..axis }.margin().unwrap().is_stable());
    for lag_s in [0.03, 0.0] {
        let axis = ContactLoop { lag_s, ..axis };
        let largest = axis.margin().unwrap().largest_lag_s.unwrap();
        assert!(ContactLoop { lag_s: 0.999 * largest, ..axis }.margin().unwrap().is_stable());
        assert!(!ContactLoop { lag_s: 1.001 * largest, ..axis }.margin().unwrap().is_stable());
    }
}

/// A name, and the result of the k-th call.
type Answers = (&'static str, fn(usize) -> bool);

/// Tests of stability that never let a search converge, with what they return at their k-th call.
const WITHOUT_CONVERGENCE: [Answers; 4] = [
    ("always stable", |_| true),
    ("stable only at the start", |call| call == 0),
    ("stable only after the start", |call| call > 0),
    ("alternating", |call| call % 2 == 0),
];

#[test]
fn searches_that_do_not_converge_end_after_a_bounded_number_of_steps() {
    for (name, answer) in WITHOUT_CONVERGENCE {
        // Sizes at which products and quotients overflow, vanish or are not numbers.
        for size in [0.0, 5e-324, 1e-300, 1e-200, 1.0, 1e300, f64::MAX, f64::INFINITY, f64::NAN] {
            let calls = std::cell::Cell::new(0);
            let test = || {
                calls.set(calls.get() + 1);
                Ok(answer(calls.get() - 1))
            };
            let limits = [
                (largest_lag(size, size, |_| test()).is_ok(), MAX_LAG_STEPS + MAX_BISECTIONS + 2),
                (largest_delay(1, |_| test()).is_ok(), 2 * MAX_DELAY_PERIODS),
                (stable_dampings(size, |_| test()).is_ok(), MAX_DAMPING_STEPS + 2 * MAX_BISECTIONS + 1),
                (bisect(size, 0.0, |_| test()).is_ok(), MAX_BISECTIONS),
                // The boundary is at zero, where a relative accuracy is never reached.
                (bisect(0.0, size, |_| Ok(false)).is_ok(), MAX_BISECTIONS),
            ];
            assert!(limits.iter().all(|(ended, _)| *ended));
            let max: usize = limits.iter().map(|(_, max)| max).sum();
            assert!(calls.get() <= max, "{name}, {size}: {} calls", calls.get());
        }
    }
}

#[test]
fn a_stopped_search_ends_at_once() {
    let calls = std::cell::Cell::new(0);
    let stop = || {
        calls.set(calls.get() + 1);
        calls.get() > 3
    };
    assert_eq!(WALL.margin_unless(&stop), Err(StabilityError::Stopped));
    assert_eq!(calls.get(), 4);
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
        delay_periods in 0..=MAX_DELAY_PERIODS,
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
        // A delay line alone has a multiple eigenvalue 0 of the map. Rounding moves it to radii below 0.6, and the vectors of
        // an eigenvalue of radius r grow by 1/r along the line: its condition number is r^−d.
        prop_assume!(expected > -0.3);
        let line = i32::try_from(delay_periods).unwrap();
        let lost = 10.0 * f64::EPSILON * (1.0 + expected).powi(-line);
        prop_assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()) + lost, "{found} instead of {expected}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]
    #[test]
    fn every_loop_gets_an_answer_in_bounded_time(
        inertia in power(-300.0, 300.0),
        damping in power(-300.0, 300.0),
        environment_stiffness in power(-300.0, 300.0),
        environment_inertia in prop_oneof![Just(0.0), power(-300.0, 300.0)],
        period_s in power(-320.0, 300.0),
        lag_s in prop_oneof![Just(0.0), power(-300.0, 300.0)],
        delay_periods in 0..9_usize,
    ) {
        let axis = ContactLoop {
            inertia, damping, environment_inertia, environment_stiffness, period_s, lag_s, delay_periods, ..WALL
        };
        prop_assert!(axis.margin().map_or(true, |margin| margin.spectral_radius.is_finite()));
    }
}

/// 10^low … 10^high, with a uniform exponent.
fn power(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high).prop_map(|exponent| 10.0_f64.powf(exponent))
}
