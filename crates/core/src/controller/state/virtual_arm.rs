//! What a controller that looks ahead remembers of the virtual arm.

use super::line::Line;

/// The times ahead at which the virtual arm is known, s. Further targets change nothing that the joints can do now, and the
/// intervals grow because plans far ahead need not be exact.
pub const TIMES_AHEAD: [f64; 9] = [0.0, 0.016, 0.04, 0.08, 0.14, 0.22, 0.34, 0.5, 0.7];

/// The virtual arm: postures at which the tasks have reached their targets.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VirtualArm {
    /// q*(s), n, rad or m, for each of [`TIMES_AHEAD`], counted from the time at which the arm comes to rest.
    pub postures: Vec<Vec<f64>>,
    /// The line on which the arm moves to targets that have jumped; `None`: it is at its targets.
    pub line: Option<Line>,
}

impl VirtualArm {
    /// Returns an arm in a posture (n) at all times.
    pub(in crate::controller) fn at(posture: &[f64]) -> Self {
        Self { postures: vec![posture.to_vec(); TIMES_AHEAD.len()], line: None }
    }

    /// Returns whether the numbers are finite and fit n joints and the rows of the tasks with targets.
    pub(in crate::controller) fn is_valid(&self, n: usize, rows: usize) -> bool {
        let fits = |posture: &Vec<f64>| posture.len() == n && posture.iter().all(|entry| entry.is_finite());
        self.postures.len() == TIMES_AHEAD.len()
            && self.postures.iter().all(fits)
            && self.line.as_ref().is_none_or(|line| line.is_valid(n, rows))
    }

    /// Overwrites this arm without allocating.
    pub(in crate::controller) fn copy_from(&mut self, other: &Self) {
        self.postures.clone_from(&other.postures);
        self.line.clone_from(&other.line);
    }

    /// Puts the arm into its first posture at all times.
    pub(in crate::controller) fn stand_at_first(&mut self) {
        let (first, later) = self.postures.split_at_mut(1);
        later.iter_mut().for_each(|posture| posture.copy_from_slice(&first[0]));
    }

    /// Puts the arm into a posture (n) at all times.
    pub(in crate::controller) fn stand_at(&mut self, position: &[f64]) {
        self.line = None;
        for posture in &mut self.postures {
            posture.copy_from_slice(position);
        }
    }
}
