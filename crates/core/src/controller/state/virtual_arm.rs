//! What a controller that looks ahead remembers of the virtual arm.

use super::line::Line;

/// The times ahead at which the virtual arm is known, s. Further targets change nothing that the joints can do now, and the
/// intervals grow because plans far ahead need not be exact.
pub const TIMES_AHEAD: [f64; 9] = [0.0, 0.016, 0.04, 0.08, 0.14, 0.22, 0.34, 0.5, 0.7];

/// The first of the times ahead at which the posture is not computed in every period: until then it moves on at its velocity.
pub(in crate::controller) const FIRST_LATER: usize = 3;

/// The virtual arm: postures at which the tasks have reached their targets.
#[derive(Debug, Clone, PartialEq)]
pub struct VirtualArm {
    /// q*(s), n, rad or m, for each of [`TIMES_AHEAD`], counted from the time at which the arm comes to rest.
    pub postures: Vec<Vec<f64>>,
    /// The next one of the later times whose posture is computed in the next period.
    pub next: usize,
    /// The smoothed acceleration of each streamed target, in the order of the streams, m/s² and rad/s².
    pub target_accelerations: Vec<Vec<f64>>,
    /// The line on which the arm moves to targets that have jumped; `None`: it is at its targets.
    pub line: Option<Line>,
}

impl VirtualArm {
    /// Returns an arm in a posture (n) at all times.
    pub(in crate::controller) fn at(posture: &[f64]) -> Self {
        Self {
            postures: vec![posture.to_vec(); TIMES_AHEAD.len()],
            next: FIRST_LATER,
            target_accelerations: Vec::new(),
            line: None,
        }
    }

    /// Returns whether the numbers are finite and fit n joints and the rows of the tasks with targets.
    pub(in crate::controller) fn is_valid(&self, n: usize, rows: usize) -> bool {
        let fits = |posture: &Vec<f64>| posture.len() == n && posture.iter().all(|entry| entry.is_finite());
        self.postures.len() == TIMES_AHEAD.len()
            && self.postures.iter().all(fits)
            && self.target_accelerations.iter().flatten().all(|entry| entry.is_finite())
            && (FIRST_LATER..TIMES_AHEAD.len()).contains(&self.next)
            && self.line.as_ref().is_none_or(|line| line.is_valid(n, rows))
    }

    /// Overwrites this arm without allocating.
    pub(in crate::controller) fn copy_from(&mut self, other: &Self) {
        self.postures.clone_from(&other.postures);
        self.next = other.next;
        self.target_accelerations.clone_from(&other.target_accelerations);
        self.line.clone_from(&other.line);
    }

    /// Moves all postures on by a time, s.
    pub(in crate::controller) fn advance(&mut self, time: f64) {
        let share = |k: usize| time / (TIMES_AHEAD[k + 1] - TIMES_AHEAD[k]);
        for j in 0..self.postures[0].len() {
            let mut way = 0.0;
            for k in 0..self.postures.len() {
                if let Some(after) = self.postures.get(k + 1) {
                    way = (after[j] - self.postures[k][j]) * share(k);
                }
                self.postures[k][j] += way;
            }
        }
    }

    /// Lets the arm rest from the posture before time `first` on.
    pub(in crate::controller) fn stand_from(&mut self, first: usize) {
        let (before, later) = self.postures.split_at_mut(first);
        for posture in later {
            posture.copy_from_slice(&before[first - 1]);
        }
    }

    /// Puts the arm into a posture (n) at all times.
    pub(in crate::controller) fn stand_at(&mut self, position: &[f64]) {
        (self.next, self.line) = (FIRST_LATER, None);
        for posture in &mut self.postures {
            posture.copy_from_slice(position);
        }
    }
}
