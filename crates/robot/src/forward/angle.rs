//! Angles as pairs of sine and cosine.

/// An angle, given by its sine and cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angle {
    pub sine: f64,
    pub cosine: f64,
}

impl Angle {
    /// The angle zero.
    pub const ZERO: Self = Self { sine: 0.0, cosine: 1.0 };

    /// Returns the angle from the x axis to the vector (x, y); zero for a vector shorter than 1e-100.
    pub fn of_vector(x: f64, y: f64) -> Self {
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
    pub fn plus(self, other: Self) -> Self {
        Self {
            sine: self.sine * other.cosine + self.cosine * other.sine,
            cosine: self.cosine * other.cosine - self.sine * other.sine,
        }
    }

    /// Returns the angle of the opposite rotation.
    pub fn opposite(self) -> Self {
        Self { sine: -self.sine, cosine: self.cosine }
    }

    /// Returns the components of the vector (x, y) along axes that are turned by this angle.
    pub fn components(self, x: f64, y: f64) -> [f64; 2] {
        [self.cosine * x + self.sine * y, self.cosine * y - self.sine * x]
    }
}
