//! A frame that moves along the chain of joints.

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3, Vector3};

use super::angle::Angle;

/// Three numbers and a zero: two vector registers of two numbers or one of four.
pub(super) type Column = [f64; 4];

/// A number for both halves of a vector register.
type Twice = [f64; 2];

/// A position and three axes in the base frame. Every motion is relative to the present axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MovingFrame {
    x: Column,
    y: Column,
    z: Column,
    /// m.
    origin: Column,
}

/// A shift, then a rotation about x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Link {
    /// m.
    shift: [Twice; 3],
    sine: Twice,
    cosine: Twice,
}

impl Link {
    /// `shift`: m, along the axes before the rotation.
    pub(super) fn new(shift: [f64; 3], rotation: Angle) -> Self {
        Self { shift: shift.map(|entry| [entry; 2]), sine: [rotation.sine; 2], cosine: [rotation.cosine; 2] }
    }
}

impl MovingFrame {
    /// The base frame.
    pub(super) const BASE: Self =
        Self { x: [1.0, 0.0, 0.0, 0.0], y: [0.0, 1.0, 0.0, 0.0], z: [0.0, 0.0, 1.0, 0.0], origin: [0.0; 4] };

    /// Moves the frame along a link.
    #[inline]
    pub(super) fn follow(&mut self, Link { shift: [x, y, z], sine, cosine }: &Link) {
        for i in 0..4 {
            self.origin[i] += self.x[i] * x[i % 2] + self.y[i] * y[i % 2] + self.z[i] * z[i % 2];
        }
        (self.y, self.z) = rotate(&self.y, &self.z, sine, cosine);
    }

    /// Moves the origin along z, m.
    #[inline]
    pub(super) fn slide(&mut self, distance: f64) {
        for i in 0..4 {
            self.origin[i] += self.z[i] * distance;
        }
    }

    /// Rotates the frame about z.
    #[inline]
    pub(super) fn turn(&mut self, sine: f64, cosine: f64) {
        (self.x, self.y) = rotate(&self.x, &self.y, &[sine; 2], &[cosine; 2]);
    }

    /// Returns the z axis, a unit vector.
    #[inline]
    pub(super) fn z(&self) -> Column {
        self.z
    }

    /// Returns the origin, m.
    #[inline]
    pub(super) fn origin(&self) -> Column {
        self.origin
    }

    /// Returns the frame as a pose, m.
    #[inline]
    pub(super) fn pose(&self) -> IsometryMatrix3<f64> {
        let rotation = Matrix3::from_columns(&[vector(&self.x), vector(&self.y), vector(&self.z)]);
        IsometryMatrix3::from_parts(
            Translation3::from(vector(&self.origin)),
            Rotation3::from_matrix_unchecked(rotation),
        )
    }
}

/// Returns two perpendicular axes after a rotation from the first one towards the second one.
#[inline]
fn rotate(first: &Column, second: &Column, sine: &Twice, cosine: &Twice) -> (Column, Column) {
    (
        std::array::from_fn(|i| first[i] * cosine[i % 2] + second[i] * sine[i % 2]),
        std::array::from_fn(|i| second[i] * cosine[i % 2] - first[i] * sine[i % 2]),
    )
}

/// Returns the three numbers of a column.
#[inline]
pub(super) fn vector([x, y, z, _]: &Column) -> Vector3<f64> {
    Vector3::new(*x, *y, *z)
}
