//! The page: one HTML file that contains its style, its figures and their script. It loads nothing.
//!
//! The figures are complete without the script, which adds zoom and values. A script of some 300 lines instead of a plotting
//! library keeps the page small, and the figures are the same SVG as in the files.

mod figure_data;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::claims::{Claim, Verdict};
use super::drawing::Drawing;
use super::figure::Figure;
use super::index::{Piece, pieces};
use super::table::{QUANTITIES, Quantity, Row, columns, side_by_side};
use super::{Report, Section};

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("figure.js");

/// A figure with its drawing.
pub struct Drawn<'a> {
    /// The figure.
    pub figure: &'a Figure,
    /// The drawing.
    pub drawing: Drawing,
    /// Whether the directory of the page has the figure as `.svg` and `.png`.
    pub files: bool,
}

/// Returns the page as HTML; `picture` is the one of the story, and `figures` are the figures of each section.
#[must_use]
pub fn html(report: &Report, picture: Option<&Drawn<'_>>, figures: &[Vec<Drawn<'_>>]) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (report.title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main { (content(report, picture, figures)) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    page.into_string()
}

fn content(report: &Report, picture: Option<&Drawn<'_>>, figures: &[Vec<Drawn<'_>>]) -> Markup {
    let story = report.story.as_ref().zip(picture);
    let is_open = story.is_none();
    html! {
        h1 { (indexed(&report.title)) }
        @if let Some((story, picture)) = story {
            p.lead { (indexed(&story.claim)) }
            (figure(picture))
            @for paragraph in &story.meaning { p { (indexed(paragraph)) } }
            details {
                summary { "How it was simulated and compared" }
                @for paragraph in &report.introduction { p { (indexed(paragraph)) } }
            }
        } @else {
            @for paragraph in &report.introduction { p { (indexed(paragraph)) } }
        }
        @if report.sections.len() > 1 { (contents(&report.sections, !report.claims.is_empty())) }
        h2 id="results" { "Results" }
        @if is_open { (results(report)) } @else { details { summary { "Table of all runs" } (results(report)) } }
        @if !report.claims.is_empty() { (claims(&report.claims, is_open)) }
        @for (section, figures) in report.sections.iter().zip(figures) { (scenario(section, figures, !report.claims.is_empty())) }
        @if !report.traces.is_empty() {
            h2 id="traces" { "Recordings" }
            details {
                summary { (counted(report.traces.len(), "file")) }
                p { "One row per control period. The files are in the directory of this page." }
                ul.files { @for trace in &report.traces { li { a href=(trace) { (trace) } } } }
            }
        }
        h2 id="made-by" { "Made by" }
        pre { code { (report.command) } }
        p { (program(report)) }
    }
}

/// The table of all runs, and how far the solvers are apart.
fn results(report: &Report) -> Markup {
    html! {
        (table(&report.rows))
        (meanings())
        @if !report.agreement.is_empty() {
            p {
                "How far the solvers are apart: the largest difference of a joint velocity in each control period, over all \
                 periods; and in how many of them it is above 1e-9, 1e-7 and 1e-5 rad/s."
            }
            ul.words { @for line in &report.agreement { li { (indexed(line)) } } }
        }
    }
}

/// Returns for example `1 file` or `2 files`.
fn counted(count: usize, word: &str) -> String {
    format!("{count} {word}{}", if count == 1 { "" } else { "s" })
}

fn program(report: &Report) -> String {
    let commit = report.program.commit.as_ref().map(|commit| format!(", commit {commit}")).unwrap_or_default();
    format!("revprio {}{commit}.", report.program.version)
}

fn contents(sections: &[Section], has_claims: bool) -> Markup {
    html! {
        nav aria-label="Contents" {
            a href="#results" { "Results" }
            @if has_claims { a href="#claims" { "Claims" } }
            @for section in sections { a href={ "#" (section.name) } { (section.name.replace('_', " ")) } }
            a href="#made-by" { "Made by" }
        }
    }
}

fn claims(claims: &[Claim], is_open: bool) -> Markup {
    html! {
        h2 id="claims" { "Claims of the paper and measured results" }
        details open[is_open] { summary { (counted(claims.len(), "claim")) }
        table.claims {
            thead { tr { th { "Paper" } th { "Claim (paraphrased)" } th { "Scenario" } th { "Measured" } th { "Result" } } }
            tbody {
                @for claim in claims {
                    tr {
                        td data-label="Paper" { (claim.place) }
                        td data-label="Claim" { (indexed(claim.claim)) }
                        td data-label="Scenario" { code { (claim.scenario) } }
                        td data-label="Measured" { (indexed(&claim.measured)) }
                        td.verdict data-label="Result" { (mark(claim.verdict)) " " (claim.verdict.as_str()) }
                    }
                }
            }
        } }
    }
}

const fn mark(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Confirmed => "✓",
        Verdict::NoDifference => "=",
        Verdict::NotConfirmed => "✗",
        Verdict::NotJudged => "–",
    }
}

