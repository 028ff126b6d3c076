//! Payload and bias of a wrist sensor, from its readings in several postures.
//!
//! At rest the sensor measures f = f_b + m g and t = t_b + (m c) × g, with the gravity g along its own axes. The mass m, its first
//! moment m c and the biases are ten unknowns, which least squares finds. [`AxisAssignment`] tells a wrong sign and exchanged axes: the weight of
//! the tool has a known direction.

mod axes;
mod reading;

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use self::axes::AxesCheck;
pub use self::axes::{AXES_EVIDENCE, AxisAssignment};
pub use self::reading::PayloadReading;

/// Smallest number of postures.
pub const MIN_POSTURES: usize = 6;

/// Largest condition of good postures: six that are tilted by 8° have it.
const MAX_CONDITION: f64 = 8.0;

/// Uncertainties by which the mass must differ from zero to have a sign.
const SIGMAS: f64 = 5.0;

/// Allowed magnitudes of gravity, m/s²: the Moon has 1.6.
const GRAVITY_RANGE: std::ops::RangeInclusive<f64> = 1.5..=30.0;

/// Relative difference of the magnitudes of gravity in two readings. It covers rounded directions.
const GRAVITY_TOLERANCE: f64 = 2e-3;

/// Residual over the noise above which the readings are not those of a payload.
const MAX_RESIDUAL: f64 = 3.0;

/// Largest distance of a centre of mass from its sensor, m. Torques in N·mm give a thousand times the true one.
const FARTHEST_CENTER: f64 = 2.0;

/// Payload and bias.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Payload {
    /// m, kg.
    pub mass: f64,
    /// c, centre of mass from the sensor, m; zero without mass.
    pub center_of_mass: Vector3<f64>,
    /// f_b, N.
    pub force_bias: Vector3<f64>,
    /// t_b, N·m.
    pub torque_bias: Vector3<f64>,
    /// Uncertainty of the mass, rms, kg.
    pub mass_uncertainty: f64,
    /// Uncertainty of the centre of mass, rms, m; infinite without mass.
    pub center_uncertainty: f64,
    /// Residual of the forces, rms, N.
    pub force_residual: f64,
    /// Residual of the torques, rms, N·m.
    pub torque_residual: f64,
    /// How similar the postures are: 1 at best; large if gravity has similar directions in all of them.
    pub condition: f64,
    /// Whether the readings rule out every other assignment of the axes.
    pub axes_verified: bool,
}

/// Why a payload is not found.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PayloadError {
    /// There are too few readings.
    #[error("{0} readings; give at least six, with gravity along each axis of the sensor in both directions")]
    Few(usize),
    /// The noise is not positive.
    #[error("the noise must be a positive number, of the force in N and of the torque in N·m")]
    Noise,
    /// A number is not finite, or gravity is none or differs between readings.
    #[error(
        "the numbers must be finite, and gravity an acceleration of 1.5 to 30 m/s², not in g, the same in all readings"
    )]
    NotFinite {
        /// Index of the reading, from 0.
        reading: usize,
    },
    /// The postures are too similar.
    #[error(
        "gravity has similar directions in all readings (condition {condition:.0}); add a posture with gravity along \
         [{:.2}, {:.2}, {:.2}] of the sensor", add[0], add[1], add[2]
    )]
    Similar {
        /// Condition of the postures.
        condition: f64,
        /// Direction of gravity along the axes of the sensor that the readings lack most.
        add: [f64; 3],
    },
    /// The readings fit better to other axes.
    #[error("{0}")]
    Axes(AxisAssignment),
    /// The readings are not those of a mass.
    #[error(
        "the forces differ from those of a mass by {residual:.2} N rms, at a noise of {noise:.2} N: the pose of the sensor or \
         `wrench_frame` is wrong, something touches the tool, or the arm moved"
    )]
    Residual {
        /// The residual, N.
        residual: f64,
        /// The noise, N.
        noise: f64,
    },
    /// The torques are not those of the weight.
    #[error(
        "the torques differ from those of a weight by {residual:.3} N·m rms, at a noise of {noise:.3} N·m: they have another unit, axes or \
         sign than the forces, a channel is dead, or something touches the tool"
    )]
    TorqueResidual {
        /// The residual, N·m.
        residual: f64,
        /// The noise, N·m.
        noise: f64,
    },
    /// The centre of mass is where none can be.
    #[error(
        "the centre of mass would be {distance:.1} m away from the sensor: the torques have another unit than N·m, or the forces another one \
         than N"
    )]
    FarCenter {
        /// The distance, m.
        distance: f64,
    },
}

type Normal = SMatrix<f64, 4, 4>;

