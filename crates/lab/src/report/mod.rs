//! Turns recordings into metrics, tables, figures and a report as one HTML page.
//!
//! ```text
//! runs ─→ metrics ─→ table (rows) ──────────┐
//!      ├→ notes, claims, scenario_summary ──┼→ Report ─→ output: index.html, *.svg, *.png
//!      └→ paper_figures, comparison_figure ─┘
//! ```
//!
//! Runs come from the simulator, or from a directory of an earlier command ([`experiment::store`]).
//!
//! A figure is data ([`figure::Figure`]) until `drawing` turns it into SVG. The PNG file is rendered from this SVG, and the
//! page contains it, so all three show the same picture.

mod answer_gap;
mod axis;
pub mod checks;
pub mod claims;
pub mod clarabel_checks;
pub mod comparison;
pub mod comparison_figure;
mod decimation;
mod document;
mod drawing;
mod error;
pub mod experiment;
pub mod figure;
pub mod heat_map;
mod index;
mod legend;
pub mod logarithmic;
pub mod markdown;
mod markup;
pub mod notes;
mod output;
pub mod paper_figures;
mod png;
pub mod requests;
pub mod run;
pub mod run_figure;
pub mod scenario_summary;
mod sheet;
pub mod story;
pub mod table;
mod time_series;
mod typeface;

use claims::Claim;
use figure::Figure;
use run::Program;
use story::Story;
use table::Row;

pub use crate::{metrics, number};

pub use drawing::svg;
pub use error::Error;
pub use output::{Output, write, write_figures, write_heat_map};

/// The content of a page. In its texts, `F_x` prints x as an index.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// Title of the page.
    pub title: String,
    /// Claim, picture and meaning; the rest of the page is then collapsed.
    pub story: Option<Story>,
    /// Paragraphs before the table.
    pub introduction: Vec<String>,
    /// Rows of the table, from [`table::rows`].
    pub rows: Vec<Row>,
    /// How far the solvers are apart, and what Clarabel did.
    pub agreement: Vec<String>,
    /// Claims of the paper, with the measured results.
    pub claims: Vec<Claim>,
    /// One section per scenario.
    pub sections: Vec<Section>,
    /// File names of the recordings, in the directory of the page.
    pub traces: Vec<String>,
    /// The command that made the runs.
    pub command: String,
    /// The program that made the runs.
    pub program: Program,
}

/// The part of a report about one scenario.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Section {
    /// Name of the scenario.
    pub name: String,
    /// The scenario in a few sentences.
    pub summary: Vec<String>,
    /// The whole scenario as JSON.
    pub json: String,
    /// Remarks on the runs.
    pub notes: Vec<String>,
    /// Whether both methods of the paper move alike. Its figures are then collapsed.
    pub methods_coincide: bool,
    /// Rows of its runs.
    pub rows: Vec<Row>,
    /// Figures.
    pub figures: Vec<Figure>,
}
