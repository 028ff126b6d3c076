//! Forward kinematics along the limbs of a tree.
//!
//! The fixed transforms between the joints are factored once, when the model is built (see [`Factors`]). Their first
//! and last factors are rotations about z, the axis of a joint, so they are added to the rotations of the joints before
//! and after them. Per joint, there remain
//!
//! 1. a fixed shift and a fixed rotation about x (see [`Step`]),
//! 2. the motion of the joint: a rotation about z by q + offset, or, if the joint is prismatic, a shift along z by q and
//!    a rotation about z by the offset.
//!
//! This takes fewer multiplications than a product with a general transform. The loops process all joints before they
//! go on to the next step, so that the compiler can use vector instructions.
//!
//! A tree is a list of limbs, runs of joints without a branch. A limb begins where an earlier one ends, or at the base.
//! The step to the tool is the last one of its limb, so a serial arm is one limb from base to tool.

use nalgebra::IsometryMatrix3;

use super::angle::Angle;
use super::factors::Factors;
use super::joint_frame::JointFrame;
use super::joint_rotations::JointRotations;
use super::limb::{JointStep, Limb, Start, follow_limb};
use super::moving_frame::{MovingFrame, Step};
use crate::MovingJoint;

/// The fixed part of the forward kinematics of a robot with m moving joints.
#[derive(Debug, Clone, PartialEq)]
pub struct ForwardKinematics {
    /// Parents before children.
    limbs: Vec<Limb>,
    /// m.
    steps: Vec<JointStep>,
    rotations: JointRotations,
    /// The rotation about z that the next step of the limb begins with, one for each joint.
    next_turns: Vec<Angle>,
    /// The step from its joint to the tool.
    tool_step: Step,
    /// The rotation of the tool about its z axis.
    tool_rotation: Angle,
    tool_joint: usize,
    /// Whether the robot is one limb from base to tool, and each joint has its own coordinate.
    is_serial: bool,
    /// Indices of the prismatic joints.
    prismatic: Vec<usize>,
}

impl ForwardKinematics {
    /// Factors the transforms of the joints and of the tool.
    ///
    /// `joints`: depth first; `tool`: pose of the tool in the frame that `tool_joint` moves, m.
    pub fn new(joints: &[MovingJoint], tool_joint: usize, tool: &IsometryMatrix3<f64>) -> Self {
        let factors: Vec<Factors> = joints.iter().map(|joint| Factors::from(&joint.placement)).collect();
        let tool = Factors::from(tool);
        let is_run = |joint: usize| joint != tool_joint && has_one_child(joints, joint);
        let next_turn = |joint: usize| match joint {
            _ if joint == tool_joint => tool.alpha,
            _ if is_run(joint) => factors[joint + 1].alpha,
            _ => Angle::ZERO,
        };
        let next_turns: Vec<Angle> = (0..joints.len()).map(next_turn).collect();
        let offsets: Vec<Angle> =
            factors.iter().zip(&next_turns).map(|(factors, next)| factors.delta.plus(*next)).collect();
        let step = |factors: &Factors| Step::new(factors.shift, factors.beta);
        let limbs = limbs(joints, &factors, &next_turns, is_run);
        let is_serial = limbs.len() == 1 && joints.iter().all(|joint| !joint.is_mimic);
        Self {
            limbs,
            steps: factors.iter().map(step).zip(joints.iter().map(|joint| joint.kind)).collect(),
            rotations: JointRotations::new(joints.iter().map(|joint| joint.kind), &offsets),
            next_turns,
            tool_step: step(&tool),
            tool_rotation: tool.delta,
            tool_joint,
            is_serial,
            prismatic: (0..joints.len()).filter(|&joint| joints[joint].kind.is_translation()).collect(),
        }
    }

