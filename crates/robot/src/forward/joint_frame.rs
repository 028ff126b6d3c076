//! The frame of a joint at a posture.

use super::angle::Angle;
use super::moving_frame::{Column, MovingFrame};

/// The axis of a joint, and the frame that it moves, in the base frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointFrame {
    /// Origin of the joint's frame before its motion, m.
    pub origin: Column,
    /// Unit vector along the axis.
    pub direction: Column,
    /// The x axis after the motion and the rotation about the axis that the next step of the limb begins with.
    pub x: Column,
}

impl JointFrame {
    /// The base frame.
    pub const BASE: Self = Self { origin: [0.0; 4], direction: [0.0, 0.0, 1.0, 0.0], x: [1.0, 0.0, 0.0, 0.0] };

    /// Returns the frame that the joint moves, rotated by `turn` about the axis; `slide`: motion along the axis, m.
    pub fn moved(&self, slide: f64, turn: Angle) -> MovingFrame {
        let mut frame = MovingFrame::of_axes(&self.x, &self.direction, &self.origin);
        frame.slide(slide);
        frame.turn(turn.sine, turn.cosine);
        frame
    }
}
