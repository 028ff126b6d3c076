//! Payload and bias from the readings of a wrist sensor.

use nalgebra::{Rotation3, Vector3};
use revprio_core::payload::{GRAVITY, Payload, PayloadError, PayloadReading, identify};

/// rms of a reading, N and N·m.
const NOISE: [f64; 2] = [0.2, 0.02];

/// A small generator of numbers with a normal distribution.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / 9_007_199_254_740_992.0
    }

    fn normal(&mut self) -> f64 {
        let (u, v) = (self.uniform() + 1e-300, self.uniform());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).sin()
    }

    fn vector(&mut self, rms: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| rms * self.normal())
    }
}

/// The truth of the tests.
struct Truth {
    mass: f64,
    center: Vector3<f64>,
    force_bias: Vector3<f64>,
    torque_bias: Vector3<f64>,
}

const TRUTH: Truth = Truth {
    mass: 1.2,
    center: Vector3::new(0.01, -0.02, 0.08),
    force_bias: Vector3::new(3.0, -2.0, 5.0),
    torque_bias: Vector3::new(0.1, -0.05, 0.08),
};

/// Gravity along each axis in both directions.
fn six() -> Vec<Vector3<f64>> {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    axes.into_iter().flat_map(|axis| [axis, -axis]).collect()
}

/// Gravity tilted from the axis z by an angle, rad, in six directions.
fn tilted(angle: f64) -> Vec<Vector3<f64>> {
    let turn = |i: u32| Rotation3::from_axis_angle(&Vector3::z_axis(), f64::from(i) * std::f64::consts::TAU / 6.0);
    (0..6).map(|i| turn(i) * Vector3::new(angle.sin(), 0.0, angle.cos())).collect()
}

fn readings(directions: &[Vector3<f64>], sign: f64, random: &mut Random) -> Vec<PayloadReading> {
    let reading = |gravity: &Vector3<f64>| {
        let weight = GRAVITY * TRUTH.mass * gravity;
        PayloadReading {
            gravity: *gravity,
            force: sign * (TRUTH.force_bias + weight) + random.vector(NOISE[0]),
            torque: sign * (TRUTH.torque_bias + TRUTH.center.cross(&weight)) + random.vector(NOISE[1]),
        }
    };
    directions.iter().map(reading).collect()
}

fn found(directions: &[Vector3<f64>], random: &mut Random) -> Payload {
    identify(&readings(directions, 1.0, random), NOISE).unwrap()
}

#[test]
fn six_postures_tell_mass_centre_and_bias_within_their_uncertainties() {
    let (mut random, mut squares) = (Random(88_172_645_463_325_252), [0.0; 2]);
    for _ in 0..300 {
        let payload = found(&six(), &mut random);
        let centre = (payload.center_of_mass - TRUTH.center).norm() / 3.0_f64.sqrt();
        squares[0] += ((payload.mass - TRUTH.mass) / payload.mass_uncertainty).powi(2) / 300.0;
        squares[1] += (centre / payload.center_uncertainty).powi(2) / 300.0;
        // Single samples: 8 g and 1.6 mm in the table of docs/contact.md.
        assert!((payload.mass - TRUTH.mass).abs() < 0.05 && centre < 0.006, "{payload:?}");
        assert!((payload.force_bias - TRUTH.force_bias).norm() < 0.7, "{payload:?}");
    }
    assert!(squares.iter().all(|square| (0.8..1.25).contains(square)), "{squares:?}");
}

#[test]
fn a_wrong_sign_is_found_every_time_and_never_without_reason() {
    let mut random = Random(362_436_069);
    for _ in 0..1000 {
        let wrong = identify(&readings(&six(), -1.0, &mut random), NOISE);
        assert!(matches!(wrong, Err(PayloadError::WrongSign { .. })), "{wrong:?}");
        found(&six(), &mut random);
    }
}

#[test]
fn swapped_axes_are_found_every_time() {
    let mut random = Random(521_288_629);
    for _ in 0..1000 {
        let mut swapped = readings(&six(), 1.0, &mut random);
        for reading in &mut swapped {
            reading.force.swap_rows(0, 1);
            reading.torque.swap_rows(0, 1);
        }
        let refused = identify(&swapped, NOISE);
        assert!(matches!(refused, Err(PayloadError::Residual { .. })), "{refused:?}");
    }
}

#[test]
fn similar_postures_are_refused_with_the_posture_to_add() {
    let mut random = Random(88_675_123);
    for angle in [0.35, 0.8] {
        assert!(identify(&readings(&tilted(angle), 1.0, &mut random), NOISE).is_ok());
    }
    let mut directions = tilted(0.1);
    let mut added = 0;
    while let Err(refused) = identify(&readings(&directions, 1.0, &mut random), NOISE) {
        let PayloadError::Similar { add, condition } = refused else { panic!("{refused:?}") };
        assert!(condition > 8.0 && added < 2, "{refused:?}");
        directions.push(add.into());
        added += 1;
    }
    assert!(added > 0);
}

#[test]
fn a_sensor_without_payload_has_a_bias_only() {
    let mut random = Random(5);
    let empty = six().into_iter().map(|gravity| PayloadReading {
        gravity,
        force: TRUTH.force_bias + random.vector(NOISE[0]),
        torque: TRUTH.torque_bias + random.vector(NOISE[1]),
    });
    let payload = identify(&empty.collect::<Vec<_>>(), NOISE).unwrap();
    assert!(payload.mass < 0.05 && payload.center_of_mass == Vector3::zeros(), "{payload:?}");
    let broken = PayloadReading { gravity: Vector3::z() * 2.0, force: Vector3::zeros(), torque: Vector3::zeros() };
    assert_eq!(identify(&[broken; 6], NOISE), Err(PayloadError::NotFinite { reading: 0 }));
}
