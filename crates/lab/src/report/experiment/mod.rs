//! A set of runs, and its report.
//!
//! Every command that runs scenarios makes an [`Experiment`]. [`store`] writes it to a directory, from which
//! `revprio report` reads it again. [`Experiment::report`] makes the report.

pub mod store;

use revprio_api::wire::Solver;

use super::comparison::MethodPair;
use super::paper_figures::{Posture, of_posture};
use super::run::{Program, Run};
use super::table::{self, Row};
use super::{
    Report, Section, answer_gap, checks, claims, clarabel_checks, comparison_figure, notes, run_figure,
    scenario_summary, story,
};
use crate::simulator::recording::Recording;

/// A set of runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// Title of the page.
    pub title: String,
    /// Paragraphs that introduce it.
    pub question: Vec<String>,
    /// The command that repeats it.
    pub command: String,
    /// The program that made the runs.
    pub program: Program,
    /// The runs, grouped by scenario.
    pub runs: Vec<Run>,
    /// Errors of runs that did not finish.
    pub failures: Vec<String>,
}

impl Experiment {
    /// Returns the report: table, claims of the paper, and a section per scenario.
    #[must_use]
    pub fn report(&self) -> Report {
        let rows = table::rows(&self.runs);
        let scenarios = self.runs.chunk_by(|a, b| a.recording.scenario == b.recording.scenario);
        Report {
            title: self.title.clone(),
            // A failure stands before everything else.
            story: if self.failures.is_empty() { story::of_runs(&self.runs) } else { None },
            introduction: self.question.iter().chain(&self.failures).cloned().collect(),
            agreement: agreement(&self.runs),
            claims: claims::of_runs(&self.runs),
            sections: scenarios.map(|runs| section(runs, &rows)).collect(),
            rows,
            traces: Vec::new(),
            command: self.command.clone(),
            program: self.program.clone(),
        }
    }
}

/// Returns how far `auto` is from the other solvers, and what Clarabel did, one text per fact.
#[must_use]
pub fn agreement(runs: &[Run]) -> Vec<String> {
    let solvers = [Solver::Qp, Solver::ClosedForm].into_iter().filter_map(|solver| checks::agreement(runs, solver));
    let clarabel = clarabel_checks::of_all(runs).map(|levels| clarabel_checks::lines(&levels).join("; "));
    solvers.chain(clarabel).collect()
}

fn section(runs: &[Run], rows: &[Row]) -> Section {
    let name = &runs[0].recording.scenario;
    let recordings: Vec<&Recording> = runs.iter().map(|run| &run.recording).collect();
    let of_paper: Vec<&Recording> = runs.iter().filter(|run| run.is_built_in()).map(|run| &run.recording).collect();
    let mut figures: Vec<_> =
        [Posture::Nominal, Posture::Singular].iter().flat_map(|posture| of_posture(*posture, &of_paper)).collect();
    figures.extend(match recordings[..] {
        [run] => Some(run_figure::of_run(run)),
        _ => comparison_figure::of_scenario(&recordings),
    });
    Section {
        name: name.clone(),
        summary: scenario_summary::sentences(&runs[0].scenario, &runs[0].robot),
        json: serde_json::to_string_pretty(&runs[0].scenario).unwrap_or_default(),
        notes: notes::of_scenario(runs)
            .into_iter()
            .chain(recordings.iter().filter_map(|run| answer_gap::of_run(run)))
            .collect(),
        methods_coincide: MethodPair::from_runs(runs).is_some_and(|pair| pair.coincide()),
        rows: rows.iter().filter(|row| row.scenario == *name).cloned().collect(),
        figures,
    }
}

#[cfg(test)]
mod tests;
