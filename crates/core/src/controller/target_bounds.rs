//! What a task accepts as streamed targets, and their bounds.

use super::TaskConfig;
use crate::streaming::{Bound, Quantity};

/// Maximum velocity and acceleration of a streamed target on a row, unless the task states its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RowKind<'a> {
    /// A linear axis of the tool, m.
    Linear,
    /// An angular axis of the tool, rad.
    Angular,
    /// A joint.
    Joint(&'a revprio_robot::Joint),
    /// A constant row, of any unit.
    Raw,
}

/// Acceleration of joints without an acceleration limit, and of constant rows.
const DEFAULT_ACCELERATION: f64 = 5.0;

impl RowKind<'_> {
    /// Linear axes: 1 m/s and 5 m/s²; angular axes: 3 rad/s and 10 rad/s². A hand moves so when it works, not when it
    /// throws.
    fn bound(self) -> Bound {
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

impl TaskConfig {
    /// Returns whether streamed targets of this task can be of a quantity.
    pub fn accepts(&self, quantity: Quantity) -> bool {
        match quantity {
            Quantity::Pose | Quantity::JointPosition => {
                self.law.follows_position() && self.rows.position_quantity() == Some(quantity)
            }
            Quantity::Velocity => self.law.follows_velocity(),
            Quantity::Force => self.law.follows_force(),
        }
    }

    /// Returns what streamed targets of this task can be.
    pub fn quantities(&self) -> Vec<Quantity> {
        Quantity::ALL.into_iter().filter(|quantity| self.accepts(*quantity)).collect()
    }

    /// Returns the bound of an entry of a streamed target: a row, or the first entry of a part of a pose. A part of a pose
    /// has the smallest bounds of its rows.
    pub(super) fn bound(&self, quantity: Quantity, entry: usize, robot: &revprio_robot::RobotModel) -> Bound {
        let of_row = |row: usize| {
            let default = self.rows.kind(row, robot).bound();
            let own = |values: &Option<Vec<f64>>, default: f64| values.as_ref().map_or(default, |values| values[row]);
            Bound {
                velocity: own(&self.streaming.max_velocity, default.velocity),
                acceleration: own(&self.streaming.max_acceleration, default.acceleration),
            }
        };
        if quantity != Quantity::Pose {
            return of_row(entry);
        }
        let kind = if entry < 3 { RowKind::Linear } else { RowKind::Angular };
        let rows = (0..self.rows.len()).filter(|&row| self.rows.kind(row, robot) == kind).map(of_row);
        let smallest = rows.reduce(|a, b| Bound {
            velocity: a.velocity.min(b.velocity),
            acceleration: a.acceleration.min(b.acceleration),
        });
        smallest.unwrap_or_else(|| kind.bound())
    }
}
