//! Forward kinematics along the chain of joints.
//!
//! The fixed transforms between the joints are factored once, when the model is built (see [`Factors`]). Their first
//! and last factors are rotations about z, the axis of a joint, so they are added to the rotations of the joints before
//! and after them. Per joint, there remain
//!
//! 1. a fixed shift and a fixed rotation about x (see [`Link`]),
//! 2. the motion of the joint: a rotation about z by q + offset, or, if the joint is prismatic, a shift along z by q and
//!    a rotation about z by the offset.
//!
//! This takes fewer multiplications than a product with a general transform. The loops process all joints before they
//! go on to the next step, so that the compiler can use vector instructions.

use nalgebra::IsometryMatrix3;

use super::angle::Angle;
use super::factors::Factors;
use super::joint_rotations::JointRotations;
use super::moving_frame::{Column, Link, MovingFrame};
use crate::{Joint, JointKind};

/// The axis of a joint in the base frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct JointAxis {
    /// Origin of the joint's frame before its motion, m.
    pub(super) origin: Column,
    /// Unit vector along the axis.
    pub(super) direction: Column,
}

impl JointAxis {
    /// The z axis of the base.
    pub(super) const BASE_Z: Self = Self { origin: [0.0; 4], direction: [0.0, 0.0, 1.0, 0.0] };
}

/// The fixed part of the forward kinematics of a robot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chain {
    /// The base frame, rotated about z.
    base: MovingFrame,
    /// The link before each joint and the joint's kind, n.
    links: Vec<(Link, JointKind)>,
    rotations: JointRotations,
    /// The link before the tool.
    tool_link: Link,
    /// The rotation of the tool about its z axis.
    tool_rotation: Angle,
    /// Indices of the prismatic joints.
    prismatic: Vec<usize>,
}

impl Chain {
    /// Factors the transforms of the joints and of the tool.
    ///
    /// `tool`: pose in the frame that the last joint moves, m.
    pub(crate) fn new(joints: &[Joint], tool: &IsometryMatrix3<f64>) -> Self {
        let factors: Vec<Factors> =
            joints.iter().map(|joint| &joint.placement).chain([tool]).map(Factors::from).collect();
        let offsets: Vec<Angle> =
            factors.iter().zip(&factors[1..]).map(|(factors, next)| factors.delta.plus(next.alpha)).collect();
        let link = |factors: &Factors| Link::new(factors.shift, factors.beta);
        let (first, tool) = (&factors[0], &factors[joints.len()]);
        let mut base = MovingFrame::BASE;
        base.turn(first.alpha.sine, first.alpha.cosine);
        Self {
            base,
            links: factors.iter().map(link).zip(joints.iter().map(|joint| joint.kind)).collect(),
            rotations: JointRotations::new(joints, &offsets),
            tool_link: link(tool),
            tool_rotation: tool.delta,
            prismatic: (0..joints.len()).filter(|&joint| joints[joint].kind.is_translation()).collect(),
        }
    }

    /// Returns the frame of the tool and overwrites `axes` (n) with the axes of the joints.
    ///
    /// `joint_position`: q, n; rad or m; finite. `scratch`: at least 2 n numbers, which are overwritten.
    // Not inlined: next to the code of the caller, the compiler finds fewer vector instructions (2076 instructions instead
    // of 1493 per update of Sawyer).
    #[inline(never)]
    pub(super) fn place(&self, joint_position: &[f64], axes: &mut [JointAxis], scratch: &mut [f64]) -> MovingFrame {
        let (sines, rest) = scratch.split_at_mut(joint_position.len());
        let cosines = &mut rest[..joint_position.len()];
        self.rotations.evaluate(joint_position, sines, cosines);
        let mut frame = self.base;
        let motions = joint_position.iter().zip(sines).zip(cosines);
        for (((link, kind), axis), ((q, sine), cosine)) in self.links.iter().zip(axes).zip(motions) {
            frame.follow(link);
            *axis = JointAxis { origin: frame.origin(), direction: frame.z() };
            if kind.is_translation() {
                frame.slide(*q);
            }
            frame.turn(*sine, *cosine);
        }
        frame.follow(&self.tool_link);
        frame.turn(self.tool_rotation.sine, self.tool_rotation.cosine);
        frame
    }

    /// Returns the indices of the prismatic joints.
    pub(super) fn prismatic(&self) -> &[usize] {
        &self.prismatic
    }
}
