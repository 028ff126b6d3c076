//! Velocity limits that shrink towards the ends of the range.

/// A limit of the speed towards an end of the position range, which shrinks with the distance d from that end:
///
/// |q̇| ≤ max(0, √(2 D d) − o).
///
/// Makers of arms publish it as the speed from which their own brakes stop a joint in time. Towards the other end the
/// distance to that one counts. Units: rad/s² and rad/s for a revolute joint, m/s² and m/s for a prismatic one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityEnvelope {
    /// D, deceleration; infinite without an envelope.
    pub deceleration: f64,
    /// o, velocity offset, not negative.
    pub offset: f64,
}

impl VelocityEnvelope {
    /// No envelope.
    pub const NONE: Self = Self { deceleration: f64::INFINITY, offset: 0.0 };

    /// Returns whether there is an envelope.
    pub fn is_finite(&self) -> bool {
        self.deceleration.is_finite()
    }

    /// Returns the largest speed towards an end at `distance` (rad or m), rad/s or m/s; infinite without an envelope.
    pub fn max_speed(&self, distance: f64) -> f64 {
        if !self.is_finite() {
            return f64::INFINITY;
        }
        ((2.0 * self.deceleration * distance.max(0.0)).sqrt() - self.offset).max(0.0)
    }

    /// Returns o²/2D, the distance from an end at which the largest speed is zero, rad or m. A joint comes no nearer.
    pub fn margin(&self) -> f64 {
        self.offset * self.offset / (2.0 * self.deceleration)
    }

    /// Returns o/D, s.
    ///
    /// The envelope is v o/D + v²/2D ≤ d − o²/2D: a joint that moves on for this time and then brakes at D stops at the margin.
    pub fn reaction_time(&self) -> f64 {
        self.offset / self.deceleration
    }

    /// Returns whether D is positive, and o is finite and not negative.
    pub(crate) fn is_valid(&self) -> bool {
        self.deceleration > 0.0 && self.offset >= 0.0 && self.offset.is_finite()
    }

    /// Returns an envelope with which a joint keeps its own and that of a follower, which moves `ratio` times as far.
    pub(crate) fn restricted_by(&self, follower: &Self, ratio: f64) -> Self {
        Self {
            deceleration: self.deceleration.min(follower.deceleration / ratio),
            offset: self.offset.max(follower.offset / ratio),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_is_zero_at_the_margin_and_grows_with_the_distance() {
        let envelope = VelocityEnvelope { deceleration: 6.0, offset: 0.3 };
        assert_eq!((envelope.margin(), envelope.reaction_time()), (0.0075, 0.3 / 6.0));
        assert_eq!([0.0, -1.0, 0.0074].map(|distance| envelope.max_speed(distance)), [0.0; 3]);
        assert!((envelope.max_speed(0.75) - 2.7).abs() < 1e-15);
        // The same as a stop: v o/D + v²/2D = d − o²/2D.
        let speed = envelope.max_speed(0.2);
        let stop = speed * envelope.reaction_time() + speed * speed / (2.0 * envelope.deceleration);
        assert!((stop - (0.2 - envelope.margin())).abs() < 1e-15);
    }

    #[test]
    fn without_an_envelope_nothing_is_bounded() {
        let none = VelocityEnvelope::NONE;
        assert_eq!((none.max_speed(0.0), none.margin(), none.reaction_time()), (f64::INFINITY, 0.0, 0.0));
    }

    #[test]
    fn a_follower_that_moves_twice_as_far_halves_the_speed() {
        let follower = VelocityEnvelope { deceleration: 6.0, offset: 0.3 };
        let leader = VelocityEnvelope::NONE.restricted_by(&follower, 2.0);
        assert!((2.0 * leader.max_speed(0.1) - follower.max_speed(0.2)).abs() < 1e-15);
    }
}
