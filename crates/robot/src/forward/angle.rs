//! Angles as pairs of sine and cosine.

/// An angle, given by its sine and cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Angle {
    pub(super) sine: f64,
    pub(super) cosine: f64,
}

impl Angle {
    /// The angle zero.
    pub(super) const ZERO: Self = Self { sine: 0.0, cosine: 1.0 };

    /// Returns the angle from the x axis to the vector (x, y); zero for a vector shorter than 1e-100.
    pub(super) fn of_vector(x: f64, y: f64) -> Self {
        // `hypot` would not underflow, but its last bit depends on the machine.
        let square = x * x + y * y;
        if square < 1e-200 {
            return Self::ZERO;
        }
        let length = square.sqrt();
        Self { sine: y / length, cosine: x / length }
    }

    /// Returns the sum of two angles.
    #[inline]
    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            sine: self.sine * other.cosine + self.cosine * other.sine,
            cosine: self.cosine * other.cosine - self.sine * other.sine,
        }
    }

    /// Returns the components of the vector (x, y) along axes that are turned by this angle.
    pub(super) fn components(self, x: f64, y: f64) -> [f64; 2] {
        [self.cosine * x + self.sine * y, self.cosine * y - self.sine * x]
    }
}
