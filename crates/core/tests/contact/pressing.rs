//! Contacts with walls that rest.

use revprio_core::law::{ContactPhase, ContactSettings};
use revprio_core::limits::Drive;

use crate::grid::{SPEEDS, STIFFNESSES, Summary, measure};
use crate::laws::{Pressing, bound, press};
use crate::plant::{Conditions, Controller, Noise, run};

/// Every stiffness and speed behind four drives: a ninth of the grid.
fn some_cells() -> impl Iterator<Item = Conditions> {
    let drives = [(0.0, 0, 0.001), (0.005, 0, 0.001), (0.01, 1, 0.002), (0.02, 2, 0.008)];
    let cell = move |stiffness: f64, speed: f64| drives.map(|drive| Conditions::new(stiffness, speed, drive));
    let cells = STIFFNESSES.into_iter().flat_map(move |k| SPEEDS.into_iter().flat_map(move |v| cell(k, v)));
    (1..).zip(cells).map(|(seed, cell)| cell.seeded(seed))
}

#[test]
fn walls_of_unknown_stiffness_are_pressed_without_overshoot_and_in_time() {
    let results: Vec<_> = some_cells().map(measure).collect();
    let summary = Summary::of(&results);
    assert_eq!((summary.runs, summary.unsettled, summary.faults, summary.late.0), (84, 0, 0, 0), "{summary:?}");
    assert!(summary.errors.1 <= 0.1 && summary.losses <= 1, "{summary:?}");
    // 99.5 % of the conditions, so none of 84 but one, and never above 1.5.
    assert!(summary.peaks.0 <= 1 && summary.peaks.1 < 1.5, "{summary:?}");
}

#[test]
fn a_drive_that_yields_is_pressed_too() {
    for soft in [(2.0, 400.0), (5.0, 150.0)] {
        let cell = |terms: Conditions| measure(Conditions { soft: Some(soft), ..terms });
        let results: Vec<_> = some_cells().step_by(3).map(cell).collect();
        let summary = Summary::of(&results);
        assert_eq!((summary.unsettled, summary.faults), (0, 0), "{soft:?}: {summary:?}");
        assert!(summary.errors.1 <= 0.1 && summary.peaks.1 < 1.2, "{soft:?}: {summary:?}");
    }
}

#[test]
fn small_and_large_forces_are_pressed() {
    for target in [5.0, 100.0] {
        for stiffness in [1e3, 1e5, 1e6] {
            let terms = Conditions { target, ..Conditions::new(stiffness, 0.03, (0.01, 1, 0.002)) };
            let found = press(&terms);
            assert!(found.settled && found.error.abs() < 0.1, "{target} N on {stiffness}: {found:?}");
            assert!(found.peak < 1.1 * bound(&terms).max(1.2 * target), "{target} N on {stiffness}: {found:?}");
        }
    }
}

/// The force stays little above f_off for long: noise must not lose the contact for long, because the law learns only in contact.
#[test]
fn noise_rarely_delays_a_light_contact() {
    let drives = [(0.0, 0, 0.001), (0.005, 1, 0.001), (0.02, 1, 0.001), (0.005, 1, 0.002)];
    let runs = drives.into_iter().flat_map(|drive| (1..=100).map(move |seed| (drive, seed)));
    let late = runs.filter(|&(drive, seed)| {
        let terms = Conditions { target: 5.0, ..Conditions::new(1e3, 0.01, drive) }.seeded(seed);
        let found = press(&terms);
        assert!(found.settled, "{drive:?} {seed}: {found:?}");
        found.settling > 0.5 + terms.travel()
    });
    let late: Vec<_> = late.collect();
    assert!(late.len() <= 4, "{late:?}");
}

/// The command goes on into the wall, and the tool does not.
#[test]
fn an_impact_that_stops_a_drive_at_its_largest_force_does_not_empty_the_tank() {
    for drive in [(0.02, 2, 0.002), (0.02, 2, 0.008)] {
        for seed in 1..=3 {
            let yielding =
                Conditions { soft: Some((5.1, 400.0)), most_force: 200.0, ..Conditions::new(1e6, 0.1, drive) };
            let found = press(&Conditions { target: 5.0, ..yielding }.seeded(seed));
            assert!(found.settled && found.settling < 0.5, "{drive:?} {seed}: {found:?}");
        }
    }
}

