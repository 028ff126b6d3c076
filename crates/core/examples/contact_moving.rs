//! Prints how the contact law follows walls that leave and return, that come, that swing, and that swing under random conditions, and what it
//! does with contacts whose stiffness changes.
//!
//! `cargo run --release -p revprio-core --example contact_moving`

#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/contact/laws.rs"]
mod laws;
#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/contact/plant.rs"]
mod plant;

use laws::{Pressing, time_near_target};
use plant::{Conditions, Event, Noise, SWINGS, run};
use revprio_core::law::ContactSettings;
use revprio_core::limits::Drive;

fn main() {
    println!(
        "| K, N/m | wall, cm/s | away: mean, least N | back: mean, most N | losses | settled |\n|---|---|---|---|---|---|"
    );
    for stiffness in [1e3, 3e3, 1e4, 3e4, 1e5] {
        for speed in [0.01, 0.02, 0.05] {
            let terms = Conditions::new(stiffness, 0.03, (0.005, 1, 0.002));
            let start = 1.2 + 1.5 * terms.travel();
            let terms = Conditions { event: Event::LeaveAndReturn(start, speed, 1.5), ..terms };
            let (mut away, mut back) = (Vec::new(), Vec::new());
            let found = run(&terms, &mut Pressing::new(&terms), |[time, force, ..]| {
                let since = time - start;
                if (0.5..1.5).contains(&since) {
                    away.push(force);
                } else if (2.0..3.0).contains(&since) {
                    back.push(force);
                }
            });
            let mean = |forces: &[f64]| forces.iter().sum::<f64>() / forces.len() as f64;
            let least = away.iter().copied().fold(f64::INFINITY, f64::min);
            let most = back.iter().copied().fold(0.0, f64::max);
            println!(
                "| {stiffness:.0e} | {} | {:.1}, {least:.1} | {:.1}, {most:.1} | {} | {} |",
                100.0 * speed,
                mean(&away),
                mean(&back),
                found.losses,
                found.settled
            );
        }
    }
    coming();
    swings();
    random_swings();
    random_changes();
}

/// Prints what walls do that come for a second, from when the force is near its target on.
fn coming() {
    println!("\n| K, N/m | wall, cm/s | most N | stiffness afterwards, N/m | losses |\n|---|---|---|---|---|");
    for stiffness in [1e3, 1e4, 3e4, 1e5] {
        for speed in [0.01, 0.02] {
            let terms = Conditions::new(stiffness, 0.02, (0.005, 1, 0.002));
            let terms = Conditions { event: Event::LeaveAndReturn(time_near_target(&terms), -speed, 1.0), ..terms };
            let (mut law, mut most) = (Pressing::new(&terms), 0.0_f64);
            let found = run(&terms, &mut law, |[_, force, ..]| most = most.max(force));
            let slope = law.axis().estimate.slope;
            println!("| {stiffness:.0e} | {} | {most:.1} | {slope:.1e} | {} |", 100.0 * speed, found.losses);
        }
    }
}

/// Prints how it follows walls that swing.
fn swings() {
    println!("\n| K, N/m | Hz | amplitude, mm | mean, least, most N | losses | settled |\n|---|---|---|---|---|---|");
    for stiffness in [1e3, 1e4, 3e4, 1e5] {
        for (frequency, amplitude) in
            [(0.2, 0.001), (0.2, 0.005), (0.5, 0.002), (1.0, 0.001), (1.0, 0.003), (2.0, 0.002)]
        {
            let terms = Conditions { hold: 3.0, ..Conditions::new(stiffness, 0.03, (0.005, 1, 0.002)) };
            let start = 1.2 + 1.5 * terms.travel();
            let terms = Conditions { event: Event::Swing(start, amplitude, frequency), ..terms };
            let mut forces = Vec::new();
            let found = run(&terms, &mut Pressing::new(&terms), |[time, force, ..]| {
                if (1.0..SWINGS).contains(&(time - start)) {
                    forces.push(force);
                }
            });
            let mean = forces.iter().sum::<f64>() / forces.len() as f64;
            let least = forces.iter().copied().fold(f64::INFINITY, f64::min);
            let most = forces.iter().copied().fold(0.0, f64::max);
            println!(
                "| {stiffness:.0e} | {frequency} | {} | {mean:.1}, {least:.1}, {most:.1} | {} | {} |",
                1e3 * amplitude,
                found.losses,
                found.settled
            );
        }
    }
}

