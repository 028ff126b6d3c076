//! Random trees with every kind of joint, and their poses by products of transforms.

use std::collections::HashMap;
use std::f64::consts::PI;

use nalgebra::{IsometryMatrix3, Rotation3, Translation3, Unit, Vector3};
use proptest::prelude::*;
use revprio_robot::{
    JointKind, JointLimits, JointMotion, LinkId, Mimic, RobotModel, TreeDescription, TreeJoint, TreeTip,
};

/// A tree with a posture (n, rad or m).
#[derive(Debug, Clone)]
pub struct AnyTree {
    pub description: TreeDescription,
    pub robot: RobotModel,
    pub joint_position: Vec<f64>,
    pub joint_velocity: Vec<f64>,
}

/// What is random about one joint.
#[derive(Debug, Clone)]
struct Draw {
    origin: IsometryMatrix3<f64>,
    axis: Vector3<f64>,
    /// 0 fixed, 1 revolute, 2 continuous, 3 prismatic, 4 and 5 mimic of both kinds.
    kind: u8,
    /// Places of the parent among the links and of the leader among the joints, in thousandths.
    parent: usize,
    leader: usize,
    multiplier: f64,
    offset: f64,
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

fn any_transform() -> impl Strategy<Value = IsometryMatrix3<f64>> {
    (vector(0.5), vector(PI)).prop_map(|(shift, turn)| IsometryMatrix3::new(shift, turn))
}

fn any_draw() -> impl Strategy<Value = Draw> {
    let axis = prop_oneof![Just(Vector3::z()), Just(-Vector3::x()), vector(2.0)];
    let axis = axis.prop_filter("an axis has a direction", |axis| axis.norm() > 0.1);
    let numbers = (0..1000_usize, 0..1000_usize, -2.0..2.0_f64, -1.0..1.0_f64);
    (any_transform(), axis, 0..6_u8, numbers).prop_map(|(origin, axis, kind, (parent, leader, multiplier, offset))| {
        // Half of the joints hang on the link before, so there are long limbs.
        let parent = (2 * parent).min(999);
        Draw { origin, axis, kind, parent, leader, multiplier, offset }
    })
}

/// Returns a place in a list of `count` entries.
fn place(thousandths: usize, count: usize) -> usize {
    thousandths * count / 1000
}

fn link(i: usize) -> String {
    format!("link_{i}")
}

fn joint(i: usize, draw: &Draw, leaders: &[String]) -> TreeJoint {
    let mimic = (draw.kind > 3).then(|| Mimic {
        leader: leaders[place(draw.leader, leaders.len())].clone(),
        multiplier: draw.multiplier,
        offset: draw.offset,
    });
    let kind = if draw.kind % 2 == 1 && draw.kind > 1 { JointKind::Prismatic } else { JointKind::Revolute };
    let bounded = JointLimits { lower: -9.0, upper: 9.0, velocity: 3.0, ..JointLimits::NONE };
    let limits = if draw.kind == 1 { bounded } else { JointLimits::NONE };
    let motion = (draw.kind > 0).then_some(JointMotion { kind, axis: draw.axis, limits, mimic });
    let (name, parent, child) = (format!("joint_{i}"), link(place(draw.parent, i + 1)), link(i + 1));
    TreeJoint { name, parent, child, origin: draw.origin, motion }
}

/// 2 to 24 joints. The first one is revolute; the tool is on any link that a joint moves. The joints are in any order.
pub fn any_tree() -> impl Strategy<Value = AnyTree> {
    let draws = prop::collection::vec(any_draw(), 1..24);
    let motion = prop::collection::vec((-3.0..3.0_f64, -2.0..2.0_f64), 24);
    (draws, motion, any_transform(), 0..1000_usize, prop::bool::ANY).prop_map(
        |(mut draws, motion, offset, tip, is_reversed)| {
            let first = Draw { kind: 1, parent: 0, ..draws[0].clone() };
            draws.insert(0, first);
            let leads = |(i, draw): (usize, &Draw)| (1..4).contains(&draw.kind).then(|| format!("joint_{i}"));
            let leaders: Vec<String> = draws.iter().enumerate().filter_map(leads).collect();
            let mut joints: Vec<TreeJoint> =
                draws.iter().enumerate().map(|(i, draw)| joint(i, draw, &leaders)).collect();
            if is_reversed {
                joints.reverse();
            }
            let tips = vec![TreeTip { name: "tool".to_owned(), link: moved_link(&joints, tip), offset }];
            let description = TreeDescription { base: link(0), joints, tips };
            let robot = RobotModel::from_tree("any", "", &description).unwrap();
            let (joint_position, joint_velocity) = motion[..robot.joint_count()].iter().copied().unzip();
            AnyTree { description, robot, joint_position, joint_velocity }
        },
    )
}

/// Returns a link that a joint moves.
fn moved_link(joints: &[TreeJoint], thousandths: usize) -> String {
    let above: HashMap<&str, &TreeJoint> = joints.iter().map(|joint| (joint.child.as_str(), joint)).collect();
    let moves = |link: &str| std::iter::successors(above.get(link), |joint| above.get(joint.parent.as_str()));
    let mut moved: Vec<&str> =
        above.keys().copied().filter(|link| moves(link).any(|joint| joint.motion.is_some())).collect();
    moved.sort_unstable();
    moved[place(thousandths, moved.len())].to_owned()
}

impl AnyTree {
    /// Returns the poses of all links by name, products of the transforms of the description.
    pub fn poses(&self, joint_position: &[f64]) -> HashMap<String, IsometryMatrix3<f64>> {
        let moving = self.robot.moving_joints().iter();
        let positions: HashMap<&str, f64> =
            moving.map(|joint| (joint.name.as_str(), joint.position(joint_position))).collect();
        let mut poses = HashMap::from([(self.description.base.clone(), IsometryMatrix3::identity())]);
        while poses.len() <= self.description.joints.len() {
            for joint in &self.description.joints {
                if let Some(parent) = poses.get(&joint.parent) {
                    let motion = joint.motion.as_ref().map(|motion| along(motion, positions[joint.name.as_str()]));
                    let pose = parent * joint.origin * motion.unwrap_or_else(IsometryMatrix3::identity);
                    poses.insert(joint.child.clone(), pose);
                }
            }
        }
        poses
    }

    /// Returns a link by its place in thousandths.
    pub fn link(&self, thousandths: usize) -> LinkId {
        self.robot.link(&link(place(thousandths, self.robot.links().len()))).unwrap()
    }

    pub fn name(&self, link: LinkId) -> &str {
        &self.robot.links()[link.index()].name
    }

    /// Returns the joint position after a step of time along the joint velocity.
    pub fn moved(&self, step: f64) -> Vec<f64> {
        self.joint_position.iter().zip(&self.joint_velocity).map(|(q, v)| q + step * v).collect()
    }
}

/// Returns the motion of a joint as a transform.
fn along(motion: &JointMotion, position: f64) -> IsometryMatrix3<f64> {
    let axis = Unit::new_normalize(motion.axis);
    match motion.kind {
        JointKind::Revolute => {
            IsometryMatrix3::from_parts(Translation3::identity(), Rotation3::from_axis_angle(&axis, position))
        }
        JointKind::Prismatic => {
            IsometryMatrix3::from_parts((axis.into_inner() * position).into(), Rotation3::identity())
        }
    }
}