/// Identifies payload and bias from readings at rest. `noise`: rms of a reading, N and N·m.
///
/// Both parts have the same directions of gravity, so the normal equations split: 4 unknowns of the force, and 6 of the torque.
pub fn identify(readings: &[PayloadReading], noise: [f64; 2]) -> Result<Payload, PayloadError> {
    if readings.len() < MIN_POSTURES {
        return Err(PayloadError::Few(readings.len()));
    }
    if !noise.iter().all(|noise| noise.is_finite() && *noise > 0.0) {
        return Err(PayloadError::Noise);
    }
    check_readings(readings)?;
    let condition = check_postures(readings)?;
    let axes = AxesCheck::new(readings, noise[0]);
    if let Some(better) = axes.better() {
        return Err(PayloadError::Axes(better));
    }
    let (mass, force_bias, mass_uncertainty) = force_part(readings, noise[0]);
    let (moment, torque_bias, moment_uncertainty) = torque_part(readings, noise[1]);
    let residual = |of: &dyn Fn(&PayloadReading) -> Vector3<f64>| {
        let squares: f64 = readings.iter().map(|reading| of(reading).norm_squared()).sum();
        (squares / (3.0 * readings.len() as f64)).sqrt()
    };
    let force_residual = residual(&|r| r.force - force_bias - mass * r.gravity);
    let torque_residual = residual(&|r| r.torque - torque_bias - moment.cross(&r.gravity));
    // Also a residual that overflows.
    if !(force_residual <= MAX_RESIDUAL * noise[0]) {
        return Err(PayloadError::Residual { residual: force_residual, noise: noise[0] });
    }
    if !(torque_residual <= MAX_RESIDUAL * noise[1]) {
        return Err(PayloadError::TorqueResidual { residual: torque_residual, noise: noise[1] });
    }
    let has_mass = mass > SIGMAS * mass_uncertainty;
    let center_of_mass = if has_mass { moment / mass } else { Vector3::zeros() };
    if !(center_of_mass.norm() <= FARTHEST_CENTER) {
        return Err(PayloadError::FarCenter { distance: center_of_mass.norm() });
    }
    // c = (m c)/m: per axis, the error of the mass has a third of the square along c.
    let of_mass = center_of_mass.norm() * mass_uncertainty / 3.0_f64.sqrt();
    let center_uncertainty = moment_uncertainty.hypot(of_mass) / mass;
    Ok(Payload {
        mass: mass.max(0.0),
        center_of_mass,
        force_bias,
        torque_bias,
        mass_uncertainty,
        center_uncertainty: if has_mass { center_uncertainty } else { f64::INFINITY },
        force_residual,
        torque_residual,
        condition,
        axes_verified: axes.are_verified(),
    })
}

/// Refuses numbers that are none, and gravity that is none.
fn check_readings(readings: &[PayloadReading]) -> Result<(), PayloadError> {
    let first = readings[0].gravity.norm();
    let is_valid = |reading: &PayloadReading| {
        let entries = reading.force.iter().chain(&reading.torque);
        let gravity = reading.gravity.norm();
        entries.copied().all(f64::is_finite)
            && GRAVITY_RANGE.contains(&gravity)
            && (gravity - first).abs() <= GRAVITY_TOLERANCE * first
    };
    match readings.iter().position(|reading| !is_valid(reading)) {
        Some(reading) => Err(PayloadError::NotFinite { reading }),
        None => Ok(()),
    }
}

/// Returns the condition of the postures, if they tell a payload from a bias.
fn check_postures(readings: &[PayloadReading]) -> Result<f64, PayloadError> {
    let directions: Vec<_> = readings.iter().map(|reading| reading.gravity.normalize()).collect();
    let condition = condition(&directions);
    if condition <= MAX_CONDITION {
        return Ok(condition);
    }
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let with = |axis: &Vector3<f64>| self::condition(&[&directions[..], &[*axis]].concat());
    let candidates = axes.into_iter().flat_map(|axis| [axis, -axis]);
    let best = candidates.min_by(|a, b| with(a).total_cmp(&with(b)));
    Err(PayloadError::Similar { condition, add: best.unwrap_or_default().into() })
}

/// Returns how badly directions of gravity tell m c from a bias: √(⅔/(tr S − λ_max S)) with their covariance S; 1 at best.
///
/// The information about m c is the mean of |d|² 1 − d dᵀ with d = g − ḡ. That about m is tr S, which is larger.
fn condition(directions: &[Vector3<f64>]) -> f64 {
    let count = directions.len() as f64;
    let mean = directions.iter().sum::<Vector3<f64>>() / count;
    let spread = |direction: &Vector3<f64>| (direction - mean) * (direction - mean).transpose();
    let spread = directions.iter().map(spread).sum::<Matrix3<f64>>() / count;
    let information = spread.trace() - spread.symmetric_eigenvalues().max();
    (2.0 / 3.0 / information.max(0.0)).sqrt()
}

/// Returns mass, bias and the uncertainty of the mass.
fn force_part(readings: &[PayloadReading], noise: f64) -> (f64, Vector3<f64>, f64) {
    let (mut normal, mut right) = (Normal::zeros(), SVector::<f64, 4>::zeros());
    for PayloadReading { gravity, force, .. } in readings {
        for axis in 0..3 {
            let mut row = SVector::<f64, 4>::zeros();
            (row[0], row[1 + axis]) = (gravity[axis], 1.0);
            normal += row * row.transpose();
            right += row * force[axis];
        }
    }
    let inverse = normal.try_inverse().unwrap_or_else(Normal::zeros);
    let found = inverse * right;
    (found[0], Vector3::new(found[1], found[2], found[3]), noise * inverse[(0, 0)].sqrt())
}

/// Returns m c, the bias of the torque and the uncertainty of m c.
fn torque_part(readings: &[PayloadReading], noise: f64) -> (Vector3<f64>, Vector3<f64>, f64) {
    let (mut normal, mut right) = (SMatrix::<f64, 6, 6>::zeros(), SVector::<f64, 6>::zeros());
    for PayloadReading { gravity, torque, .. } in readings {
        let mut rows = SMatrix::<f64, 3, 6>::zeros();
        rows.fixed_view_mut::<3, 3>(0, 0).copy_from(&(-gravity.cross_matrix()));
        rows.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
        normal += rows.transpose() * rows;
        right += rows.transpose() * torque;
    }
    let inverse = normal.try_inverse().unwrap_or_else(SMatrix::<f64, 6, 6>::zeros);
    let found = inverse * right;
    let variance = (inverse[(0, 0)] + inverse[(1, 1)] + inverse[(2, 2)]) / 3.0;
    (Vector3::new(found[0], found[1], found[2]), Vector3::new(found[3], found[4], found[5]), noise * variance.sqrt())
}
