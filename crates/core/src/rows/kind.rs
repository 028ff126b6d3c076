//! The kinds of rows, and how fast their streamed targets may move.

use crate::streaming::Bound;

/// The kind of a row. It decides the unit, and the bounds of a streamed target unless the task states its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum RowKind<'a> {
    /// A linear axis of the tool, m.
    Linear,
    /// An angular axis of the tool, rad.
    Angular,
    /// A joint.
    Joint(&'a revprio_robot::Joint),
    /// A constant row, of any unit.
    Raw,
}

/// Acceleration of joints without an acceleration limit, and of constant rows, as of linear axes.
const DEFAULT_ACCELERATION: f64 = 5.0;

impl RowKind<'_> {
    /// Returns the default bounds. Linear axes: 1 m/s and 5 m/s²; angular axes: 3 rad/s and 10 rad/s². A hand moves so when it works, not when it
    /// throws.
    pub fn bound(self) -> Bound {
        match self {
            Self::Linear => Bound { velocity: 1.0, acceleration: 5.0 },
            Self::Angular => Bound { velocity: 3.0, acceleration: 10.0 },
            Self::Joint(joint) => {
                let acceleration = Some(joint.limits.acceleration).filter(|value| value.is_finite() && *value > 0.0);
                let acceleration = acceleration.unwrap_or(DEFAULT_ACCELERATION);
                Bound { velocity: joint.limits.velocity, acceleration }
            }
            Self::Raw => Bound { velocity: f64::INFINITY, acceleration: DEFAULT_ACCELERATION },
        }
    }
}
