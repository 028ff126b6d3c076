//! Wrench sensors: their configuration, memory, corrected wrenches and taring.

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_api::wire;
use revprio_core::controller::{Command, ControllerConfig};
use revprio_core::law::ContactLaw;
use revprio_core::wrench::{
    Load, SensorState, Tare, TareError, TareReading, Wrench, WrenchSensor, WrenchSensorError, tare,
};
use revprio_robot::{RobotModel, Tip};

use super::checks::{Inside, Missing, Result, check, each, foreign};
use super::numbers::{check_numbers, joint_vector, not_negative};
use super::pose::pose;
use super::wrenches::six;
use crate::error::{ApiError, escape_pointer};

/// Maximum mass of a payload, kg: no arm lifts more.
pub const MAX_PAYLOAD_KG: f64 = 1e4;

/// Maximum distance of a centre of mass from its sensor along an axis, m.
const MAX_CENTER_M: f64 = 100.0;

/// Maximum time constant of a low-pass, s, as of the sensor itself.
pub const MAX_FILTER_S: f64 = ContactLaw::MOST_SENSOR_LAG;

/// Maximum number of readings in a request. Their kinematics take a millisecond.
pub const MAX_READINGS: usize = 1000;

/// Reads the sensors of a controller, in the order of the tips.
pub fn wrench_sensors(request: &wire::Controller, robot: &RobotModel) -> Result<Vec<WrenchSensor>> {
    let offset = request.tool_offset.as_ref().map(pose).transpose().inside("/tool_offset")?;
    let mut sensors = Vec::new();
    if let Some(stated) = &request.wrench_sensor {
        sensors.push(sensor(stated, 0, offset.as_ref()).inside("/wrench_sensor")?);
    }
    for name in request.wrench_sensors.keys() {
        let index = tip_index(robot, name).inside(&place(name))?;
        let detail = "this tip is the tool; state its sensor in `wrench_sensor`";
        check(index > 0, &place(name), detail)?;
    }
    for (index, tip) in robot.tips().iter().enumerate().skip(1) {
        if let Some(stated) = request.wrench_sensors.get(&tip.name) {
            sensors.push(sensor(stated, index, None).inside(&place(&tip.name))?);
        }
    }
    Ok(sensors)
}

fn place(tip: &str) -> String {
    format!("/wrench_sensors/{}", escape_pointer(tip))
}

/// Returns the index of the tip with this name.
pub fn tip_index(robot: &RobotModel, name: &str) -> Result<usize> {
    let names = || robot.tips().iter().map(|tip| tip.name.as_str()).collect::<Vec<_>>().join("`, `");
    let index = robot.tips().iter().position(|tip| tip.name == name);
    index.ok_or_else(|| ApiError::invalid("", format!("the robot has no tip `{name}`; it has `{}`", names())))
}

/// Reads a sensor. `offset`: the tool point in the robot's own tool frame, m.
fn sensor(stated: &wire::WrenchSensor, tip: usize, offset: Option<&IsometryMatrix3<f64>>) -> Result<WrenchSensor> {
    let wire::WrenchSensor { bias, payload, gravity, compensate_inertia, filter_time_s, .. } = stated;
    let wire::Payload { mass_kg, center_of_mass } = payload;
    let placed = stated.pose.as_ref().map(pose).transpose().inside("/pose")?;
    check_numbers(gravity, "/gravity")?;
    not_negative(*mass_kg, "/payload/mass_kg")?;
    check(*mass_kg <= MAX_PAYLOAD_KG, "/payload/mass_kg", format_args!("give at most {MAX_PAYLOAD_KG} kg"))?;
    check_numbers(center_of_mass, "/payload/center_of_mass")?;
    let is_near = center_of_mass.iter().all(|entry| entry.abs() <= MAX_CENTER_M);
    check(is_near, "/payload/center_of_mass", format_args!("give metres, at most {MAX_CENTER_M}"))?;
    not_negative(*filter_time_s, "/filter_time_s")?;
    check(*filter_time_s <= MAX_FILTER_S, "/filter_time_s", format_args!("give at most {MAX_FILTER_S} s"))?;
    Ok(WrenchSensor {
        tip,
        pose: match (placed, offset) {
            (Some(placed), Some(offset)) => offset.inv_mul(&placed),
            (Some(placed), None) => placed,
            (None, _) => IsometryMatrix3::identity(),
        },
        bias: Wrench::from(six(bias).inside("/bias")?),
        load: Load { mass: *mass_kg, center_of_mass: Vector3::from(*center_of_mass) },
        gravity: Vector3::from(*gravity),
        compensates_inertia: *compensate_inertia,
        filter_time: *filter_time_s,
        deadband: [not_negative(stated.deadband_n, "/deadband_n")?, not_negative(stated.deadband_nm, "/deadband_nm")?],
    })
}

/// Returns the place of a sensor that the library refuses.
pub fn sensor_pointer(error: &WrenchSensorError) -> String {
    match error {
        WrenchSensorError::Tip => "/wrench_sensors".to_owned(),
        WrenchSensorError::Range { field, .. } => format!("/wrench_sensor/{field}"),
    }
}

