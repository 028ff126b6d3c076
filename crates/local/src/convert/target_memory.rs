//! Streamed targets in the memory of stateless steps.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use revprio_api::wire;
use revprio_core::controller::ControllerConfig;
use revprio_core::law::TaskVector;
use revprio_core::streaming::{Chunk, Fade, LaterTarget, Reference, Target, TargetStream, TargetValue};

use super::checks::{Inside, Result, each, foreign};
use super::numbers::{check_numbers, number, time};
use super::terms;

/// Reads the streams of a memory.
pub fn target_streams(streams: &[wire::TargetStream], config: &ControllerConfig) -> Result<Vec<TargetStream>> {
    each("/target_streams", streams, |_, stream| read(stream, config))
}

fn read(stream: &wire::TargetStream, config: &ControllerConfig) -> Result<TargetStream> {
    let task = config.tasks.iter().position(|task| task.name == stream.task);
    let sample = |sample: &Option<wire::TargetSample>, field| sample.as_ref().map(target).transpose().inside(field);
    let wire::TargetReference { pose, values, velocity } = &stream.reference;
    let reference = || {
        let velocity = task_vector(velocity, "/velocity")?;
        Ok(Reference { value: value(pose.as_ref(), values.as_deref())?, velocity })
    };
    Ok(TargetStream {
        task: task.ok_or_else(|| foreign("/task", "not a task of this controller"))?,
        quantity: terms::quantity(stream.quantity),
        newest: sample(&stream.newest, "/newest")?,
        previous: sample(&stream.previous, "/previous")?,
        ahead: each("/ahead", &stream.ahead, |_, later| later_target(later))?,
        chunk: stream.chunk.as_ref().map_or_else(|| Ok(Chunk::default()), chunk).inside("/chunk")?,
        reference: reference().inside("/reference")?,
        state: terms::target_state(stream.state),
    })
}

fn target(sample: &wire::TargetSample) -> Result<Target> {
    let velocity = sample.velocity.as_ref().map(|velocity| task_vector(velocity, "/velocity")).transpose()?;
    let value = value(sample.pose.as_ref(), sample.values.as_deref())?;
    Ok(Target { time_s: time(sample.time_s, "/time_s")?, value, velocity })
}

fn later_target(later: &wire::LaterTarget) -> Result<LaterTarget> {
    let value = value(later.pose.as_ref(), later.values.as_deref())?;
    Ok(LaterTarget { time_s: time(later.time_s, "/time_s")?, value })
}

fn chunk(chunk: &wire::ChunkMemory) -> Result<Chunk> {
    Ok(Chunk {
        actions: each("/actions", &chunk.actions, |_, action| later_target(action))?,
        merged_s: time(chunk.merged_s, "/merged_s")?,
        first_s: Some(time(chunk.first_s, "/first_s")?),
        fade: chunk.fade.as_ref().map(fade).transpose().inside("/fade")?,
    })
}

fn fade(fade: &wire::Fade) -> Result<Fade> {
    Ok(Fade {
        start_s: time(fade.start_s, "/start_s")?,
        duration_s: number(fade.duration_s, "/duration_s")?,
        offset: task_vector(&fade.offset, "/offset")?,
        rate: task_vector(&fade.rate, "/rate")?,
        acceleration: task_vector(&fade.acceleration, "/acceleration")?,
    })
}

fn task_vector(values: &[f64], pointer: &str) -> Result<TaskVector> {
    check_numbers(values, pointer).map(|()| TaskVector::from_slice(values))
}

/// Reads a value. The quaternion keeps every bit; the controller checks its length.
pub fn value(pose: Option<&wire::Pose>, values: Option<&[f64]>) -> Result<TargetValue> {
    match (pose, values) {
        (Some(wire::Pose { position, orientation: wire::Orientation { w, x, y, z } }), None) => {
            check_numbers(position, "/pose/position")?;
            check_numbers(&[*w, *x, *y, *z], "/pose/orientation")?;
            let rotation = UnitQuaternion::new_unchecked(Quaternion::new(*w, *x, *y, *z));
            Ok(TargetValue::Pose(Isometry3::from_parts(Translation3::from(*position), rotation)))
        }
        (None, Some(values)) => task_vector(values, "/values").map(TargetValue::Rows),
        _ => Err(foreign("", "not a target")),
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
        ahead: stream.ahead.iter().map(later_answer).collect(),
        chunk: chunk_answer(&stream.chunk),
        reference: wire::TargetReference { pose, values, velocity: stream.reference.velocity.to_vec() },
        state: terms::target_state_answer(stream.state),
    }
}

fn chunk_answer(chunk: &Chunk) -> Option<wire::ChunkMemory> {
    let fade = |fade: &Fade| wire::Fade {
        start_s: fade.start_s,
        duration_s: fade.duration_s,
        offset: fade.offset.to_vec(),
        rate: fade.rate.to_vec(),
        acceleration: fade.acceleration.to_vec(),
    };
    Some(wire::ChunkMemory {
        first_s: chunk.first_s?,
        merged_s: chunk.merged_s,
        actions: chunk.actions.iter().map(later_answer).collect(),
        fade: chunk.fade.as_ref().map(fade),
    })
}

fn later_answer(later: &LaterTarget) -> wire::LaterTarget {
    let (pose, values) = value_answer(&later.value);
    wire::LaterTarget { time_s: later.time_s, pose, values }
}

pub fn value_answer(value: &TargetValue) -> (Option<wire::Pose>, Option<Vec<f64>>) {
    match value {
        TargetValue::Pose(pose) => {
            let q = pose.rotation;
            let orientation = wire::Orientation { w: q.w, x: q.i, y: q.j, z: q.k };
            (Some(wire::Pose { position: pose.translation.vector.into(), orientation }), None)
        }
        TargetValue::Rows(rows) => (None, Some(rows.to_vec())),
    }
}
