//! What an answer says about distances.

use std::sync::Arc;

use nalgebra::Vector3;

/// Maximum number of pairs in a report.
pub const MAX_REPORTED: usize = 8;

/// Distances of a period and how they restrict the command.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CollisionReport {
    /// Distance of the nearest pair, m; infinite without pairs.
    pub least_distance_m: f64,
    /// The pairs nearest to each other, at most eight.
    pub pairs: Vec<PairReport>,
    /// The share of the box of the velocities, around full braking, in which the command lies: 1 if its stop is free as
    /// it was solved, 0 if the command is full braking.
    pub share: f64,
    /// The link and what it would come too near to if the box were not shrunk.
    pub held_by: Option<[Arc<str>; 2]>,
    /// The names of the rows, in order: `collision:` and the names of both shapes.
    pub row_names: Vec<Arc<str>>,
    /// Number of rows that could matter, and how many of them the solver got.
    pub rows: [usize; 2],
    /// Time that the stop takes, s.
    pub stop_s: f64,
    /// Whether the stop of the command, or that of a watchdog after it, comes nearer than d_min all the same: it did so before, something came,
    /// or the jerk limits permit nothing else.
    pub is_violated: bool,
}

impl CollisionReport {
    /// Copies another report, without allocating once both had as many pairs and rows.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        let Self { least_distance_m, pairs, share, held_by, row_names, rows, stop_s, is_violated } = self;
        pairs.clone_from(&other.pairs);
        row_names.clone_from(&other.row_names);
        held_by.clone_from(&other.held_by);
        (*least_distance_m, *share, *rows) = (other.least_distance_m, other.share, other.rows);
        (*stop_s, *is_violated) = (other.stop_s, other.is_violated);
    }
}

/// The distance of one pair.
#[derive(Debug, Clone, PartialEq)]
pub struct PairReport {
    /// Name of the link.
    pub link: Arc<str>,
    /// Name of the other link or of the obstacle.
    pub other: Arc<str>,
    /// Distance, m; negative: how far the shapes intersect.
    pub distance_m: f64,
    /// The nearest points on both surfaces, base frame, m.
    pub points: [Vector3<f64>; 2],
}