/// Returns a wrench as a part of an answer.
pub fn wrench_answer(wrench: Wrench) -> wire::Wrench {
    wire::Wrench { force: wrench.force.into(), torque: wrench.torque.into() }
}

/// Returns the corrected wrench of the tool, and those of other tips by name.
pub fn corrected<'a>(
    command: &'a Command,
    config: &'a ControllerConfig,
) -> impl Iterator<Item = (&'a Tip, bool, wire::Wrench)> {
    let sensors = config.wrench_sensors.iter().zip(&command.wrenches);
    sensors.map(|(sensor, wrench)| {
        (&config.robot.tips()[sensor.tip], sensor.tip == 0, wrench_answer(Wrench::from(*wrench)))
    })
}

/// Reads what the sensors remember.
pub fn sensor_memory(memory: &[wire::WrenchSensorMemory], config: &ControllerConfig) -> Result<Vec<SensorState>> {
    let (given, most) = (memory.len(), config.wrench_sensors.len());
    if given > most {
        return Err(foreign("/wrench_sensors", "more sensors than the controller has"));
    }
    each("/wrench_sensors", memory, |_, state: &wire::WrenchSensorMemory| {
        let filtered = state.filtered.as_ref().map(six).transpose().inside("/filtered")?;
        let velocity = state.velocity.as_ref();
        velocity.map_or(Ok(()), |velocity| check_numbers(velocity, "/velocity"))?;
        Ok(SensorState { filtered: filtered.map(Wrench::from), velocity: velocity.copied().map(Vector3::from) })
    })
}

/// Returns what the sensors remember as a part of an answer.
pub fn sensor_memory_answer(states: &[SensorState]) -> Vec<wire::WrenchSensorMemory> {
    let answer = |state: &SensorState| wire::WrenchSensorMemory {
        filtered: state.filtered.map(wrench_answer),
        velocity: state.velocity.map(Into::into),
    };
    states.iter().map(answer).collect()
}

/// Tares a sensor of a controller: returns the answer, the controller of the request with the bias, and all its sensors.
pub fn tared(
    request: &wire::TareRequest,
    controller: &wire::Controller,
    config: &ControllerConfig,
) -> Result<(wire::TareAnswer, wire::Controller, Vec<WrenchSensor>)> {
    let robot = &config.robot;
    let tip = request.tip.as_deref().map_or(Ok(0), |name| tip_index(robot, name)).inside("/tip")?;
    let mut sensors = config.wrench_sensors.clone();
    let index = sensors.iter().position(|sensor| sensor.tip == tip).unwrap_or_else(|| {
        // In the order of the tips, as the controller of the request.
        let index = sensors.iter().take_while(|sensor| sensor.tip < tip).count();
        sensors.insert(index, WrenchSensor::at_tip(tip));
        index
    });
    let sensor = sensors[index];
    let Tare { bias, noise } = tare(&sensor, config.wrench_terms(), robot, &rest_readings(request, robot)?)
        .map_err(|error| refused(&error))?;
    sensors[index].bias = bias;
    let bias = wrench_answer(bias);
    let mut tared = controller.clone();
    let entry = match tip {
        0 => tared.wrench_sensor.get_or_insert_default(),
        _ => tared.wrench_sensors.entry(robot.tips()[tip].name.clone()).or_default(),
    };
    entry.bias = bias;
    let warnings = if sensor.load.mass > 0.0 {
        Vec::new()
    } else {
        vec![
            "no payload is stated, so the weight of the tool counts as bias and is right in this posture only; state `payload` of the \
             sensor, which `POST /v1/payload` finds"
                .to_owned(),
        ]
    };
    let [force_noise_n, torque_noise_nm] = noise;
    Ok((wire::TareAnswer { bias, force_noise_n, torque_noise_nm, warnings }, tared, sensors))
}

fn rest_readings(request: &wire::TareRequest, robot: &RobotModel) -> Result<Vec<TareReading>> {
    check_count(request.readings.len())?;
    each("/readings", &request.readings, |_, reading: &wire::RestReading| {
        let joint_position = joint_vector(&reading.joint_position, robot, "/joint_position")?;
        Ok(TareReading { joint_position, wrench: six(&reading.wrench).inside("/wrench")? })
    })
}

/// Refuses too many readings.
pub fn check_count(given: usize) -> Result<()> {
    let few = (given <= MAX_READINGS).then_some(());
    few.or_invalid("/readings", format_args!("{given} readings; give at most {MAX_READINGS}"))
}

fn refused(error: &TareError) -> ApiError {
    let pointer = match error {
        TareError::Few(_) | TareError::Moves { .. } | TareError::Noisy { .. } => "/readings".to_owned(),
        TareError::Configuration { reading, .. } => format!("/readings/{reading}/joint_position"),
        TareError::NotFinite { reading } => format!("/readings/{reading}/wrench"),
    };
    ApiError::invalid(pointer, error)
}
