//! The bound of the guide: an error of the chord and one of the force turn the normal by no more than δ (1 + μ) + asin(e/N).

use nalgebra::{Unit, Vector3};
use proptest::prelude::*;
use revprio_core::surface::{NormalEstimate, NormalReport, SlidingInput, SurfaceSettings, Touch};

/// Largest angle from the stated axis, rad.
const MAX_TILT: f64 = 1.0;

fn input(position: Vector3<f64>, force: Vector3<f64>) -> SlidingInput {
    SlidingInput {
        stated: -Vector3::z(),
        position,
        force,
        touch: Touch::Touches,
        stiffness: 1e5,
        softest: 1e5,
        time: 0.002,
    }
}

/// A slide along a direction at 5 cm/s with a constant force; returns the last report.
fn slide(chord: &Vector3<f64>, force: &Vector3<f64>) -> (NormalEstimate, NormalReport) {
    let (mut estimate, settings) = (NormalEstimate::START, SurfaceSettings { max_tilt: MAX_TILT });
    let reports = (0..1000).map(|period| {
        let position = chord * (1e-4 * f64::from(period));
        estimate.update(settings, &input(position, *force))
    });
    let last = reports.last().unwrap();
    (estimate, last)
}

/// A unit vector at an angle from another one, in a direction about it.
fn aside(of: &Vector3<f64>, angle: f64, about: f64) -> Vector3<f64> {
    let across = of.cross(&Vector3::new(0.6, 0.8, 0.1)).normalize();
    let across = nalgebra::Rotation3::from_axis_angle(&Unit::new_normalize(*of), about) * across;
    (of * angle.cos() + across * angle.sin()).normalize()
}

fn angle() -> impl Strategy<Value = f64> {
    0.0..std::f64::consts::TAU
}

proptest! {
    #[test]
    fn the_normal_is_exact_for_every_friction(
        tilt in 0.0..0.8_f64, about in angle(), course in angle(), friction in 0.0..0.9_f64,
    ) {
        let normal = aside(&-Vector3::z(), tilt, about);
        let along = aside(&normal, std::f64::consts::FRAC_PI_2, course);
        let (_, report) = slide(&along, &(20.0 * (normal + friction * along)));
        prop_assert!(report.normal.angle(&normal) < 1e-6, "{report:?}");
        prop_assert!((report.friction.unwrap() - friction).abs() < 1e-6, "{report:?}");
        prop_assert!(report.deviation.unwrap() < 0.05 && !report.is_limited, "{report:?}");
    }

    #[test]
    fn errors_of_the_chord_and_of_the_force_turn_the_normal_by_their_angles(
        tilt in 0.0..0.6_f64, about in angle(), course in angle(), friction in 0.0..0.5_f64,
        (chord_error, chord_about) in (0.0..0.1_f64, angle()),
        (force_error, force_tilt, force_about) in (0.0..2.0_f64, 0.0..3.0_f64, angle()),
    ) {
        let normal = aside(&-Vector3::z(), tilt, about);
        let along = aside(&normal, std::f64::consts::FRAC_PI_2, course);
        let error = force_error * aside(&normal, force_tilt, force_about);
        let (_, report) = slide(&aside(&along, chord_error, chord_about), &(20.0 * (normal + friction * along) + error));
        let bound = chord_error * (1.0 + friction) + (force_error / 20.0).asin();
        prop_assert!(report.normal.angle(&normal) < 1.02 * bound + 1e-6, "{bound} {report:?}");
    }

    /// Whatever it is told, the normal is a unit vector within the largest tilt, and turns no faster than it may.
    #[test]
    fn the_normal_is_bounded_for_any_input(
        steps in prop::collection::vec((prop::array::uniform3(-1e3..1e3_f64), prop::array::uniform3(-1e15..1e15_f64), 0..4_u8), 1..60),
    ) {
        let (mut estimate, settings) = (NormalEstimate::START, SurfaceSettings { max_tilt: MAX_TILT });
        let mut last = -Vector3::z();
        for (position, force, touch) in steps {
            let touch = match touch {
                0 => Touch::Free,
                1 => Touch::Left,
                _ => Touch::Touches,
            };
            let report = estimate.update(settings, &SlidingInput { touch, ..input(position.into(), force.into()) });
            prop_assert!((report.normal.norm() - 1.0).abs() < 1e-9);
            prop_assert!(report.normal.angle(&-Vector3::z()) < MAX_TILT + 1e-7);
            prop_assert!(report.normal.angle(&last) < 2.0 * 0.002 + 1e-7);
            last = report.normal;
        }
    }
}

/// A press moves the tool, but not along the surface.
#[test]
fn a_press_teaches_nothing() {
    let (mut estimate, settings) = (NormalEstimate::START, SurfaceSettings::default());
    for period in 0..1000 {
        let depth = 1e-5 * f64::from(period);
        let mut pressed = input(-Vector3::z() * depth, -Vector3::z() * (1e3 * depth));
        // The stiffness is not known well.
        (pressed.stiffness, pressed.softest) = (1.3e3, 300.0);
        let report = estimate.update(settings, &pressed);
        assert_eq!(report.friction, None, "{period}");
    }
}

/// Forces of a tool that turns back cancel out along the chord.
#[test]
fn a_tool_that_turns_back_keeps_its_normal() {
    let normal = aside(&-Vector3::z(), 0.4, 1.0);
    let along = aside(&normal, std::f64::consts::FRAC_PI_2, 2.0);
    let (mut estimate, settings) = (NormalEstimate::START, SurfaceSettings::default());
    for period in 0..4000 {
        let phase = f64::from(period) * 0.01;
        let force = 20.0 * (normal + 0.5 * phase.cos().signum() * along);
        let report = estimate.update(settings, &input(along * (0.01 * phase.sin()), force));
        if period > 500 {
            assert!(report.normal.angle(&normal) < 1e-3, "{period}: {report:?}");
        }
    }
}

/// A memory that a client has changed turns no pressing direction beyond the largest tilt.
#[test]
fn a_changed_memory_stays_within_the_largest_tilt() {
    let stated = -Vector3::z();
    for normal in [Vector3::z(), Vector3::x(), Vector3::new(0.6, 0.0, -0.8)] {
        let estimate = NormalEstimate { normal, ..NormalEstimate::START }.within(&stated, 0.5);
        assert!(estimate.normal.angle(&stated) <= 0.5 + 1e-9 && estimate.is_valid(), "{normal}");
    }
    for wrong in [
        NormalEstimate { mean: 5.0 * Vector3::z(), ..NormalEstimate::START },
        NormalEstimate { friction: 1.5, ..NormalEstimate::START },
        NormalEstimate { variance: 1e9, ..NormalEstimate::START },
        NormalEstimate { chords: f64::NAN, ..NormalEstimate::START },
    ] {
        assert!(!wrong.is_valid(), "{wrong:?}");
    }
}