#[test]
fn the_default_approach_speed_keeps_the_peak_below_1_2_times_the_target() {
    for (lag, delay, period) in [(0.0, 0, 0.001), (0.005, 0, 0.001), (0.01, 1, 0.002)] {
        for stiffness in [1e5, 1e6] {
            let told = ContactSettings::default();
            let drive = Drive { lag_s: lag, delay_periods: delay };
            let mut terms = Conditions::new(stiffness, 0.01, (lag, delay, period));
            let mut law = Pressing::told(&terms, drive, told);
            law.command(0.0, [0.0; 2]);
            terms.speed = law.report.unwrap().approach_speed;
            let told = ContactSettings { approach_speed: Some(terms.speed), ..told };
            for seed in 1..4 {
                let terms = terms.seeded(seed);
                let found = run(&terms, &mut Pressing::told(&terms, drive, told), |_| {});
                assert!(found.settled && found.peak <= 1.2 * 30.0, "{stiffness} {lag}: {found:?}");
            }
        }
    }
}

#[test]
fn the_answer_tells_the_peak_that_a_fast_approach_cannot_avoid() {
    for speed in [0.01, 0.1] {
        let terms = Conditions::new(1e6, speed, (0.005, 1, 0.001));
        let mut law = Pressing::new(&terms);
        let found = run(&terms, &mut law, |_| {});
        let told = law.report.unwrap().unavoidable_peak;
        // The contact may begin at a better moment of the period than the worst one: at most K v T less.
        let moment = 1e6 * speed * 0.001;
        assert!(
            found.peak <= 1.1 * told && (told - bound(&terms)).abs() < 1.5 * moment,
            "{told} {} {found:?}",
            bound(&terms)
        );
    }
}

#[test]
fn the_estimated_stiffness_and_the_predicted_force_are_reported() {
    for stiffness in [1e3, 1e4, 1e5] {
        let terms = Conditions::new(stiffness, 0.03, (0.005, 1, 0.001));
        let mut law = Pressing::new(&terms);
        run(&terms, &mut law, |_| {});
        let report = law.report.unwrap();
        let [found, uncertainty] = report.stiffness.unwrap();
        assert!((found - stiffness).abs() < 3.0 * uncertainty, "{stiffness}: {report:?}");
        assert!(uncertainty < 0.34 * found && report.stiffness_bound > stiffness, "{stiffness}: {report:?}");
        assert!((report.predicted_force - 30.0).abs() < 1.5, "{stiffness}: {report:?}");
        assert_eq!(report.phase, ContactPhase::Contact);
    }
}

/// The tool sinks 20 mm at 1 cm/s: within the window of the means, the force changes by no more than the noise hides.
#[test]
fn a_slow_touch_makes_the_stiffness_of_a_soft_wall_known() {
    for stiffness in [1e3, 2e3] {
        for seed in 1..=10 {
            let terms = Conditions { target: 20.0, ..Conditions::new(stiffness, 0.01, (0.01, 1, 0.002)).seeded(seed) };
            let mut law = Pressing::new(&terms);
            run(&terms, &mut law, |_| {});
            let report = law.report.unwrap();
            let [found, uncertainty] = report.stiffness.unwrap();
            assert!((found - stiffness).abs() < 3.0 * uncertainty, "{stiffness}: {report:?}");
            assert!(report.stiffness_bound < 3.0 * stiffness, "{stiffness}: {report:?}");
        }
    }
}

/// One sample in 3.5 million exceeds 5 σ, and one in 740 exceeds 3 σ.
#[test]
fn noise_alone_does_not_slow_the_approach() {
    let terms = Conditions::new(1e5, 0.03, (0.005, 1, 0.001));
    let (mut law, mut noise) = (Pressing::new(&terms), Noise::new(7));
    let (mut way, mut contacts) = (0.0, 0);
    for _ in 0..200_000 {
        let before = law.axis().phase;
        way += 0.001 * law.command(0.2 * noise.normal(), [way, 0.0]);
        contacts += usize::from(before == ContactPhase::Approach && law.axis().phase == ContactPhase::Contact);
    }
    assert!(way > 0.995 * 0.03 * 200.0 && contacts <= 1, "{way} m, {contacts} contacts");
}

