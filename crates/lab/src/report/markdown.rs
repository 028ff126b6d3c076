//! A report in Markdown. It contains no measured times, so that it is the same on every machine.

use super::Report;
use super::table::side_by_side;

/// Returns tables and remarks of every scenario, the claims of the paper with their results, and the command.
#[must_use]
pub fn document(report: &Report) -> String {
    let scenarios = report.sections.iter().map(|section| {
        let notes: String = section.notes.iter().flat_map(|note| ["\n", note, "\n"]).collect();
        format!("## {}\n\n{}{notes}", section.name, side_by_side::markdown(&section.rows))
    });
    let mut parts: Vec<String> = scenarios.collect();
    if !report.claims.is_empty() {
        parts.push(claims(report));
    }
    parts.push(format!("```sh\n{}\n```\n", report.command));
    parts.join("\n")
}

fn claims(report: &Report) -> String {
    let mut table =
        "| paper | claim (paraphrased) | scenario | measured | result |\n|---|---|---|---|---|\n".to_owned();
    for claim in &report.claims {
        let cells = [claim.place, claim.claim, &claim.scenario, &claim.measured, claim.verdict.as_str()];
        table.extend(["| ", &cells.join(" | "), " |\n"]);
    }
    table
}
