//! The first step: what the arm is like.

mod late_state;
mod watchdog;

use std::ops::Deref;

use revprio_robot::kinematics::ConfigurationError;

use self::late_state::Missed;
use crate::arm_state::ArmState;
use crate::controller::config::ControllerConfig;
use crate::controller::state::{Measurement, Memory, StepError};
use crate::wrench::ArmReading;

/// The memory from which a period continues.
pub(super) enum Known<'a> {
    /// That of the last period.
    Last(&'a Memory),
    /// The same after the periods that passed without a state.
    Late(Memory),
    /// That of the first period.
    First(Memory),
}

impl Deref for Known<'_> {
    type Target = Memory;

    fn deref(&self) -> &Memory {
        match self {
            Self::Last(memory) => memory,
            Self::Late(memory) | Self::First(memory) => memory,
        }
    }
}

impl Known<'_> {
    /// Returns whether the state comes one period after the last one.
    pub fn is_in_time(&self) -> bool {
        !matches!(self, Self::Late(_))
    }

    /// Returns the memory if it is not that of the last period.
    pub fn into_new(self) -> Option<Memory> {
        match self {
            Self::Last(_) => None,
            Self::Late(memory) | Self::First(memory) => Some(memory),
        }
    }
}

/// Updates the arm to a checked measurement; returns it, and the memory from which the period continues.
pub(super) fn measure<'a, 'm>(
    config: &ControllerConfig,
    memory: Option<&'m Memory>,
    measurement: &Measurement,
    arm: &'a mut ArmState,
) -> Result<(&'a ArmState, Known<'m>), StepError> {
    let late = memory.and_then(|memory| memory.after_missed_periods(config, measurement));
    let (late, missed) = late.unzip();
    let known = late.map(Known::Late).or_else(|| memory.map(Known::Last));
    let last_command = known.as_ref().map(|known| known.last_command.as_slice());
    match (&measurement.joint_velocity, last_command) {
        (Some(measured), _) => arm.move_to(&measurement.joint_position, measured)?,
        (None, Some(last_command)) => arm.move_to(&measurement.joint_position, last_command)?,
        (None, None) => arm.stand_at(&measurement.joint_position)?,
    }
    let answered = known.as_ref().and_then(|known| known.answered.as_ref());
    arm.move_from(answered.map(|answered| answered.joint_position.as_slice()));
    if let Some(Missed { way, time }) = missed {
        arm.missed_way.copy_from_slice(way.as_slice());
        arm.missed_time = time;
    } else {
        arm.missed_way.fill(0.0);
        arm.missed_time = 0.0;
    }
    let tool_pose = *arm.measured().configuration.tool_pose();
    let initial_pose = known.as_ref().map_or(tool_pose, |known| known.initial_pose);
    (arm.time_s, arm.initial_pose) = (measurement.time_s, initial_pose);
    match known.as_ref().and_then(|known| known.initial_position.as_ref()) {
        Some(initial) => arm.start_at(initial.as_slice())?,
        None => arm.start_at(&measurement.joint_position)?,
    }
    let contact = |index: usize| Some(known.as_ref()?.contacts.get(index)?.known());
    arm.recall_surfaces(|index| contact(index).unwrap_or_default());
    let mut known = known.unwrap_or_else(|| Known::First(Memory::at_start(config, arm.measured())));
    read_wrenches(config, measurement, &known, arm)?;
    if !arm.update_surfaces(config.period_s + arm.missed_time) {
        return Err(StepError::NotFinite);
    }
    arm.profiles_start_s = known.start_time_s;
    recall(config, &known, arm)?;
    if let (Known::Late(late), Some(before)) = (&mut known, memory)
        && late.last_command != before.last_command
    {
        late.continue_from_ramp(config, arm);
    }
    Ok((arm, known))
}

/// Updates the wrenches of the arm at the measured posture.
fn read_wrenches(
    config: &ControllerConfig,
    measurement: &Measurement,
    known: &Memory,
    arm: &mut ArmState,
) -> Result<(), StepError> {
    let terms = config.wrench_terms();
    let tool = terms.on_environment(&measurement.wrench, &arm.measured().configuration.tool_pose().rotation);
    arm.wrenches.fill([0.0; 6]);
    arm.wrenches[0] = tool;
    for measured in &measurement.wrenches {
        let pose = arm.measured().configuration.tip_pose(&config.robot.tips()[measured.tip]);
        arm.wrenches[measured.tip] = terms.on_environment(&measured.wrench, &pose.rotation);
    }
    arm.sensors.clear();
    for (index, sensor) in config.wrench_sensors.iter().enumerate() {
        let mut state = known.wrench_sensors.get(index).copied().unwrap_or_default();
        if let Some(reading) = measurement.wrench_at(sensor.tip) {
            let reader = ArmReading {
                robot: &config.robot,
                configuration: arm.measured().configuration,
                joint_velocity: known.drive.velocity.as_slice(),
                elapsed: config.period_s + arm.missed_time,
            };
            arm.wrenches[sensor.tip] = state.process(sensor, terms, reading, reader);
        }
        // Numbers near the largest ones overflow.
        if !(state.is_valid() && arm.wrenches[sensor.tip].iter().all(|entry| entry.is_finite())) {
            return Err(StepError::NotFinite);
        }
        arm.sensors.push(state);
    }
    Ok(())
}

/// Updates what the arm has from the memory: the last command, its acceleration, and where it leads the arm.
fn recall(config: &ControllerConfig, known: &Memory, arm: &mut ArmState) -> Result<(), ConfigurationError> {
    arm.last_command.copy_from_slice(known.last_command.as_slice());
    match &known.jerk {
        Some(jerk) if !arm.last_acceleration.is_empty() => {
            arm.last_acceleration.copy_from_slice(jerk.acceleration.as_slice());
        }
        _ => arm.last_acceleration.fill(0.0),
    }
    for (joint, distance) in arm.distance_to_rest.iter_mut().enumerate() {
        *distance = known.drive.distance_to_rest(config.drive, joint, config.period_s);
    }
    arm.look_ahead(config.period_s)
}
