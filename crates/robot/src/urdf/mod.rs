//! Robots read from URDF, the Unified Robot Description Format.
//!
//! Only links and joints are looked at; meshes, materials, inertias, transmissions and plug-ins are passed over, and
//! nothing that a text names is opened. The chain leads from one link, the base, to another, the tip: its fixed joints
//! become constant transforms, its moving ones the joints of the model. What branches off is not part of the arm.

mod chain;
mod document;
mod error;
mod joint;

pub use error::UrdfError;

use nalgebra::IsometryMatrix3;

use super::RobotModel;
use chain::Chain;
use document::Links;
use joint::{Moving, Segment, segment};

/// What a URDF text leaves open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct UrdfOptions<'a> {
    /// Name of the robot; that of the text if `None`.
    pub name: Option<&'a str>,
    /// One line for people; a summary if `None`.
    pub description: Option<&'a str>,
    /// Link that the arm stands on, whose frame is the base frame; the root of the tree if `None`.
    pub base: Option<&'a str>,
    /// Link whose frame is the tool frame; the only leaf of the tree if `None`.
    pub tip: Option<&'a str>,
}

impl RobotModel {
    /// Reads the serial chain from base to tip.
    ///
    /// Revolute and prismatic joints need a `<limit>` with `lower`, `upper` and `velocity`; a continuous joint may have
    /// one with `velocity`. The attributes `acceleration` and `deceleration` of URDF 1.2 count in every version, the
    /// smaller one as the limit for both. Lengths in m, angles in rad.
    pub fn from_urdf(text: &str, options: &UrdfOptions) -> Result<Self, UrdfError> {
        let document = document::parse(text)?;
        let robot = document::robot(&document)?;
        let links = Links::read(robot)?;
        let chain = Chain::find(&links, options.base, options.tip)?;
        let (mut placement, mut joints) = (IsometryMatrix3::identity(), Vec::new());
        for joint in &chain.joints {
            match segment(joint)? {
                Segment::Fixed(origin) => placement *= origin,
                Segment::Moving(moving) => {
                    let Moving { mut joint, after } = *moving;
                    joint.placement = placement * joint.placement;
                    placement = after;
                    joints.push(joint);
                }
            }
        }
        let name = options.name.or(robot.attribute("name")).unwrap_or_default();
        let summary = || format!("{} joints from link `{}` to link `{}`, URDF", joints.len(), chain.base, chain.tip);
        let description = options.description.map_or_else(summary, str::to_owned);
        Ok(Self::new(name, description, joints, placement)?)
    }
}

#[cfg(test)]
mod tests;
