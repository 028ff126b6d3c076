//! Reads a whole tree.

use nalgebra::IsometryMatrix3;

use super::chain::{end_links, find_base};
use super::document::{Edge, Links, parse, robot};
use super::joint::Allowed;
use super::joints::joints;
use super::{UrdfError, UrdfTip, UrdfTreeOptions};
use crate::{Overrides, RobotModel, TreeDescription, TreeTip};

impl RobotModel {
    /// Reads all links and joints below the base from a URDF text.
    ///
    /// Joints may be fixed, revolute, continuous or prismatic, with `<mimic>` or without. The rules for `<limit>` are those
    /// of [`Self::from_urdf`]. A mimic joint needs no `<limit>`; if it has one, it restricts the joint that it follows.
    ///
    /// ```
    /// use revprio_robot::kinematics::{Configuration, LinkPoint};
    /// use revprio_robot::{RobotModel, UrdfTreeOptions};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let urdf = r#"
    ///   <robot name="scissors">
    ///     <link name="base"/> <link name="left"/> <link name="right"/>
    ///     <joint name="open" type="revolute">
    ///       <parent link="base"/> <child link="left"/> <axis xyz="0 0 1"/>
    ///       <limit lower="0" upper="1.2" velocity="2"/>
    ///     </joint>
    ///     <joint name="close" type="revolute">
    ///       <parent link="base"/> <child link="right"/> <axis xyz="0 0 1"/> <mimic joint="open" multiplier="-1"/>
    ///     </joint>
    ///   </robot>"#;
    /// let scissors = RobotModel::from_urdf_tree(urdf, &UrdfTreeOptions::default())?;
    /// assert_eq!((scissors.joint_count(), scissors.moving_joints().len()), (1, 2));
    /// let configuration = Configuration::new(&scissors, &[0.4])?;
    /// let (left, right) = (scissors.link("left").ok_or("left")?, scissors.link("right").ok_or("right")?);
    /// // Each blade turns at 1 rad/s, in opposite directions.
    /// let opening = configuration.point_twist(&LinkPoint::origin(left).relative_to(right), &[1.0]);
    /// assert!((opening[5] - 2.0).abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    pub fn from_urdf_tree(text: &str, options: &UrdfTreeOptions) -> Result<Self, UrdfError> {
        let document = parse(text)?;
        let robot = robot(&document)?;
        let links = Links::read(robot)?;
        let base = find_base(&links, options.base)?;
        let none = Overrides::default();
        let overrides = options.overrides.unwrap_or(&none);
        let joints = joints(&edges_below(&links, base), overrides, Allowed::InTree)?;
        let mut tips = tips(&links, base, options.tips);
        if let (Some(tool), Some(offset)) = (tips.first_mut(), overrides.tool_offset) {
            tool.offset *= offset;
        }
        let name = options.name.or(robot.attribute("name")).unwrap_or_default();
        let moving = joints.iter().filter(|joint| joint.motion.is_some()).count();
        let description = options.description.map(str::to_owned);
        let description = description.unwrap_or_else(|| format!("{moving} joints below link `{base}`, URDF"));
        Ok(Self::from_tree(name, description, &TreeDescription { base: base.to_owned(), joints, tips })?)
    }
}

/// Returns the joints below a link, in the order of the text on each link. A joint back to the base is one of them.
fn edges_below<'a>(links: &Links<'a>, base: &'a str) -> Vec<Edge<'a>> {
    let mut edges = links.below(base).to_vec();
    let mut next = 0;
    while next < edges.len() {
        if edges[next].child != base {
            edges.extend_from_slice(links.below(edges[next].child));
        }
        next += 1;
    }
    edges
}

fn tips(links: &Links, base: &str, requested: &[UrdfTip]) -> Vec<TreeTip> {
    let tip = |name: &str, link: &str, offset| TreeTip { name: name.to_owned(), link: link.to_owned(), offset };
    if requested.is_empty() {
        return end_links(links, base).iter().map(|link| tip(link, link, IsometryMatrix3::identity())).collect();
    }
    requested.iter().map(|UrdfTip { name, link, offset }| tip(name, link, *offset)).collect()
}
