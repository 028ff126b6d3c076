//! The page: complete, escaped, and on its own.

use crate::report::figure::Figure;
use crate::report::{Note, Report};

use super::*;

fn report() -> Report {
    Report {
        title: "Runs <of today>".to_owned(),
        introduction: vec!["F_x & friends".to_owned()],
        rows: vec![],
        notes: vec![Note { scenario: "force_tracking".to_owned(), text: "A note.".to_owned() }],
        figures: vec![Figure {
            name: "figure5_nominal".to_owned(),
            title: String::new(),
            caption: "Force F_d.".to_owned(),
            panels: vec![],
        }],
        traces: vec![],
        command: "revprio report --out <dir>".to_owned(),
    }
}

fn page() -> String {
    let report = report();
    let figures: Vec<_> = report.figures.iter().map(|figure| Drawn { figure, svg: "<svg></svg>".to_owned() }).collect();
    html(&report, &figures)
}

#[test]
fn texts_are_escaped_and_indexed() {
    let page = page();
    assert!(page.contains("<h1>Runs &lt;of today&gt;</h1>"));
    assert!(page.contains("F<sub>x</sub> &amp; friends"));
    assert!(page.contains("--out &lt;dir&gt;"));
    assert!(page.contains("<code>force_tracking</code>"));
}

#[test]
fn a_figure_is_inline_with_its_caption_and_its_files() {
    let page = page();
    assert!(page.contains("<svg></svg>"));
    assert!(page.contains("Force F<sub>d</sub>."));
    assert!(page.contains(r#"href="figure5_nominal.png""#));
}

#[test]
fn the_page_needs_neither_network_nor_script() {
    let page = page();
    for foreign in ["http://", "https://", "<script", "<link", "@import", "url("] {
        assert!(!page.contains(foreign), "{foreign}");
    }
}
