//! The cascade with a summary and a record of the problems that it solves for one answer.

use revprio_problem::{Certificate, LevelReport, Part};

use crate::cascade::Cascade;
use crate::certified::Record;
use crate::hierarchy::{Hierarchy, Solution};

/// Solves the problems of one answer.
pub struct Recorder<'a> {
    cascade: &'a mut Cascade,
    record: Option<Record>,
    /// What Clarabel did at each level.
    pub levels: Vec<LevelReport>,
    /// Levels that Clarabel failed to solve.
    pub failures: u32,
    /// Whether a level is not solved surely.
    pub is_unsure: bool,
    /// Whether rounding may have decided a rank.
    pub rank_uncertain: bool,
}

impl<'a> Recorder<'a> {
    /// Starts an answer; `is_recorded`: with a certificate.
    pub fn new(cascade: &'a mut Cascade, is_recorded: bool) -> Self {
        let record = is_recorded.then(Record::default);
        Self { cascade, record, levels: Vec::new(), failures: 0, is_unsure: false, rank_uncertain: false }
    }

    /// Returns whether nobody waits for the answer any more.
    pub fn is_stopped(&self) -> bool {
        self.cascade.is_stopped()
    }

    /// Solves a problem and notes how sure its solution is.
    pub fn solve(&mut self, hierarchy: &Hierarchy) -> Solution {
        let solution = self.cascade.solve(hierarchy, self.record.is_some());
        self.levels.extend_from_slice(&solution.reports);
        self.failures += solution.failures;
        self.is_unsure |= solution.is_unsure;
        self.rank_uncertain |= solution.rank_uncertain;
        if let Some(record) = &mut self.record {
            record.push(hierarchy, &solution);
        }
        solution
    }

    /// Returns the largest relative residual of the optimality conditions of all levels.
    pub fn residual(&self) -> f64 {
        self.levels.iter().map(|level| level.residual).fold(0.0, f64::max)
    }

    /// Returns the index of the problem that was recorded last.
    pub fn last(&self) -> usize {
        self.record.as_ref().map_or(0, Record::last)
    }

    /// Sets the parts of the answer.
    pub fn set_answer(&mut self, parts: Vec<Part>) {
        if let Some(record) = &mut self.record {
            record.set_answer(parts);
        }
    }

    /// Returns the certificate, if the problems were recorded.
    pub fn into_certificate(self) -> Option<Box<Certificate>> {
        self.record.map(|record| Box::new(record.into_certificate()))
    }
}
