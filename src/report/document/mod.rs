//! The page: one HTML file that carries its style and its figures and needs no script.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::Report;
use super::figure::Figure;
use super::index::{Piece, pieces};
use super::table::{COLUMNS, Column, Row};

const STYLE: &str = include_str!("style.css");

/// A figure and its SVG document.
pub struct Drawn<'a> {
    /// The figure.
    pub figure: &'a Figure,
    /// Its SVG.
    pub svg: String,
}

/// The page as HTML.
#[must_use]
pub fn html(report: &Report, figures: &[Drawn<'_>]) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (report.title) }
                style { (PreEscaped(STYLE)) }
            }
            body { main { (content(report, figures)) } }
        }
    };
    page.into_string()
}

fn content(report: &Report, figures: &[Drawn<'_>]) -> Markup {
    html! {
        h1 { (indexed(&report.title)) }
        @for paragraph in &report.introduction { p { (indexed(paragraph)) } }
        h2 { "Results" }
        (table(&report.rows))
        (meanings())
        @if !report.notes.is_empty() {
            h2 { "Notes" }
            @for note in &report.notes {
                h3 { code { (note.scenario) } }
                p { (indexed(&note.text)) }
            }
        }
        @if !figures.is_empty() {
            h2 { "Figures" }
            @for drawn in figures { (figure(drawn)) }
        }
        @if !report.traces.is_empty() {
            h2 { "Traces" }
            p { "One row per control period; beside this page." }
            ul { @for trace in &report.traces { li { a href=(trace) { (trace) } } } }
        }
        h2 { "Made by" }
        pre { code { (report.command) } }
    }
}

/// The table with the first column, the scenario, as a heading above its rows: on a phone the
/// numbers are then nearer.
fn table(rows: &[Row]) -> Markup {
    let width = COLUMNS.len() - 1;
    html! {
        div.scroll tabindex="0" role="region" aria-label="Results" {
            table {
                thead { tr { @for column in shown_columns() { (heading(column)) } } }
                @for group in rows.chunk_by(|a, b| a.scenario == b.scenario) {
                    tbody {
                        tr.group { th colspan=(width) scope="rowgroup" {
                            span.held { ((COLUMNS[0].cell)(&group[0])) }
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

fn shown_columns() -> impl Iterator<Item = &'static Column> {
    COLUMNS[1..].iter()
}

fn heading(column: &Column) -> Markup {
    html! {
        th scope="col" class=(alignment(column.is_number)) {
            (indexed(column.heading)) span.unit { (column.unit) }
        }
    }
}

fn cell(column: &Column, row: &Row) -> Markup {
    html! { td class=(alignment(column.is_number)) { ((column.cell)(row)) } }
}

const fn alignment(is_number: bool) -> &'static str {
    if is_number { "number" } else { "name" }
}

fn meanings() -> Markup {
    html! {
        dl.meanings {
            @for column in COLUMNS.iter().filter(|c| !c.meaning.is_empty()) {
                div { dt { (indexed(column.heading)) ": " } dd { (column.meaning) "." } }
            }
        }
    }
}

fn figure(drawn: &Drawn<'_>) -> Markup {
    let name = &drawn.figure.name;
    html! {
        figure id=(name) {
            div.card { (PreEscaped(&drawn.svg)) }
            figcaption {
                (indexed(&drawn.figure.caption)) " "
                span.files {
                    a href={ (name) ".svg" } { "SVG" } " · " a href={ (name) ".png" } { "PNG" }
                }
            }
        }
    }
}

fn indexed(text: &str) -> Markup {
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
