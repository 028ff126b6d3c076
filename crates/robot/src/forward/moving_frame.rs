//! A frame that moves along the joints of a limb.

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3, Vector3};

use super::angle::Angle;

/// Three numbers and a zero: two vector registers of two numbers or one of four.
pub type Column = [f64; 4];

/// A number for both halves of a vector register.
type Twice = [f64; 2];

/// A position and three axes in the base frame. Every motion is relative to the present axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingFrame {
    x: Column,
    y: Column,
    z: Column,
    /// m.
    origin: Column,
}

/// A shift, then a rotation about x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// m.
    shift: [Twice; 3],
    sine: Twice,
    cosine: Twice,
}

impl Step {
    /// `shift`: m, along the axes before the rotation.
    pub fn new(shift: [f64; 3], rotation: Angle) -> Self {
        Self { shift: shift.map(|entry| [entry; 2]), sine: [rotation.sine; 2], cosine: [rotation.cosine; 2] }
    }
}

impl MovingFrame {
    /// The base frame.
    pub const BASE: Self =
        Self { x: [1.0, 0.0, 0.0, 0.0], y: [0.0, 1.0, 0.0, 0.0], z: [0.0, 0.0, 1.0, 0.0], origin: [0.0; 4] };

    /// Moves the frame along a step.
    #[inline]
    pub fn follow(&mut self, Step { shift: [x, y, z], sine, cosine }: &Step) {
        for i in 0..4 {
            self.origin[i] += self.x[i] * x[i % 2] + self.y[i] * y[i % 2] + self.z[i] * z[i % 2];
        }
        (self.y, self.z) = rotate(&self.y, &self.z, sine, cosine);
    }

    /// Moves the origin along z, m.
    #[inline]
    pub fn slide(&mut self, distance: f64) {
        for i in 0..4 {
            self.origin[i] += self.z[i] * distance;
        }
    }

    /// Rotates the frame about z.
    #[inline]
    pub fn turn(&mut self, sine: f64, cosine: f64) {
        (self.x, self.y) = rotate(&self.x, &self.y, &[sine; 2], &[cosine; 2]);
    }

    /// Returns the frame with these x and z axes, which must be perpendicular unit vectors, at `origin`, m.
    pub fn of_axes(x: &Column, z: &Column, origin: &Column) -> Self {
        let [y1, y2, y3] = vector(z).cross(&vector(x)).into();
        Self { x: *x, y: [y1, y2, y3, 0.0], z: *z, origin: *origin }
    }

    /// Returns the x axis, a unit vector.
    #[inline]
    pub fn x(&self) -> Column {
        self.x
    }

    /// Returns the z axis, a unit vector.
    #[inline]
    pub fn z(&self) -> Column {
        self.z
    }

    /// Returns the origin, m.
    #[inline]
    pub fn origin(&self) -> Column {
        self.origin
    }

    /// Returns the frame as a pose, m.
    #[inline]
    pub fn pose(&self) -> IsometryMatrix3<f64> {
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
pub fn vector([x, y, z, _]: &Column) -> Vector3<f64> {
    Vector3::new(*x, *y, *z)
}
