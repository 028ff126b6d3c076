//! The page is complete, escaped and self-contained.

use crate::report::claims::{Claim, Verdict};
use crate::report::drawing;
use crate::report::figure::Figure;
use crate::report::run::Program;
use crate::report::{Report, Section};

use super::*;

fn report() -> Report {
    let figure = Figure {
        name: "figure5_nominal".to_owned(),
        title: String::new(),
        caption: "Force F_d.".to_owned(),
        panels: vec![],
    };
    Report {
        title: "Runs <of today>".to_owned(),
        introduction: vec!["F_x & friends".to_owned()],
        claims: vec![Claim {
            place: "5.1",
            claim: "F_x is better",
            scenario: "force_tracking".to_owned(),
            measured: "3 < 4".to_owned(),
            verdict: Verdict::NoDifference,
        }],
        sections: vec![Section {
            name: "force_tracking".to_owned(),
            summary: vec!["A wall <of> stone.".to_owned()],
            json: r#"{"lag_s": 0.1}"#.to_owned(),
            notes: vec!["A note on `qp` and `closed_form`, F_x.".to_owned(), "One ` alone.".to_owned()],
            figures: vec![figure],
            ..Section::default()
        }],
        command: "revprio compare --out <dir>".to_owned(),
        program: Program { version: "1.2.3".to_owned(), commit: Some("abc-dirty".to_owned()) },
        ..Report::default()
    }
}

fn page(files: bool) -> String {
    let report = report();
    let drawn = |figure| Drawn { figure, drawing: drawing::drawing(figure).unwrap(), files };
    let figures: Vec<Vec<_>> =
        report.sections.iter().map(|section| section.figures.iter().map(drawn).collect()).collect();
    html(&report, None, &figures)
}

#[test]
fn texts_are_escaped_and_indexed() {
    let page = page(true);
    for part in [
        "<h1>Runs &lt;of today&gt;</h1>",
        "F<sub>x</sub> &amp; friends",
        "--out &lt;dir&gt;",
        "<code>force_tracking</code>",
        "A wall &lt;of&gt; stone.",
        "3 &lt; 4",
        "= no difference",
        "&quot;lag_s&quot;: 0.1",
        "revprio 1.2.3, commit abc-dirty.",
    ] {
        assert!(page.contains(part), "`{part}` is not in the page");
    }
}

#[test]
fn words_between_backticks_are_code() {
    let page = page(true);
    assert!(page.contains("A note on <code>qp</code> and <code>closed_form</code>, F<sub>x</sub>."), "{page}");
    assert!(page.contains("One ` alone."));
}

#[test]
fn numbers_of_files_and_claims_agree_with_their_words() {
    let mut report = report();
    report.traces = vec!["a.csv".to_owned()];
    let page = html(&report, None, &[vec![]]);
    assert!(page.contains("<summary>1 file</summary>") && page.contains("<summary>1 claim</summary>"), "{page}");
    report.traces.push("b.csv".to_owned());
    assert!(html(&report, None, &[vec![]]).contains("<summary>2 files</summary>"));
}

#[test]
fn agreement_of_the_solvers_is_on_the_page() {
    let mut report = report();
    assert!(!page(true).contains("How far the solvers are apart"));
    report.agreement = vec!["auto and closed_form: median 0".to_owned()];
    assert!(html(&report, None, &[vec![]]).contains("<li>auto and closed_form: median 0</li>"));
}

#[test]
fn figure_is_inline_with_its_caption_and_links_to_existing_files() {
    let page_with_files = page(true);
    assert!(page_with_files.contains("<svg ") && page_with_files.contains("Force F<sub>d</sub>."));
    assert!(page_with_files.contains(r#"href="figure5_nominal.png""#));
    assert!(!page(false).contains("figure5_nominal.png"));
}

#[test]
fn the_page_loads_nothing() {
    // The XML namespace of SVG is a name. Browsers do not load it.
    let page = page(true).replace("http://www.w3.org/2000/svg", "");
    for foreign in ["http://", "https://", "<link", "@import", "url(http", "src=", "fetch(", "import("] {
        assert!(!page.contains(foreign), "{foreign}");
    }
}
