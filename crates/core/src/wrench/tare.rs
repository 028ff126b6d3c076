//! Taring: the bias of a sensor from readings at rest, with its load known.

use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Configuration, ConfigurationError};

use super::{Wrench, WrenchSensor, WrenchTerms};

/// Smallest number of readings: their mean then has less than a quarter of the noise.
pub const MIN_TARE_READINGS: usize = 20;

/// Largest motion of a joint at which the arm rests, rad or m.
pub const TARE_MOTION: f64 = 1e-3;

/// Largest noise of a wrench at rest, rms per axis, N and N·m.
pub const TARE_NOISE: [f64; 2] = [1.0, 0.1];

/// One reading of a sensor at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct TareReading {
    /// q, joint position, n, rad or m.
    pub joint_position: Vec<f64>,
    /// The reading, in the terms of the controller, N and N·m.
    pub wrench: [f64; 6],
}

/// What taring finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tare {
    /// b, reading without load, along the axes of the sensor, N and N·m.
    pub bias: Wrench,
    /// Noise of a reading along the noisiest axis, rms, N and N·m.
    pub noise: [f64; 2],
}

/// Why a sensor is not tared.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TareError {
    /// There are too few readings.
    #[error("{0} readings; give at least {MIN_TARE_READINGS}, of an arm that rests and touches nothing")]
    Few(usize),
    /// The joint positions of a reading do not fit the robot.
    #[error("{source}")]
    Configuration {
        /// Index of the reading, from 0.
        reading: usize,
        /// What is wrong with it.
        source: ConfigurationError,
    },
    /// A wrench is not finite.
    #[error("the wrench must be of finite numbers")]
    NotFinite {
        /// Index of the reading, from 0.
        reading: usize,
    },
    /// The arm moves.
    #[error(
        "joint {} moves by {motion:.4} rad or m while the sensor is read; tare with an arm that rests: at most {TARE_MOTION} rad or m",
        joint + 1
    )]
    Moves {
        /// Index of the joint, from 0.
        joint: usize,
        /// How far it moves, rad or m.
        motion: f64,
    },
    /// The wrench is noisy.
    #[error(
        "the {} has a noise of {noise:.2} {} rms, more than {limit} {}: something touches or shakes the tool, or the sensor is faulty; \
         wait until it is quiet",
        if *is_torque { "torque" } else { "force" }, unit(*is_torque), unit(*is_torque)
    )]
    Noisy {
        /// Whether it is the torque.
        is_torque: bool,
        /// Its noise, rms, N or N·m.
        noise: f64,
        /// The largest noise, N or N·m.
        limit: f64,
    },
}

fn unit(is_torque: bool) -> &'static str {
    if is_torque { "N·m" } else { "N" }
}

/// Returns the bias of a sensor from readings in one posture. The load of the sensor counts, its bias does not.
///
/// The bias is the mean reading less the weight of the load, so the wrench stays right in every other posture as far as the load is known.
pub fn tare(
    sensor: &WrenchSensor,
    terms: WrenchTerms,
    robot: &RobotModel,
    readings: &[TareReading],
) -> Result<Tare, TareError> {
    if readings.len() < MIN_TARE_READINGS {
        return Err(TareError::Few(readings.len()));
    }
    check_rest(robot, readings)?;
    let mut wrenches = Vec::with_capacity(readings.len());
    for (reading, TareReading { joint_position, wrench }) in readings.iter().enumerate() {
        if !wrench.iter().all(|entry| entry.is_finite()) {
            return Err(TareError::NotFinite { reading });
        }
        let at = |source| TareError::Configuration { reading, source };
        let configuration = Configuration::new(robot, joint_position).map_err(at)?;
        let rotation = (configuration.tip_pose(&robot.tips()[sensor.tip]) * sensor.pose).rotation;
        let load = sensor.load.wrench(&(rotation.inverse() * sensor.gravity));
        let measured = terms.along_sensor(wrench, &rotation);
        wrenches.push(<[f64; 6]>::from(Wrench::combined(1.0, &measured, terms.convention.sign(), &load)));
    }
    let (mean, noise) = mean_and_noise(&wrenches);
    for (is_torque, (noise, limit)) in [false, true].into_iter().zip(noise.into_iter().zip(TARE_NOISE)) {
        if !(noise <= limit) {
            return Err(TareError::Noisy { is_torque, noise, limit });
        }
    }
    Ok(Tare { bias: mean.into(), noise })
}

/// Refuses an arm that moves.
fn check_rest(robot: &RobotModel, readings: &[TareReading]) -> Result<(), TareError> {
    let expected = robot.joint_count();
    for (reading, TareReading { joint_position, .. }) in readings.iter().enumerate() {
        if joint_position.len() != expected {
            let source = ConfigurationError::Size { expected, given: joint_position.len() };
            return Err(TareError::Configuration { reading, source });
        }
    }
    for joint in 0..expected {
        let positions = readings.iter().map(|reading| reading.joint_position[joint]);
        let (least, most) = positions.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), q| (a.min(q), b.max(q)));
        if most - least > TARE_MOTION {
            return Err(TareError::Moves { joint, motion: most - least });
        }
    }
    Ok(())
}

/// Returns the mean of wrenches, and the standard deviation along the noisiest axis of force and of torque.
fn mean_and_noise(wrenches: &[[f64; 6]]) -> ([f64; 6], [f64; 2]) {
    let count = wrenches.len() as f64;
    let mean: [f64; 6] = std::array::from_fn(|i| wrenches.iter().map(|wrench| wrench[i] / count).sum::<f64>());
    let deviation: [f64; 6] = std::array::from_fn(|i| {
        (wrenches.iter().map(|wrench| (wrench[i] - mean[i]).powi(2) / (count - 1.0)).sum::<f64>()).sqrt()
    });
    let most = |entries: &[f64]| entries.iter().copied().fold(0.0, f64::max);
    (mean, [most(&deviation[..3]), most(&deviation[3..])])
}
