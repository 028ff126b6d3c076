//! Reads a serial arm.

use nalgebra::IsometryMatrix3;

use super::chain::Chain;
use super::document::{Links, parse, robot};
use super::joint::Allowed;
use super::joints::joints;
use super::{UrdfError, UrdfOptions};
use crate::{Overrides, RobotModel, TreeDescription, TreeTip};

impl RobotModel {
    /// Reads the serial chain from base to tip from a URDF text. Its links are those of the chain, and its tip has the
    /// name of the last one.
    ///
    /// Revolute and prismatic joints need a `<limit>` with `lower`, `upper` and `velocity`. The `<limit>` of a
    /// continuous joint is optional; its `velocity` is read. The attributes `acceleration` and `deceleration` of URDF
    /// 1.2 are read in every version of URDF; the smaller one limits both. Lengths are in m, angles in rad.
    pub fn from_urdf(text: &str, options: &UrdfOptions) -> Result<Self, UrdfError> {
        let document = parse(text)?;
        let robot = robot(&document)?;
        let links = Links::read(robot)?;
        let chain = Chain::find(&links, options.base, options.tip)?;
        let none = Overrides::default();
        let overrides = options.overrides.unwrap_or(&none);
        let joints = joints(&chain.joints, overrides, Allowed::InSerialArm)?;
        let name = options.name.or(robot.attribute("name")).unwrap_or_default();
        let moving = joints.iter().filter(|joint| joint.motion.is_some()).count();
        let summary = || format!("{moving} joints from link `{}` to link `{}`, URDF", chain.base, chain.tip);
        let description = options.description.map_or_else(summary, str::to_owned);
        let [tip, base] = [chain.tip, chain.base].map(str::to_owned);
        let offset = overrides.tool_offset.unwrap_or_else(IsometryMatrix3::identity);
        let tips = vec![TreeTip { name: tip.clone(), link: tip, offset }];
        let robot = Self::from_tree(name, description, &TreeDescription { base, joints, tips })?;
        Ok(robot.with_selection(chain.selection(&links)))
    }
}
