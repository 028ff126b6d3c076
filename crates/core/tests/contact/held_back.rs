//! Arms that do not do what they are told: brakes, stops of the drives, sliders of the robot's speed.

use revprio_core::law::{ContactPhase, ContactSettings, FaultCause};
use revprio_core::limits::Drive;

use crate::laws::{Pressing, press, time_near_target};
use crate::plant::{Conditions, Event, run};

const DRIVES: [(f64, usize, f64); 3] = [(0.0, 0, 0.001), (0.01, 1, 0.002), (0.02, 2, 0.008)];

/// Returns conditions in which the arm is held back from a force on, N, for a time, s.
fn stopped(terms: Conditions, from: f64, time: f64, share: f64) -> Conditions {
    let mut first = f64::INFINITY;
    run(&terms, &mut Pressing::new(&terms), |[now, force, ..]| {
        first = if force > from { first.min(now) } else { first };
    });
    Conditions { event: Event::HeldBack(first, time, share), ..terms }
}

/// Motion that the tool did not make is no softness of the surface: the contact settles after a stop, and does not hammer. A stop that ends before it
/// is noticed leaves an impact.
#[test]
fn a_contact_settles_after_a_stop_of_the_arm() {
    for (stiffness, target) in [(1e3, 30.0), (1e4, 30.0), (1e5, 30.0), (1e6, 30.0), (1e5, 100.0), (3e5, 60.0)] {
        for (drive, time) in DRIVES.into_iter().flat_map(|drive| [0.1, 0.5, 3.0].map(|time| (drive, time))) {
            for (speed, share) in [(0.02, 0.0), (0.01, 0.0), (0.02, 0.2)] {
                let terms = Conditions { target, hold: 6.0, ..Conditions::new(stiffness, speed, drive) };
                let terms = stopped(terms, 0.5 * target, time, share);
                let mut after = 0.0_f64;
                let outcome = run(&terms, &mut Pressing::new(&terms), |[now, force, ..]| {
                    let Event::HeldBack(from, lasts, _) = terms.event else { unreachable!() };
                    after = if now > from + lasts + 1.5 { after.max(force) } else { after };
                });
                let quiet = press(&Conditions { event: Event::None, ..terms }).peak;
                let told = format!("{stiffness} {target} {drive:?} {time} {speed} {share}: {outcome:?}");
                assert!(outcome.settled && !outcome.fault && after < 1.3 * target.max(quiet), "{told} {after}");
                assert!(outcome.peak_after < (3.5 * target).max(1.4 * quiet), "{told} {quiet}");
            }
        }
    }
}

/// A retreat that a stop holds up goes on afterwards, and leaves the surface.
#[test]
fn a_retreat_goes_on_after_a_stop_of_the_arm() {
    for (stiffness, share) in
        [1e3, 1e4, 1e5, 1e6].into_iter().flat_map(|stiffness| [(stiffness, 0.0), (stiffness, 0.2)])
    {
        for drive in DRIVES {
            let terms = Conditions { hold: 4.0, ..Conditions::new(stiffness, 0.02, drive) };
            let terms = stopped(terms, 19.9, 3.0, share);
            let Event::HeldBack(from, ..) = terms.event else { unreachable!() };
            let settings = ContactSettings {
                approach_speed: Some(0.02),
                noise: 0.2,
                sensor_lag: terms.sensor_lag,
                max_force: 20.0,
                ..ContactSettings::default()
            };
            let told = Drive { lag_s: terms.lag, delay_periods: terms.delay };
            let mut law = Pressing::told(&terms, told, settings);
            let (mut held, mut end) = (0.0, 0.0);
            run(&terms, &mut law, |[time, force, ..]| {
                held = if time < from + 2.9 { force } else { held };
                end = force;
            });
            let phase = law.axis().phase;
            assert_eq!(phase, ContactPhase::Fault(FaultCause::ForceLimit), "{stiffness} {share} {drive:?}");
            assert!(end < 1.0 && (share > 0.0 || held > 15.0), "{stiffness} {share} {drive:?}: {held} N, then {end} N");
        }
    }
}

/// A long stop with a force that rises and falls is no force that stays in a retreat.
#[test]
fn a_stop_while_the_target_falls_is_no_fault() {
    for drive in DRIVES {
        let terms = Conditions { hold: 8.0, ..Conditions::new(1e5, 0.02, drive) };
        let from = time_near_target(&terms) + 0.5;
        let terms = Conditions { event: Event::HeldBack(from, 2.0, 0.0), target: 40.0, ..terms };
        let mut law = Pressing::new(&terms);
        law.later = Some((from + 0.1, 20.0));
        let mut end = 0.0;
        run(&terms, &mut law, |[_, force, ..]| end = force);
        assert!(
            !matches!(law.axis().phase, ContactPhase::Fault(_)) && (end - 20.0_f64).abs() < 1.0,
            "{drive:?}: {end} N"
        );
    }
}