/// What a random wall that swings has shown.
struct Swung {
    /// K a τ_d²/F_d: the force that the acceleration of the wall costs within the reaction time.
    difficulty: f64,
    /// Largest error of the force while the wall swings, and from a second after it has stopped on, over F_d.
    errors: [f64; 2],
    losses: usize,
}

/// Returns the whole part of a share of a number.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a share is positive, and the number small"
)]
fn below(share: f64, number: usize) -> usize {
    (share * number as f64) as usize
}

/// Swings a random wall on a random drive, whose lag is stated right, too small, or too large.
fn random_swing(random: &mut Noise) -> Swung {
    let mut one_of = |values: &[f64]| values[below(random.uniform(), values.len())];
    let (target, lag) = (one_of(&[5.0, 10.0, 30.0, 100.0]), one_of(&[0.0, 0.005, 0.01, 0.02]));
    let (delay, period) = (one_of(&[0.0, 1.0, 2.0]), one_of(&[0.001, 0.002, 0.008]));
    let (stated, bandwidth) = (one_of(&[0.5, 1.0, 1.0, 1.0, 1.5]), one_of(&[0.0, 0.0, 150.0, 400.0]));
    let soft = (bandwidth > 0.0).then_some((if bandwidth < 200.0 { 5.0 } else { 2.0 }, bandwidth));
    let (stiffness, frequency) = (random.between(1e3, 1e6), random.between(0.2, 4.0));
    let angular = std::f64::consts::TAU * frequency;
    let amplitude = random.between(1e-4, 5e-3).min(0.05 / angular);
    let terms =
        Conditions { hold: 3.0, target, soft, ..Conditions::new(stiffness, 0.01, (lag, below(delay, 1), period)) };
    let start = 1.2 + 1.5 * terms.travel();
    let terms = Conditions { event: Event::Swing(start, amplitude, frequency), ..terms };
    let settings =
        ContactSettings { approach_speed: Some(terms.speed), noise: terms.noise, ..ContactSettings::default() };
    let mut law = Pressing::told(&terms, Drive { lag_s: stated * lag, delay_periods: terms.delay }, settings);
    let mut errors = [0.0_f64; 2];
    let found = run(&terms, &mut law, |[time, force, ..]| {
        let error = (force / target - 1.0).abs();
        if (1.0..SWINGS).contains(&(time - start)) {
            errors[0] = errors[0].max(error);
        } else if time > start + SWINGS + 1.0 {
            errors[1] = errors[1].max(error);
        }
    });
    let reaction = lag + (delay + 1.0) * period + terms.sensor_lag;
    let difficulty = stiffness * amplitude * (angular * reaction).powi(2) / target;
    Swung { difficulty, errors, losses: found.losses }
}