/// Returns the part of a scenario. Beside claims of the paper, a comparison of runs stays closed.
fn scenario(section: &Section, figures: &[Drawn<'_>], has_claims: bool) -> Markup {
    html! {
        h2 id=(section.name) { code { (section.name) } }
        details {
            summary { "What is simulated" }
            ul.words { @for sentence in &section.summary { li { (indexed(sentence)) } } }
        }
        (scenario_file(section))
        @for note in &section.notes { p { (indexed(note)) } }
        @if section.rows.len() > 1 {
            details { summary { "All quantities side by side" } (side_by_side_table(&section.rows)) }
        }
        @let (compared, own): (Vec<_>, Vec<_>) = figures.iter().partition(|drawn| is_comparison(drawn.figure));
        @let is_alone = own.is_empty();
        @if !is_alone {
            details open[!section.methods_coincide] { summary { (figures_title(section)) } div.figures { @for drawn in own { (figure(drawn)) } } }
        }
        @if !compared.is_empty() {
            details open[is_alone && !has_claims] { summary { "All runs side by side" } div.figures { @for drawn in compared { (figure(drawn)) } } }
        }
    }
}

/// Returns the title of the figures. It says why they are collapsed.
fn figures_title(section: &Section) -> &'static str {
    if section.methods_coincide { "Figures: both methods move alike" } else { "Figures" }
}

/// Returns whether a figure compares all runs of a scenario. It is collapsed next to other figures, because it is long.
fn is_comparison(figure: &Figure) -> bool {
    figure.name.starts_with("comparison_")
}

/// All fields of a scenario, collapsed.
fn scenario_file(section: &Section) -> Markup {
    html! {
        @if !section.json.is_empty() {
            details {
                summary { "Scenario file" }
                p { "Save this as a .json file to run it with " code { "revprio simulate" } ". Units: m, rad, s, N, N·m, kg." }
                pre { code { (section.json) } }
            }
        }
    }
}

/// All quantities of a scenario, one column per run.
fn side_by_side_table(rows: &[Row]) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label="Side by side" {
            table.side-by-side {
                thead { tr {
                    th.name scope="col" { "side by side" }
                    td {}
                    @for row in rows { th.number scope="col" { (row.method_name()) span.unit { (row.solver_name()) } } }
                } }
                tbody {
                    @for line in side_by_side::lines(rows) {
                        tr {
                            th.name scope="row" { (indexed(&line.heading)) }
                            td.unit-cell { (line.unit) }
                            @for cell in &line.cells { td.number { (cell) } }
                        }
                    }
                }
            }
        }
    }
}

/// The table of all runs. The first column, the scenario, is a heading above its rows, so that the table fits on a phone.
fn table(rows: &[Row]) -> Markup {
    let width = shown_columns().count();
    html! {
        div.scroll tabindex="0" role="region" aria-label="Results" {
            table.results {
                thead { tr { @for column in shown_columns() { (heading(column)) } } }
                @for group in rows.chunk_by(|a, b| a.scenario == b.scenario) {
                    tbody {
                        tr.group { th colspan=(width) scope="rowgroup" {
                            span.held { (group[0].scenario) }
                        } }
                        @for row in group {
                            tr { @for column in shown_columns() { (cell(column, row)) } }
                        }
                    }
                }
            }
        }
    }
}

fn shown_columns() -> impl Iterator<Item = &'static Quantity> {
    columns().skip(1)
}

fn heading(column: &Quantity) -> Markup {
    html! {
        th scope="col" class=(alignment(column.is_number)) {
            (indexed(column.heading)) span.unit { (column.unit) }
        }
    }
}

/// A cell that wraps only after a comma.
fn cell(column: &Quantity, row: &Row) -> Markup {
    let text = (column.cell)(row);
    html! {
        td class=(alignment(column.is_number)) {
            @for (i, part) in text.split(", ").enumerate() {
                @if i > 0 { ", " }
                span.part { (part) }
            }
        }
    }
}

const fn alignment(is_number: bool) -> &'static str {
    if is_number { "number" } else { "name" }
}

fn meanings() -> Markup {
    html! {
        details {
            summary { "Meaning of the quantities" }
            dl.meanings {
                @for quantity in QUANTITIES.iter().filter(|quantity| !quantity.meaning.is_empty()) {
                    div { dt { (indexed(quantity.heading)) ": " } dd { (indexed(quantity.meaning)) "." } }
                }
            }
        }
    }
}

fn figure(drawn: &Drawn<'_>) -> Markup {
    let name = &drawn.figure.name;
    html! {
        figure id=(name) {
            div.card { (PreEscaped(&drawn.drawing.svg)) }
            figcaption {
                (indexed(&drawn.figure.caption)) " "
                @if drawn.files {
                    span.files { a href={ (name) ".svg" } { "SVG" } " · " a href={ (name) ".png" } { "PNG" } }
                }
            }
            script type="application/json" { (PreEscaped(figure_data::json(drawn.figure, &drawn.drawing.frames))) }
        }
    }
}

/// Text with indices, and with `code` between backticks.
fn indexed(text: &str) -> Markup {
    let parts: Vec<&str> = text.split('`').collect();
    // A single backtick has no partner.
    if parts.len().is_multiple_of(2) {
        return with_indices(text);
    }
    html! {
        @for (i, part) in parts.iter().enumerate() {
            @if i % 2 == 1 { code { (part) } } @else { (with_indices(part)) }
        }
    }
}

fn with_indices(text: &str) -> Markup {
    html! {
        @for piece in pieces(text) {
            @match piece {
                Piece::Line(line) => { (line) }
                Piece::Index(index) => { sub { (index) } }
            }
        }
    }
}

#[cfg(test)]
mod tests;
