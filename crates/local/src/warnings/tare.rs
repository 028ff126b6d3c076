//! Warnings about the readings of a tare.

use revprio_api::wire;
use revprio_core::controller::ControllerConfig;

use crate::convert::joint_vector;

/// Speed of the last command from which the arm moves, rad/s or m/s.
const MOVING: f64 = 0.02;

/// Distance from the last state from which a reading is one of another posture, rad or m.
const OTHER_POSTURE: f64 = 0.05;

/// Warns about readings that contradict the session: its last state, its last command, or each other.
pub fn warn(
    warnings: &mut Vec<String>,
    (request, config): (&wire::TareRequest, &ControllerConfig),
    (last, command): (Option<&[f64]>, Option<&[f64]>),
) {
    let name = |joint: usize| &config.robot.joints()[joint].name;
    let mut pairs = request.readings.windows(2);
    if request.readings.len() > 1 && pairs.all(|pair| pair[0].wrench == pair[1].wrench) {
        warnings.push(
            "all readings are the same: the sensor sticks, or the program reads faster than the sensor measures; the noise is then none of \
             the sensor"
                .to_owned(),
        );
    }
    if let Some((joint, speed)) =
        command.and_then(|command| largest(command.iter().copied())).filter(|found| found.1 > MOVING)
    {
        warnings.push(format!(
            "the last command moves joint `{}` at {speed:.3} rad/s or m/s; tare with an arm that rests",
            name(joint)
        ));
    }
    let reading = request
        .readings
        .first()
        .and_then(|reading| joint_vector::<Vec<f64>>(&reading.joint_position, &config.robot, "").ok());
    let distances = last.zip(reading.as_deref()).map(|(last, reading)| last.iter().zip(reading).map(|(a, b)| a - b));
    if let Some((joint, distance)) = distances.and_then(largest).filter(|found| found.1 > OTHER_POSTURE) {
        warnings.push(format!(
            "joint `{}` of the readings is {distance:.3} rad or m away from the last state; the bias is wrong if the arm was not there, or if \
             the positions have another unit",
            name(joint)
        ));
    }
}

/// Returns the entry with the largest magnitude, and that.
fn largest(entries: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    entries.map(f64::abs).enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
}