/// Prints how it follows random walls that swing.
fn random_swings() {
    println!(
        "\n| K a τ_d²/F_d | walls | error: median, 90 %, worst, % | with losses | off by 15 % at rest |\n|---|---|---|---|---|"
    );
    let mut random = Noise::new(1);
    let swung: Vec<_> = (0..600).map(|_| random_swing(&mut random)).collect();
    for (least, most) in [(0.0, 0.003), (0.003, 0.01), (0.01, 0.03), (0.03, 0.1), (0.1, 1.0), (1.0, f64::INFINITY)] {
        let those: Vec<_> = swung.iter().filter(|swung| (least..most).contains(&swung.difficulty)).collect();
        let mut errors: Vec<_> = those.iter().map(|swung| 100.0 * swung.errors[0]).collect();
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors[below(share, errors.len() - 1)];
        let (lost, off) = (|swung: &&&Swung| swung.losses > 0, |swung: &&&Swung| swung.errors[1] > 0.15);
        println!(
            "| {least} … {most} | {} | {:.0}, {:.0}, {:.0} | {} | {} |",
            those.len(),
            at(0.5),
            at(0.9),
            at(1.0),
            those.iter().filter(lost).count(),
            those.iter().filter(off).count()
        );
    }
}

/// Returns a drive at random: L, D and T, and the mass and the bandwidth of one that yields.
fn random_drive(random: &mut Noise) -> ((f64, usize, f64), Option<(f64, f64)>) {
    let mut one_of = |values: &[f64]| values[below(random.uniform(), values.len())];
    let drive = (one_of(&[0.0, 0.005, 0.01, 0.02]), below(one_of(&[0.0, 1.0, 2.0]), 1), one_of(&[0.001, 0.002, 0.008]));
    let bandwidth = one_of(&[0.0, 0.0, 150.0, 400.0]);
    (drive, (bandwidth > 0.0).then_some((if bandwidth < 200.0 { 5.0 } else { 2.0 }, bandwidth)))
}

/// What a contact has shown whose stiffness has changed: the largest force over the target of its time, and the error over the target at the
/// end.
struct Changed {
    peak: f64,
    error: f64,
    losses: usize,
}

/// Changes the stiffness of a random contact that is held, by a factor, and the target 1.5 s later by another one.
fn random_change(random: &mut Noise, [factor, later]: [f64; 2], seed: u64) -> Changed {
    let (drive, soft) = random_drive(random);
    let target = [5.0, 10.0, 30.0, 100.0][below(random.uniform(), 4)];
    let stiffness = random.between(1e3, 1e5);
    let terms = Conditions { hold: 6.0, target, soft, seed, ..Conditions::new(stiffness, 0.01, drive) };
    let start = 1.5 + 1.5 * terms.travel();
    let terms = Conditions { event: Event::Slope(start, factor), ..terms };
    let mut law = Pressing::new(&terms);
    law.later = Some((start + 1.5, later * target));
    let (mut peak, mut error) = (0.0_f64, 0.0_f64);
    let found = run(&terms, &mut law, |[time, force, ..]| {
        let now = if time < start + 1.5 { target } else { later * target };
        if time > start {
            peak = peak.max(force / now);
        }
        if time > start + 5.0 {
            error = error.max((force / now - 1.0).abs());
        }
    });
    Changed { peak, error, losses: found.losses }
}

/// Prints how it presses on contacts whose stiffness changes while they are held.
fn random_changes() {
    println!(
        "\n| stiffness | target then | runs | peak over target: median, 95 %, worst | above 1.5 | off by 15 % at the end | with losses |\n|---|---|---|---|---|---|---|"
    );
    let mut random = Noise::new(2);
    for [factor, later] in [[10.0, 1.0], [0.1, 1.0], [10.0, 2.0]] {
        let changed: Vec<_> = (0..200).map(|seed| random_change(&mut random, [factor, later], seed)).collect();
        let mut peaks: Vec<_> = changed.iter().map(|changed| changed.peak).collect();
        peaks.sort_by(f64::total_cmp);
        let count = |is: fn(&Changed) -> bool| changed.iter().filter(|changed| is(changed)).count();
        println!(
            "| × {factor} | × {later} | {} | {:.2}, {:.2}, {:.2} | {} | {} | {} |",
            changed.len(),
            peaks[100],
            peaks[190],
            peaks[199],
            count(|changed| changed.peak > 1.5),
            count(|changed| changed.error > 0.15),
            count(|changed| changed.losses > 0)
        );
    }
}
