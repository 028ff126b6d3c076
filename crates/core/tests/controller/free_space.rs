//! Stability of laws in free space: only the drive and the period close the loop.

use std::f64::consts::FRAC_PI_2;

use revprio_core::controller::{ContactLoop, StableDamping};

/// The paper's gains on x with a period of 10 ms and the lag of the default drive.
const FREE: ContactLoop = ContactLoop {
    inertia: 15.0,
    damping: 150.0,
    stiffness: 0.0,
    environment_inertia: 0.0,
    environment_damping: 0.0,
    environment_stiffness: 0.0,
    period_s: 0.01,
    lag_s: 0.03,
    delay_periods: 0,
    velocity_measured: true,
};

fn largest_damping(axis: ContactLoop) -> f64 {
    axis.stable_dampings().unwrap().unwrap().largest.unwrap()
}

#[test]
fn the_largest_damping_is_that_of_the_characteristic_polynomial() {
    let is_near = |found: f64, expected: f64| {
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} instead of {expected}");
    };
    let mass_per_period = FREE.inertia / FREE.period_s;
    // α = B T/M. Measured: z² − (1 + e − α (1 − e)) z + e, stable for α < 2 (1 + e)/(1 − e).
    let e = (-FREE.period_s / FREE.lag_s).exp();
    is_near(largest_damping(FREE), 2.0 * (1.0 + e) / (1.0 - e) * mass_per_period);
    for delay_periods in [1, 2, 8] {
        // Commanded: the eigenvalue 1 − α, whatever the drive is.
        let commanded = ContactLoop { velocity_measured: false, delay_periods, ..FREE };
        is_near(largest_damping(commanded), 2.0 * mass_per_period);
        // Without lag: the state of d periods ago is damped, so z^d (z − 1) + α, stable for α < 2 sin(π/(4 d + 2)).
        let without_lag = ContactLoop { lag_s: 0.0, delay_periods, ..FREE };
        let limit = 2.0 * (FRAC_PI_2 / (2 * delay_periods + 1) as f64).sin();
        is_near(largest_damping(without_lag), limit * mass_per_period);
    }
}

#[test]
fn without_damping_the_loop_is_not_stable() {
    for delay_periods in [0, 1, 2, 8, 32, 64] {
        for velocity_measured in [true, false] {
            for lag_s in [0.0, 0.03] {
                let axis = ContactLoop { damping: 0.0, delay_periods, velocity_measured, lag_s, ..FREE };
                let radius = axis.spectral_radius().unwrap();
                assert!((radius - 1.0).abs() < 1e-14, "{radius}");
            }
        }
    }
}

/// Name, lag (s) and delay (periods) of the drives in the tables.
const DRIVES: [(&str, f64, usize); 5] = [
    ("none", 0.0, 0),
    ("5 ms, none", 0.005, 0),
    ("10 ms, 1 period", 0.01, 1),
    ("20 ms, 1 period", 0.02, 1),
    ("30 ms, 2 periods (default)", 0.03, 2),
];

#[test]
#[ignore = "prints the tables of docs/guides/choose-gains.md"]
fn free_space_tables() {
    for (name, lag_s, delay_periods) in DRIVES {
        let drive = ContactLoop { inertia: 1.0, lag_s, delay_periods, ..FREE };
        for (measured, velocity_measured) in [("yes", true), ("no", false)] {
            let cells = [0.001, 0.002, 0.005, 0.01, 0.02].map(|period_s| {
                format!("{:.1}", largest_damping(ContactLoop { period_s, velocity_measured, ..drive }))
            });
            println!("| {name} | {measured} | {} |", cells.join(" | "));
        }
    }
    for (name, lag_s, delay_periods) in DRIVES {
        let drive = ContactLoop { inertia: 1.0, lag_s, delay_periods, ..FREE };
        let cells = [10.0, 100.0, 400.0, 1000.0, 4000.0].map(|stiffness| {
            let [Some(measured), Some(commanded)] = [true, false].map(|velocity_measured| {
                ContactLoop { stiffness, velocity_measured, ..drive }.stable_dampings().unwrap()
            }) else {
                return "none".to_owned();
            };
            let largest = |dampings: StableDamping| dampings.largest.unwrap_or(f64::INFINITY);
            let (low, high) = (measured.smallest.max(commanded.smallest), largest(measured).min(largest(commanded)));
            if low < high { format!("{low:.1} to {high:.1}") } else { "none".to_owned() }
        });
        println!("| {name} | {} |", cells.join(" | "));
    }
}
