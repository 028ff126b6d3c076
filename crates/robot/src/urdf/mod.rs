//! Robots read from URDF, the Unified Robot Description Format.
//!
//! Only links and joints are read. Meshes, materials, inertias, transmissions and plug-ins are ignored, and no file
//! that the text names is opened. The arm is the chain from one link, the base, to another, the tip. Fixed joints of
//! the chain become constant transforms; the other joints of the chain become the joints of the model. Branches are
//! left out.

mod arms;
mod chain;
mod document;
mod error;
mod joint;
mod words;

pub use error::UrdfError;

use nalgebra::IsometryMatrix3;

use super::{Joint, LimitOverride, Overrides, RobotModel};
use chain::Chain;
use document::{Links, MAX_NAME_BYTES};
use joint::{Moving, Segment, segment};

/// Choices that a URDF text leaves open.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UrdfOptions<'a> {
    /// Name of the robot; if `None`, the name in the text.
    pub name: Option<&'a str>,
    /// Description in one line; if `None`, a summary of the chain.
    pub description: Option<&'a str>,
    /// Link whose frame is the base frame; if `None`, the root of the tree.
    pub base: Option<&'a str>,
    /// Link whose frame is the tool frame; if `None`, the end of the only chain or of the only arm, without gripper.
    pub tip: Option<&'a str>,
    /// Values that replace those of the text.
    pub overrides: Option<&'a Overrides>,
}

impl RobotModel {
    /// Reads the serial chain from base to tip from a URDF text.
    ///
    /// Revolute and prismatic joints need a `<limit>` with `lower`, `upper` and `velocity`. The `<limit>` of a
    /// continuous joint is optional; its `velocity` is read. The attributes `acceleration` and `deceleration` of URDF
    /// 1.2 are read in every version of URDF; the smaller one limits both. Lengths are in m, angles in rad.
    pub fn from_urdf(text: &str, options: &UrdfOptions) -> Result<Self, UrdfError> {
        let document = document::parse(text)?;
        let robot = document::robot(&document)?;
        let links = Links::read(robot)?;
        let chain = Chain::find(&links, options.base, options.tip)?;
        let none = Overrides::default();
        let overrides = options.overrides.unwrap_or(&none);
        let (mut joints, tool) = joints(&chain, overrides)?;
        check_joints(&joints, overrides)?;
        for joint in &mut joints {
            if let Some(name) = overrides.joint_names.get(&joint.name) {
                if !(1..=MAX_NAME_BYTES).contains(&name.len()) {
                    return Err(UrdfError::JointName { joint: joint.name.clone() });
                }
                joint.name.clone_from(name);
            }
        }
        let name = options.name.or(robot.attribute("name")).unwrap_or_default();
        let summary = || format!("{} joints from link `{}` to link `{}`, URDF", joints.len(), chain.base, chain.tip);
        let description = options.description.map_or_else(summary, str::to_owned);
        Ok(Self::new(name, description, joints, tool)?.with_selection(chain.selection(&links)))
    }
}

/// Returns the joints of the chain with their names in the text, and the tool frame behind the last one.
fn joints(chain: &Chain, overrides: &Overrides) -> Result<(Vec<Joint>, IsometryMatrix3<f64>), UrdfError> {
    let (mut placement, mut joints) = (IsometryMatrix3::identity(), Vec::new());
    let mut wrong = None;
    for edge in &chain.joints {
        let stated = overrides.limits.get(edge.name).copied().unwrap_or(LimitOverride::default());
        match segment(edge, &stated) {
            Err(error) => wrong = Some(merge(wrong, error)?),
            Ok(Segment::Fixed(origin)) => placement *= origin,
            Ok(Segment::Moving(moving)) => {
                let Moving { mut joint, after } = *moving;
                joint.placement = placement * joint.placement;
                placement = after;
                joints.push(joint);
            }
        }
    }
    match wrong {
        Some(error) => Err(error),
        None => Ok((joints, overrides.tool_offset.map_or(placement, |offset| placement * offset))),
    }
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

/// Refuses overrides of joints that are no part of the chain.
fn check_joints(joints: &[Joint], overrides: &Overrides) -> Result<(), UrdfError> {
    let limits = overrides.limits.keys().map(|joint| ("limits", joint));
    let names = overrides.joint_names.keys().map(|joint| ("joint_names", joint));
    match limits.chain(names).find(|(_, name)| !joints.iter().any(|joint| joint.name == **name)) {
        None => Ok(()),
        Some((field, joint)) => {
            let joints = joints.iter().map(|joint| joint.name.clone()).collect();
            Err(UrdfError::UnknownJoint { field, joint: joint.clone(), joints })
        }
    }
}

#[cfg(test)]
mod tests;
