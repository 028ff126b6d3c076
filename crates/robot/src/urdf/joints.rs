//! Reads the joints of a robot, with the values of the caller in the place of those of the text.

use super::UrdfError;
use super::document::{Edge, MAX_NAME_BYTES};
use super::joint::{Allowed, joint};
use crate::{LimitOverride, Overrides, TreeJoint};

/// Reads joints. The names of moving joints are replaced, also where other joints follow them.
pub fn joints(edges: &[Edge], overrides: &Overrides, allowed: Allowed) -> Result<Vec<TreeJoint>, UrdfError> {
    let (mut joints, mut wrong) = (Vec::with_capacity(edges.len()), None);
    for edge in edges {
        let stated = overrides.limits.get(edge.name).copied().unwrap_or(LimitOverride::default());
        match joint(edge, &stated, allowed) {
            Err(error) => wrong = Some(merge(wrong, error)?),
            Ok(joint) => joints.push(joint),
        }
    }
    match wrong {
        Some(error) => return Err(error),
        None => check_joints(&joints, overrides)?,
    }
    joints.iter_mut().try_for_each(|joint| rename(joint, overrides))?;
    Ok(joints)
}

/// Collects the joints whose limits are wrong for the same reason. Errors of another kind are returned at once.
fn merge(first: Option<UrdfError>, error: UrdfError) -> Result<UrdfError, UrdfError> {
    match (first, error) {
        (None, error @ UrdfError::Limit { .. }) => Ok(error),
        (Some(UrdfError::Limit { mut joints, cause, remedy }), UrdfError::Limit { joints: more, cause: other, .. }) => {
            if other == cause {
                joints.extend(more);
            }
            Ok(UrdfError::Limit { joints, cause, remedy })
        }
        (_, error) => Err(error),
    }
}

/// Refuses overrides of joints that are no part of the robot.
fn check_joints(joints: &[TreeJoint], overrides: &Overrides) -> Result<(), UrdfError> {
    let moving = || joints.iter().filter(|joint| joint.motion.is_some()).map(|joint| &joint.name);
    let limits = overrides.limits.keys().map(|joint| ("limits", joint));
    let names = overrides.joint_names.keys().map(|joint| ("joint_names", joint));
    match limits.chain(names).find(|(_, name)| !moving().any(|joint| joint == *name)) {
        None => Ok(()),
        Some((field, joint)) => {
            Err(UrdfError::UnknownJoint { field, joint: joint.clone(), joints: moving().cloned().collect() })
        }
    }
}

fn rename(joint: &mut TreeJoint, overrides: &Overrides) -> Result<(), UrdfError> {
    let Some(motion) = &mut joint.motion else { return Ok(()) };
    if let Some(name) = overrides.joint_names.get(&joint.name) {
        if !(1..=MAX_NAME_BYTES).contains(&name.len()) {
            return Err(UrdfError::JointName { joint: joint.name.clone() });
        }
        joint.name.clone_from(name);
    }
    if let Some(mimic) = &mut motion.mimic
        && let Some(name) = overrides.joint_names.get(&mimic.leader)
    {
        mimic.leader.clone_from(name);
    }
    Ok(())
}
