//! A wrong sign and exchanged axes of a sensor, from the weight of its tool.
//!
//! A sensor whose axes are permuted or mirrored by Q measures f = f_b + m Q g in place of f_b + m g. There are 48 such Q; −1 is a wrong
//! sign. With the means removed, C = Σ (f − f̄)(g − ḡ)ᵀ and S = Σ |g − ḡ|², the sum of squares that Q leaves is
//!
//! Σ |f − f̄|² − t²/S, t = max(0, tr(Qᵀ C)),
//!
//! at the mass t/S ≥ 0. So (t_Q² − t_1²)/(S σ²) is the evidence for Q. If the readings are right, no linear map explains more than the
//! noise, and the evidence is below a χ² of 8 degrees of freedom.

use std::fmt;

use nalgebra::{Matrix3, Vector3};

use super::reading::PayloadReading;

/// Evidence that decides: a χ² of 8 degrees of freedom exceeds it three times in a million.
pub const AXES_EVIDENCE: f64 = 40.0;

const PERMUTATIONS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// What each axis of a sensor measures: an axis of the true ones, with a sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AxisAssignment {
    /// For x, y and z of the readings: the true axis, 0 to 2, and whether its sign is wrong.
    pub axes: [(usize, bool); 3],
}

impl AxisAssignment {
    /// Each axis measures itself.
    const RIGHT: Self = Self { axes: [(0, false), (1, false), (2, false)] };

    /// The sign of each axis is wrong.
    pub const WRONG_SIGN: Self = Self { axes: [(0, true), (1, true), (2, true)] };

    /// Returns all 48.
    fn all() -> impl Iterator<Item = Self> {
        let signs = |axes: [usize; 3]| {
            (0..8_usize).map(move |bits| Self { axes: std::array::from_fn(|i| (axes[i], bits >> i & 1 == 1)) })
        };
        PERMUTATIONS.into_iter().flat_map(signs)
    }

    /// Returns tr(Qᵀ C).
    fn trace(&self, correlation: &Matrix3<f64>) -> f64 {
        let entry = |(row, (axis, is_negative)): (usize, (usize, bool))| {
            if is_negative { -correlation[(row, axis)] } else { correlation[(row, axis)] }
        };
        self.axes.into_iter().enumerate().map(entry).sum()
    }
}

impl fmt::Display for AxisAssignment {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if *self == Self::WRONG_SIGN {
            return f.write_str(
                "the readings are those of a sensor with the other sign, or of an arm under the opposite gravity: the tool would have a negative \
                 weight. Check `gravity` first: that of the arm's base points down (an arm that hangs from the ceiling has +9.81 along z), \
                 and an accelerometer measures its opposite. If it is right, use the other `wrench_convention`",
            );
        }
        f.write_str("the readings are those of other axes: ")?;
        for (index, (name, (axis, is_negative))) in ["x", "y", "z"].into_iter().zip(self.axes).enumerate() {
            let (separator, sign) = (if index == 0 { "" } else { ", " }, if is_negative { "-" } else { "" });
            write!(f, "{separator}{name} measures {sign}{}", ["x", "y", "z"][axis])?;
        }
        f.write_str("; check the cable, the driver, and the orientation of the sensor in `pose`")
    }
}

/// How well readings fit to each assignment of the axes.
pub(super) struct AxesCheck {
    /// Evidence for the best other assignment over the right one.
    evidence: f64,
    best: AxisAssignment,
}

impl AxesCheck {
    /// Compares all assignments; `noise`: σ of a force, N.
    pub fn new(readings: &[PayloadReading], noise: f64) -> Self {
        let count = readings.len() as f64;
        let mean = |of: fn(&PayloadReading) -> Vector3<f64>| readings.iter().map(of).sum::<Vector3<f64>>() / count;
        let (mean_force, mean_gravity) = (mean(|reading| reading.force), mean(|reading| reading.gravity));
        let (mut correlation, mut spread) = (Matrix3::zeros(), 0.0);
        for reading in readings {
            let gravity = reading.gravity - mean_gravity;
            correlation += (reading.force - mean_force) * gravity.transpose();
            spread += gravity.norm_squared();
        }
        let explained = |axes: &AxisAssignment| axes.trace(&correlation).max(0.0).powi(2) / spread;
        let others = AxisAssignment::all().filter(|axes| *axes != AxisAssignment::RIGHT);
        let best = others.max_by(|a, b| explained(a).total_cmp(&explained(b))).unwrap_or(AxisAssignment::WRONG_SIGN);
        let evidence = (explained(&best) - explained(&AxisAssignment::RIGHT)) / (noise * noise);
        Self { evidence, best }
    }

    /// Returns the assignment that the readings prove in place of the right one.
    pub fn better(&self) -> Option<AxisAssignment> {
        (self.evidence > AXES_EVIDENCE).then_some(self.best)
    }

    /// Returns whether the readings rule out every other assignment.
    pub fn are_verified(&self) -> bool {
        self.evidence < -AXES_EVIDENCE
    }
}
