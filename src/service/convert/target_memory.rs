//! Streamed targets in the memory of stateless steps.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use revprio_api::wire;
use revprio_core::controller::ControllerConfig;
use revprio_core::linalg::TaskVector;
use revprio_core::streaming::{Reference, Target, TargetStream, TargetValue};

use super::numbers::{check_numbers, number};
use super::terms;
use crate::service::error::ApiError;

/// Reads the streams of a memory.
pub fn target_streams(
    streams: &[wire::TargetStream],
    config: &ControllerConfig,
) -> Result<Vec<TargetStream>, ApiError> {
    let at = |index: usize| move |error: ApiError| error.inside(&format!("/target_streams/{index}"));
    streams.iter().enumerate().map(|(index, stream)| read(stream, config).map_err(at(index))).collect()
}

fn read(stream: &wire::TargetStream, config: &ControllerConfig) -> Result<TargetStream, ApiError> {
    let task = config.tasks.iter().position(|task| task.name == stream.task);
    let unknown =
        || ApiError::invalid("/task", "not a task of this controller; send the memory of the last answer unchanged");
    let sample = |sample: &Option<wire::TargetSample>, field: &str| {
        sample.as_ref().map(|sample| target(sample).map_err(|error| error.inside(field))).transpose()
    };
    let wire::TargetReference { pose, values, velocity } = &stream.reference;
    let reference = || {
        check_numbers(velocity, "/velocity")?;
        Ok(Reference { value: value(pose.as_ref(), values.as_deref())?, velocity: TaskVector::from_slice(velocity) })
    };
    Ok(TargetStream {
        task: task.ok_or_else(unknown)?,
        quantity: terms::quantity(stream.quantity),
        newest: sample(&stream.newest, "/newest")?,
        previous: sample(&stream.previous, "/previous")?,
        reference: reference().map_err(|error: ApiError| error.inside("/reference"))?,
        state: terms::target_state(stream.state),
    })
}

fn target(sample: &wire::TargetSample) -> Result<Target, ApiError> {
    let velocity = sample.velocity.as_ref().map(|velocity| {
        check_numbers(velocity, "/velocity")?;
        Ok(TaskVector::from_slice(velocity))
    });
    Ok(Target {
        time_s: number(sample.time_s, "/time_s")?,
        value: value(sample.pose.as_ref(), sample.values.as_deref())?,
        velocity: velocity.transpose()?,
    })
}

/// Reads a value. The quaternion keeps every bit; the controller checks its length.
fn value(pose: Option<&wire::Pose>, values: Option<&[f64]>) -> Result<TargetValue, ApiError> {
    match (pose, values) {
        (Some(wire::Pose { position, orientation: wire::Orientation { w, x, y, z } }), None) => {
            check_numbers(position, "/pose/position")?;
            check_numbers(&[*w, *x, *y, *z], "/pose/orientation")?;
            let rotation = UnitQuaternion::new_unchecked(Quaternion::new(*w, *x, *y, *z));
            Ok(TargetValue::Pose(Isometry3::from_parts(Translation3::from(*position), rotation)))
        }
        (None, Some(values)) => {
            check_numbers(values, "/values")?;
            Ok(TargetValue::Rows(TaskVector::from_slice(values)))
        }
        _ => Err(ApiError::invalid("", "not a target; send the memory of the last answer unchanged")),
    }
}

/// Returns the streams as a part of an answer.
pub fn target_streams_answer(streams: &[TargetStream], config: &ControllerConfig) -> Vec<wire::TargetStream> {
    streams.iter().map(|stream| answer(stream, config)).collect()
}

fn answer(stream: &TargetStream, config: &ControllerConfig) -> wire::TargetStream {
    let sample = |target: &Target| {
        let (pose, values) = value_answer(&target.value);
        let velocity = target.velocity.as_ref().map(|velocity| velocity.to_vec());
        wire::TargetSample { time_s: target.time_s, pose, values, velocity }
    };
    let (pose, values) = value_answer(&stream.reference.value);
    wire::TargetStream {
        task: config.tasks[stream.task].name.clone(),
        quantity: terms::quantity_answer(stream.quantity),
        newest: stream.newest.as_ref().map(sample),
        previous: stream.previous.as_ref().map(sample),
        reference: wire::TargetReference { pose, values, velocity: stream.reference.velocity.to_vec() },
        state: terms::target_state_answer(stream.state),
    }
}

fn value_answer(value: &TargetValue) -> (Option<wire::Pose>, Option<Vec<f64>>) {
    match value {
        TargetValue::Pose(pose) => {
            let q = pose.rotation;
            let orientation = wire::Orientation { w: q.w, x: q.i, y: q.j, z: q.k };
            (Some(wire::Pose { position: pose.translation.vector.into(), orientation }), None)
        }
        TargetValue::Rows(rows) => (None, Some(rows.to_vec())),
    }
}
