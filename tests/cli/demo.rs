//! `revprio demo`: the experiments of the paper, checked by their recordings.

use std::path::{Path, PathBuf};

use crate::program::{Scratch, files, success};
use crate::trace::Trace;

const SCENARIOS: [&str; 4] = ["force_tracking", "force_tracking_singular", "stiff_wall", "stiff_wall_singular"];

/// Largest difference that counts as rounding, rad/s.
const COINCIDE: f64 = 1e-9;

/// The runs of a scenario.
struct Runs {
    reverse: Trace,
    cascade: Trace,
    automatic: Trace,
    classical: Trace,
}

impl Runs {
    fn read(out: &Path, scenario: &str) -> Self {
        let trace = |variant: &str| Trace::read(&out.join(format!("{scenario}-{variant}.csv")));
        Self {
            reverse: trace("reverse_priority-closed_form"),
            cascade: trace("reverse_priority-qp"),
            automatic: trace("reverse_priority-auto"),
            classical: trace("damped_least_squares-closed_form"),
        }
    }

    /// Asserts that reverse priority and the classical control give the same commands.
    fn assert_coincide(&self) {
        let difference = self.reverse.largest_difference(&self.classical);
        assert!(difference <= COINCIDE, "{difference}");
    }
}

fn assert_between(value: f64, low: f64, high: f64) {
    assert!((low..=high).contains(&value), "{value} is not between {low} and {high}");
}

fn force_tracking(runs: &Runs) {
    runs.assert_coincide();
    assert_eq!(runs.reverse.rows(), 20_000);
    assert_between(runs.reverse.rmse_fx(5.0), 0.1, 0.2);
}

fn force_tracking_singular(runs: &Runs) {
    assert_between(runs.reverse.rmse_fx(5.0), 0.1, 0.2);
    assert_between(runs.classical.rmse_fx(5.0), 1.2, 1.6);
}

fn stiff_wall(runs: &Runs) {
    runs.assert_coincide();
    let contacts = runs.reverse.contacts_s();
    assert_eq!(contacts.len(), 5);
    assert_between(contacts[0], 0.3455, 0.3465);
    assert_between(runs.reverse.peak_fx(), 242.0, 246.0);
    assert_between(runs.reverse.final_fx(), 30.0 - 1e-6, 30.0 + 1e-6);
}

fn stiff_wall_singular(runs: &Runs) {
    assert_between(runs.reverse.final_fx(), 30.0 - 1e-3, 30.0 + 1e-3);
    assert_between(runs.reverse.contacts_s()[0], 0.3, 0.4);
    assert!(runs.classical.contacts_s().is_empty());
    assert_eq!(runs.classical.peak_fx(), 0.0);
}

/// In every scenario the cascade is certified and equal to the closed form.
fn cascade_is_the_closed_form(runs: &Runs) {
    let difference = runs.cascade.largest_difference(&runs.reverse);
    assert!(difference <= COINCIDE, "{difference}");
    assert!(runs.cascade.words("status").iter().all(|status| status == "optimal"));
    assert!(runs.cascade.words("path").iter().all(|path| path == "qp"));
    // No limit is active in these scenarios: `auto` ends at the closed form, which other code computes.
    let difference = runs.automatic.largest_difference(&runs.reverse);
    assert!(difference <= COINCIDE, "{difference}");
    assert!(runs.automatic.words("path").iter().all(|path| path == "closed_form"));
}

fn files_are_complete(out: &Path, files: &[String]) {
    let with_ending = |ending: &str| -> Vec<PathBuf> {
        files.iter().map(|name| out.join(name)).filter(|path| path.extension().is_some_and(|e| e == ending)).collect()
    };
    let [traces, pages, drawings, images] = ["csv", "html", "svg", "png"].map(with_ending);
    assert_eq!((traces.len(), pages.len()), (16, 1));
    assert!(drawings.len() >= 4 && drawings.len() == images.len(), "{files:?}");
    let page = std::fs::read_to_string(&pages[0]).unwrap();
    assert!(page.contains("<svg") && page.contains("does not reach the wall"));
    assert!(!page.contains("src=\"http"), "the page must not load anything");
    for image in images {
        assert!(std::fs::read(&image).unwrap().starts_with(b"\x89PNG"), "{}", image.display());
    }
}

#[test]
fn demo_reproduces_the_experiments_of_the_paper() {
    let scratch = Scratch::new("demo");
    let table = success(&["demo", "--out", scratch.path().to_str().unwrap()]);
    for scenario in SCENARIOS {
        assert!(table.contains(scenario), "{scenario} is not in {table}");
    }
    assert!(table.contains("does not reach the wall"), "{table}");
    files_are_complete(scratch.path(), &files(scratch.path()));
    let checks = [force_tracking, force_tracking_singular, stiff_wall, stiff_wall_singular];
    for (scenario, check) in SCENARIOS.iter().zip(checks) {
        let runs = Runs::read(scratch.path(), scenario);
        cascade_is_the_closed_form(&runs);
        check(&runs);
    }
}
