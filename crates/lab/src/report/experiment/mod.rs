//! Runs with what they were made of, and the page that comes of them.
//!
//! Every command that runs scenarios ends with an [`Experiment`]: [`store`] leaves it in a directory, from which
//! `revprio report` reads it again, and [`Experiment::report`] makes the page.

pub mod store;

use revprio_api::wire;
use serde::{Deserialize, Serialize};

use super::metrics::largest_difference;
use super::paper_figures::{Posture, of_posture};
use super::table::{self, Row};
use super::{Report, Section, claims, comparison_figure, notes, run_figure, scenario_words, silence};
use crate::simulator::Scenario;
use crate::simulator::recording::Recording;

/// Commands that differ less (rad/s) count as the same.
pub const COINCIDE: f64 = 1e-9;

/// One run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The scenario, with the method and solver of this run.
    pub scenario: Scenario,
    /// The arm.
    pub robot: wire::Robot,
    /// What happened.
    pub recording: Recording,
}

/// A question put to some runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// Title of the page.
    pub title: String,
    /// The question, in paragraphs.
    pub question: Vec<String>,
    /// The command that repeats it.
    pub command: String,
    /// What made it.
    pub program: Program,
    /// The runs; those of a scenario stand together.
    pub runs: Vec<Run>,
    /// What kept other runs from their end.
    pub failures: Vec<String>,
}

/// The program that made the runs.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// Its version.
    pub version: String,
    /// The commit of the checkout that it was run in; `None` outside of one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
}

impl Experiment {
    /// The page: table, claims of the paper, and a section per scenario.
    #[must_use]
    pub fn report(&self) -> Report {
        let rows = table::rows(&self.runs);
        let scenarios = self.runs.chunk_by(|a, b| a.recording.scenario == b.recording.scenario);
        Report {
            title: self.title.clone(),
            introduction: self.question.iter().chain(&self.failures).cloned().collect(),
            claims: claims::of_runs(&self.runs),
            sections: scenarios.map(|runs| section(runs, &rows)).collect(),
            rows,
            traces: Vec::new(),
            command: self.command.clone(),
            program: self.program.clone(),
        }
    }
}

/// What there is to say of the runs of one scenario.
fn section(runs: &[Run], rows: &[Row]) -> Section {
    let name = &runs[0].recording.scenario;
    let recordings: Vec<&Recording> = runs.iter().map(|run| &run.recording).collect();
    let mut figures: Vec<_> =
        [Posture::Nominal, Posture::Singular].iter().flat_map(|posture| of_posture(*posture, &recordings)).collect();
    figures.extend(match recordings[..] {
        [run] => Some(run_figure::of_run(run)),
        _ => comparison_figure::of_scenario(&recordings),
    });
    Section {
        name: name.clone(),
        words: scenario_words::of_scenario(&runs[0].scenario, &runs[0].robot),
        notes: notes::of_scenario(runs)
            .into_iter()
            .chain(recordings.iter().filter_map(|run| silence::of_run(run)))
            .collect(),
        rows: rows.iter().filter(|row| row.scenario == *name).cloned().collect(),
        figures,
    }
}

/// Runs of one scenario that command the same, together, in the order of the first of each.
#[must_use]
pub fn coinciding<'a>(runs: &[&'a Recording]) -> Vec<Vec<&'a Recording>> {
    let mut groups: Vec<Vec<&Recording>> = Vec::new();
    for run in runs {
        match groups.iter_mut().find(|group| largest_difference(group[0], run) <= COINCIDE) {
            Some(group) => group.push(run),
            None => groups.push(vec![run]),
        }
    }
    groups
}

#[cfg(test)]
impl Run {
    /// A run of `stiff_wall` with an arm without joints, for tests to fill in.
    pub(crate) fn of(recording: Recording) -> Self {
        let robot = wire::Robot {
            name: "none".to_owned(),
            description: String::new(),
            source: wire::RobotSource::Urdf,
            joints: Vec::new(),
        };
        Self { scenario: Scenario::find("stiff_wall").unwrap(), robot, recording }
    }
}

#[cfg(test)]
mod tests;
