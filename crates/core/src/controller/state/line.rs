//! The line on which the virtual arm moves to targets that have jumped.

use crate::linalg::all_finite;

/// Number of intervals at whose ends the posture on the line is known: less than 4 cm each on most lines.
pub const LINE_INTERVALS: usize = 16;

/// A line from the place of the tool to targets that have jumped. σ counts from 0 at the start to 1 at the targets.
#[derive(Debug, PartialEq, Default)]
pub struct Line {
    /// Displacement of all rows from their targets at σ = 0, along the lines of all tasks in their order, m and rad.
    pub offset: Vec<f64>,
    /// σ.
    pub progress: f64,
    /// σ̇, 1/s.
    pub speed: f64,
    /// Postures at σ = i/[`LINE_INTERVALS`] (n each), as far as they are known.
    pub postures: Vec<Vec<f64>>,
    /// The largest σ̇ there from which the joints can stop at the last one, 1/s.
    pub speeds: Vec<f64>,
    /// Whether the line leads out of reach, or through places at which the joints would almost stop. The law of the task then moves the
    /// arm as it does without looking ahead, until the targets change or are reached.
    pub is_given_up: bool,
}

impl Line {
    /// Starts a line at a posture (n) with a displacement from the targets (one entry per row).
    pub(in crate::controller) fn start(&mut self, posture: &[f64], offset: &[f64]) {
        (self.progress, self.speed, self.is_given_up) = (0.0, 0.0, false);
        self.offset.clear();
        self.offset.extend_from_slice(offset);
        self.postures.clear();
        self.postures.push(posture.to_vec());
        self.speeds.clear();
        self.speeds.push(0.0);
    }

    /// Returns whether the numbers are finite, in their ranges, and fit n joints and the rows of the tasks with targets.
    pub(in crate::controller) fn is_valid(&self, n: usize, rows: usize) -> bool {
        let known = self.postures.len();
        self.offset.len() == rows
            && all_finite(&self.offset)
            && (0.0..=1.0).contains(&self.progress)
            && self.speed >= 0.0
            && self.speed.is_finite()
            && (1..=LINE_INTERVALS + 1).contains(&known)
            && self.postures.iter().all(|posture| posture.len() == n && all_finite(posture))
            && self.speeds.len() == known
            && self.speeds.iter().all(|speed| *speed >= 0.0 && speed.is_finite())
    }
}

impl Clone for Line {
    fn clone(&self) -> Self {
        Self { offset: self.offset.clone(), postures: self.postures.clone(), speeds: self.speeds.clone(), ..*self }
    }

    // With the memory that is there.
    fn clone_from(&mut self, source: &Self) {
        (self.progress, self.speed, self.is_given_up) = (source.progress, source.speed, source.is_given_up);
        self.offset.clone_from(&source.offset);
        self.postures.clone_from(&source.postures);
        self.speeds.clone_from(&source.speeds);
    }
}
