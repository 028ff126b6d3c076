//! What an impact costs at least, and the approach speed that follows from it.
//!
//! No controller reacts before a reading exceeds the noise, and these brake with a, the acceleration of this law, at most. Until the reading and the reaction the
//! tool moves on at v, and then its velocity follows the command v − a t with the lag L:
//!
//! F = K (v τ + v t − a (½ t² − L t + L² (1 − e^(−t/L)))), τ = t_det + (D + ½) T,
//!
//! at the time t at which the tool stops, t − L (1 − e^(−t/L)) = v/a. The reading comes up to T after t_det; a staircase of commands that
//! starts at once leads the ramp by ½ T. The reading of a ramp K v t behind a sensor lag τ_f exceeds
//! 3 σ + b at t_det. As s − l (1 − e^(−s/l)) ≥ s²/(2 l + s), both times have the upper bound (c + √(c² + 8 c l))/2 with the value c
//! of the left side.

use super::settings::ContactSettings;
use super::timing::ContactTiming;

/// Share of the target force that the peak at the default approach speed may reach, over what the law needs more than the smallest
/// peak: 1.2/1.1.
const PEAK_SHARE: f64 = 1.2 / 1.1;

/// Iterations for the approach speed. Each is below the solution, and the error shrinks by half or more in each.
const ITERATIONS: usize = 8;

/// Newton steps for a time. They start above the solution and stay there.
const NEWTON_STEPS: usize = 4;

/// Returns an upper bound of the time s at which s − l (1 − e^(−s/l)) reaches c, s; `lag`: l, s.
fn time_behind_lag(lag: f64, c: f64) -> f64 {
    let mut time = 0.5 * (c + (c * (c + 8.0 * lag)).sqrt());
    if !(lag > 0.0 && time > 0.0 && time.is_finite()) {
        return c;
    }
    for _ in 0..NEWTON_STEPS {
        let rest = -(-time / lag).exp_m1();
        time -= (time - lag * rest - c) / rest;
    }
    time
}

/// Returns the peak force that no controller can avoid that brakes with a, at a speed (m/s), N, in a contact of the stiffness K (N/m), if the contact
/// begins at the worst moment of a period; `acceleration`: a, m/s².
pub fn unavoidable_peak(
    settings: &ContactSettings,
    timing: &ContactTiming,
    (stiffness, acceleration): (f64, f64),
    speed: f64,
) -> f64 {
    if speed <= 0.0 {
        return 0.0;
    }
    let detection = time_behind_lag(timing.sensor_lag, settings.suspicion() / (stiffness * speed));
    let (lag, stop) = (timing.lag, time_behind_lag(timing.lag, speed / acceleration));
    let behind = if lag > 0.0 { -(-stop / lag).exp_m1() * lag * lag } else { 0.0 };
    let reversal = speed * stop - acceleration * (0.5 * stop * stop - lag * stop + behind);
    stiffness * (speed * (detection + timing.dead_time - 0.5 * timing.period) + reversal)
}

/// Returns the largest approach speed, m/s, at which the law keeps the peak below 1.2 F_d in the stiffest contact, and at most the
/// speed of retreat; `target`: F_d, N; `acceleration`: a, m/s².
pub fn largest_approach_speed(
    settings: &ContactSettings,
    timing: &ContactTiming,
    target: f64,
    acceleration: f64,
) -> f64 {
    let (stiffness, force) = (settings.stiffest, PEAK_SHARE * target);
    // Full braking in place of reversal, and a late detection: below the solution.
    let rest = (force - settings.suspicion()).max(0.1 * force);
    let first = acceleration
        * ((timing.reaction * timing.reaction + 2.0 * rest / (stiffness * acceleration)).sqrt() - timing.reaction);
    let peak = |speed: f64| unavoidable_peak(settings, timing, (stiffness, acceleration), speed);
    // The peak grows at most with the square of the speed.
    let next = |speed: f64, _| speed * (force / peak(speed)).sqrt();
    (0..ITERATIONS).fold(first, next).min(settings.retreat_speed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Drive;

    fn timing(period: f64, lag_s: f64, delay_periods: usize) -> ContactTiming {
        ContactTiming::new(period, Drive { lag_s, delay_periods }, 0.002, 0.0)
    }

    #[test]
    fn the_default_approach_speed_uses_the_whole_peak_that_it_may() {
        let settings = ContactSettings::default();
        for (lag_s, delay_periods, period) in [(0.0, 0, 1e-3), (0.01, 1, 2e-3), (0.03, 2, 8e-3)] {
            let timing = timing(period, lag_s, delay_periods);
            for target in [5.0, 30.0, 100.0] {
                let speed = largest_approach_speed(&settings, &timing, target, 5.0);
                let peak = unavoidable_peak(&settings, &timing, (settings.stiffest, 5.0), speed);
                let share = peak / (PEAK_SHARE * target);
                assert!(share <= 1.0 + 1e-9 && share > 0.97, "{target} N: {speed} {peak}");
            }
        }
    }

    /// The table of the design has 16, 6.5 and 1.4 mm/s for 1e6 N/m, found by simulating full reversal at 1.2 × 30 N.
    #[test]
    fn the_unavoidable_peak_is_that_of_full_reversal() {
        let settings = ContactSettings::default();
        for (period, lag_s, delay_periods, speed) in
            [(1e-3, 0.0, 0, 0.016), (1e-3, 0.01, 1, 0.0065), (8e-3, 0.02, 2, 0.0014)]
        {
            let timing = timing(period, lag_s, delay_periods);
            let peak = unavoidable_peak(&settings, &timing, (1e6, 5.0), speed);
            assert!((peak / 36.0 - 1.0).abs() < 0.12, "{peak} N at {speed} m/s");
        }
    }
}
