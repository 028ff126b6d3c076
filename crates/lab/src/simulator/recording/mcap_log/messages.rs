//! One period as messages.

use foxglove::messages::{
    FrameTransform, FrameTransforms, JointState, JointStates, Pose, PoseInFrame, Quaternion, Timestamp, Vector3,
};
use nalgebra::{IsometryMatrix3, UnitQuaternion};
use serde::Serialize;

use super::super::{Contacts, Recording, Sample};

/// Name of the base frame.
pub const BASE: &str = "base";

/// Force and torque at the tool point, on the environment, base axes.
#[derive(Debug, Default, Serialize)]
pub struct Wrench {
    timestamp: Time,
    frame_id: &'static str,
    force: Vector,
    torque: Vector,
}

#[derive(Debug, Default, Serialize)]
struct Time {
    sec: u64,
    nsec: u64,
}

#[derive(Debug, Default, Serialize)]
struct Vector {
    x: f64,
    y: f64,
    z: f64,
}

/// Returns the wrench F_e of a period.
pub fn wrench(sample: &Sample) -> Wrench {
    let vector = |[x, y, z]: [f64; 3]| Vector { x, y, z };
    Wrench { timestamp: time(sample), frame_id: BASE, force: vector(sample.force), torque: vector(sample.torque) }
}

/// The contacts of a period, as in the sample.
#[derive(Debug, Serialize)]
pub struct ContactMessage<'a> {
    timestamp: Time,
    #[serde(flatten)]
    contacts: &'a Contacts,
}

/// Returns the contacts of a period.
pub fn contacts(sample: &Sample) -> ContactMessage<'_> {
    ContactMessage { timestamp: time(sample), contacts: &sample.contacts }
}

fn time(sample: &Sample) -> Time {
    const SECOND: u64 = 1_000_000_000;
    let time = nanoseconds(sample.time_s);
    Time { sec: time / SECOND, nsec: time % SECOND }
}

/// Returns q and the actual q̇.
pub fn joint_states(recording: &Recording, sample: &Sample) -> JointStates {
    let joints = recording.joint_names.iter().enumerate().map(|(i, name)| JointState {
        name: name.clone(),
        position: sample.joint_position.get(i).copied(),
        velocity: sample.actual_velocity.get(i).copied(),
        ..JointState::default()
    });
    JointStates { timestamp: Some(timestamp(sample)), joints: joints.collect() }
}

/// Returns the pose of the tool in the base frame.
pub fn tool_pose(sample: &Sample) -> PoseInFrame {
    let [w, x, y, z] = sample.orientation;
    let pose = Pose { position: Some(vector(sample.position)), orientation: Some(Quaternion { x, y, z, w }) };
    PoseInFrame { timestamp: Some(timestamp(sample)), frame_id: BASE.to_owned(), pose: Some(pose) }
}

/// Returns the frames of the links, named after their joints, and of the tool, all in the base frame.
pub fn transforms(recording: &Recording, sample: &Sample, links: &[IsometryMatrix3<f64>]) -> FrameTransforms {
    let frame = |name: &str, position: Vector3, rotation: Quaternion| FrameTransform {
        timestamp: Some(timestamp(sample)),
        parent_frame_id: BASE.to_owned(),
        child_frame_id: name.to_owned(),
        translation: Some(position),
        rotation: Some(rotation),
    };
    let link = |(name, link): (&String, &IsometryMatrix3<f64>)| {
        frame(name, vector(link.translation.vector.into()), quaternion(&UnitQuaternion::from(link.rotation)))
    };
    let [w, x, y, z] = sample.orientation;
    let tool = frame("tool", vector(sample.position), Quaternion { x, y, z, w });
    FrameTransforms { transforms: recording.joint_names.iter().zip(links).map(link).chain([tool]).collect() }
}

/// Converts seconds.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates")]
pub fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}

/// Returns the start time of a period.
#[expect(clippy::cast_possible_truncation, reason = "below 10^9, and seconds of simulations")]
pub fn timestamp(sample: &Sample) -> Timestamp {
    const SECOND: u64 = 1_000_000_000;
    let time = nanoseconds(sample.time_s);
    Timestamp::new((time / SECOND) as u32, (time % SECOND) as u32)
}

/// Converts a vector.
pub fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

/// Converts a rotation.
pub fn quaternion(rotation: &UnitQuaternion<f64>) -> Quaternion {
    Quaternion { x: rotation.i, y: rotation.j, z: rotation.k, w: rotation.w }
}
