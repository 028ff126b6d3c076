//! Kinds of motion of a joint.

#![allow(non_snake_case)]

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3};
use serde::Deserialize;

/// Kind of motion of a joint, about or along the z axis of its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// Rotation about z; position in rad.
    Revolute,
    /// Translation along z; position in m.
    Prismatic,
}

impl JointKind {
    /// Returns the unit of the joint position.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Revolute => "rad",
            Self::Prismatic => "m",
        }
    }

    /// Returns whether the joint moves along its axis rather than about it.
    pub fn is_translation(self) -> bool {
        self == Self::Prismatic
    }

    /// Returns the kind of a URDF joint type, `None` for a type that has no single position.
    pub(crate) fn from_urdf(joint_type: &str) -> Option<Self> {
        match joint_type {
            "revolute" | "continuous" => Some(Self::Revolute),
            "prismatic" => Some(Self::Prismatic),
            _ => None,
        }
    }

    /// Moves a joint's frame by its position q (rad or m). The third column of its rotation stays.
    pub(crate) fn move_along(self, frame: &mut IsometryMatrix3<f64>, q: f64) {
        let R = frame.rotation.matrix();
        match self {
            Self::Revolute => {
                let (sine, cosine) = q.sin_cos();
                let (x, y) = (R.column(0).into_owned(), R.column(1).into_owned());
                let turned = Matrix3::from_columns(&[x * cosine + y * sine, y * cosine - x * sine, R.column(2).into()]);
                frame.rotation = Rotation3::from_matrix_unchecked(turned);
            }
            Self::Prismatic => {
                let z = R.column(2).into_owned();
                frame.translation.vector += z * q;
            }
        }
    }
}