/// The noise is stated larger than it is, so a force between suspicion and contact stays there.
#[test]
fn a_sensor_without_noise_finds_the_wall_too() {
    for stiffness in [1e3, 1e4, 1e5] {
        for speed in [0.002, 0.01] {
            let terms = Conditions { noise: 0.0, hold: 2.5, ..Conditions::new(stiffness, speed, (0.0, 0, 0.001)) };
            let told = ContactSettings { approach_speed: Some(speed), ..ContactSettings::default() };
            let found = run(&terms, &mut Pressing::told(&terms, Drive::IDEAL, told), |_| {});
            assert!(found.settled && found.error.abs() < 0.1, "{stiffness} {speed}: {found:?}");
        }
    }
}

/// A bias between suspicion and contact does not hold the tool either: it presses with the bias less.
#[test]
fn a_bias_that_looks_like_a_touch_does_not_stop_the_approach() {
    for bias in [0.8, 3.0] {
        for stiffness in [1e3, 1e4, 1e5] {
            let terms = Conditions { bias, hold: 4.0, ..Conditions::new(stiffness, 0.01, (0.0, 0, 0.001)) };
            let found = press(&terms);
            assert!((found.error + bias).abs() < 0.1 && found.rms < 0.5, "{bias} {stiffness}: {found:?}");
        }
    }
}

/// On stiffer walls the law crosses the play slowly: at 1e6 N/m, 2 N move the tool by 0.07 mm/s.
#[test]
fn a_drive_with_a_backlash_of_0_2_mm_presses_too() {
    for stiffness in [1e3, 1e4, 1e5] {
        for drive in [(0.0, 0, 0.001), (0.01, 1, 0.002)] {
            let terms = Conditions { backlash: 2e-4, ..Conditions::new(stiffness, 0.01, drive) };
            let found = press(&terms);
            assert!(found.settled && found.error.abs() < 0.1, "{stiffness} {drive:?}: {found:?}");
            assert!(found.peak < 1.1 * bound(&terms).max(36.0), "{stiffness} {drive:?}: {found:?}");
        }
    }
}

/// The defaults of a rotation are those of a translation at a lever of 0.1 m.
#[test]
fn an_axis_of_rotation_presses_as_a_translation_at_its_lever() {
    let drive = Drive { lag_s: 0.01, delay_periods: 1 };
    for stiffness in [1e3, 1e4, 1e5] {
        let linear = Conditions::new(stiffness, 0.01, (0.01, 1, 0.002));
        let angular = Conditions {
            stiffness: 0.01 * linear.stiffness,
            speed: 10.0 * linear.speed,
            acceleration: 10.0 * linear.acceleration,
            noise: 0.1 * linear.noise,
            target: 0.1 * linear.target,
            ..linear
        };
        let run_with = |terms: &Conditions, told: ContactSettings, unit: f64| {
            let told = ContactSettings { approach_speed: Some(terms.speed), ..told };
            let mut forces = Vec::new();
            run(terms, &mut Pressing::told(terms, drive, told), |[_, force, ..]| forces.push(unit * force));
            forces
        };
        let forces = run_with(&linear, ContactSettings::LINEAR, 1.0);
        let torques = run_with(&angular, ContactSettings::ANGULAR, 10.0);
        // The damping of the simulated wall does not scale, so the impact differs a little; the force that is held does not.
        let pairs = forces.iter().zip(&torques).rev().take(200);
        let worst = pairs.map(|(force, torque)| (force - torque).abs()).fold(0.0, f64::max);
        assert!(worst < 0.2 && (torques.last().unwrap() - 30.0).abs() < 0.2, "{stiffness}: {worst}");
    }
}

#[test]
fn a_lag_that_is_understated_by_half_is_settled() {
    for stiffness in [1e3, 1e4, 1e5, 1e6] {
        for lag in [0.005, 0.01, 0.02] {
            let terms = Conditions::new(stiffness, 0.03, (lag, 1, 0.002));
            let told = ContactSettings { approach_speed: Some(0.03), ..ContactSettings::default() };
            let mut law = Pressing::told(&terms, Drive { lag_s: 0.5 * lag, delay_periods: 1 }, told);
            let found = run(&terms, &mut law, |_| {});
            assert!(found.settled, "{stiffness} {lag}: {found:?}");
        }
    }
}