    /// Returns the frame of the tool of a serial arm and overwrites `frames` (n) with those of the joints.
    ///
    /// `joint_position`: q, n; rad or m; finite. `scratch`: at least 2 n numbers, which are overwritten.
    // Not inlined: next to the code of the caller, the compiler finds fewer vector instructions (2076 instructions instead
    // of 1493 per update of Sawyer).
    #[inline(never)]
    pub fn place_serial(&self, joint_position: &[f64], frames: &mut [JointFrame], scratch: &mut [f64]) -> MovingFrame {
        let (sines, rest) = scratch.split_at_mut(joint_position.len());
        let cosines = &mut rest[..joint_position.len()];
        self.rotations.evaluate(joint_position, sines, cosines);
        let start = match &self.limbs[0].start {
            Start::Base(frame) => *frame,
            Start::Joint { .. } => MovingFrame::BASE,
        };
        self.to_tool(follow_limb(start, &self.steps, joint_position, sines, cosines, frames))
    }

    /// Returns the frame of the tool and overwrites `frames` (m) with those of the joints.
    ///
    /// `position`: of the moving joints, m; rad or m; finite. `scratch`: at least 2 m numbers, which are overwritten.
    pub fn place_tree(&self, position: &[f64], frames: &mut [JointFrame], scratch: &mut [f64]) -> MovingFrame {
        let (sines, rest) = scratch.split_at_mut(position.len());
        let cosines = &mut rest[..position.len()];
        self.rotations.evaluate(position, sines, cosines);
        let mut tool = MovingFrame::BASE;
        for Limb { start, joints } in &self.limbs {
            let start = match start {
                Start::Base(frame) => *frame,
                Start::Joint { joint, turn } => frames[*joint].moved(self.slide(*joint, position[*joint]), *turn),
            };
            let run = joints.clone();
            let end = follow_limb(
                start,
                &self.steps[run.clone()],
                &position[run.clone()],
                &sines[run.clone()],
                &cosines[run.clone()],
                &mut frames[run],
            );
            if joints.end == self.tool_joint + 1 {
                tool = self.to_tool(end);
            }
        }
        tool
    }

    /// Goes from the frame behind the tool's joint to the tool.
    #[inline]
    fn to_tool(&self, mut frame: MovingFrame) -> MovingFrame {
        frame.follow(&self.tool_step);
        frame.turn(self.tool_rotation.sine, self.tool_rotation.cosine);
        frame
    }

    /// Returns how far a joint at `position` moves along its axis, m.
    fn slide(&self, joint: usize, position: f64) -> f64 {
        if self.steps[joint].1.is_translation() { position } else { 0.0 }
    }

    /// Returns the frame that a joint moves, in the base frame.
    ///
    /// `frame`: the placed frame of the joint; `position`: its position, rad or m.
    pub fn moved_frame(&self, joint: usize, frame: &JointFrame, position: f64) -> IsometryMatrix3<f64> {
        frame.moved(self.slide(joint, position), self.next_turns[joint].opposite()).pose()
    }

    /// Returns the indices of the prismatic joints.
    pub fn prismatic(&self) -> &[usize] {
        &self.prismatic
    }

    /// Returns whether the robot is one limb from base to tool, and each joint has its own coordinate.
    pub fn is_serial(&self) -> bool {
        self.is_serial
    }

    /// Returns the joint that carries the tool.
    pub fn tool_joint(&self) -> usize {
        self.tool_joint
    }
}

/// Splits the joints into limbs; a limb goes on behind a joint for which `is_run` holds.
fn limbs(
    joints: &[MovingJoint],
    factors: &[Factors],
    next_turns: &[Angle],
    is_run: impl Fn(usize) -> bool,
) -> Vec<Limb> {
    let mut limbs = Vec::new();
    let mut first = 0;
    for last in (0..joints.len()).filter(|joint| !is_run(*joint)) {
        let alpha = factors[first].alpha;
        let base = || {
            let mut base = MovingFrame::BASE;
            base.turn(alpha.sine, alpha.cosine);
            Start::Base(base)
        };
        let at = |joint: usize| Start::Joint { joint, turn: alpha.plus(next_turns[joint].opposite()) };
        let start = joints[first].parent.map_or_else(base, at);
        limbs.push(Limb { start, joints: first..last + 1 });
        first = last + 1;
    }
    limbs
}

/// Returns whether exactly one moving joint hangs on a joint. In depth-first order, it is the next one.
fn has_one_child(joints: &[MovingJoint], joint: usize) -> bool {
    joints[joint + 1..].iter().filter(|below| below.parent == Some(joint)).count() == 1
}
