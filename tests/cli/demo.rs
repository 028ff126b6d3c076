//! `revprio demo`: the experiments of the paper, checked by their recordings.

use std::path::Path;

use crate::program::{Scratch, files, program, success};
use crate::trace::Trace;

const SCENARIOS: [&str; 4] = ["force_tracking", "force_tracking_singular", "stiff_wall", "stiff_wall_singular"];

/// Largest difference that counts as rounding, rad/s.
const COINCIDE: f64 = 1e-9;

/// The recordings of a scenario.
struct Runs {
    reverse: Trace,
    /// `None`: the classical control moves as reverse priority does.
    classical: Option<Trace>,
}

impl Runs {
    fn read(out: &Path, scenario: &str) -> Self {
        let trace = |method: &str| out.join(format!("{scenario}-{method}-closed_form.csv"));
        let classical = trace("damped_least_squares");
        let classical = classical.exists().then(|| Trace::read(&classical));
        Self { reverse: Trace::read(&trace("reverse_priority")), classical }
    }
}

fn assert_between(value: f64, low: f64, high: f64) {
    assert!((low..=high).contains(&value), "{value} is not between {low} and {high}");
}

fn force_tracking(runs: &Runs) {
    assert!(runs.classical.is_none());
    assert_eq!(runs.reverse.rows(), 20_000);
    assert_between(runs.reverse.rmse_fx(5.0), 0.1, 0.2);
}

fn force_tracking_singular(runs: &Runs) {
    assert_between(runs.reverse.rmse_fx(5.0), 0.1, 0.2);
    assert_between(runs.classical.as_ref().unwrap().rmse_fx(5.0), 1.2, 1.6);
}

fn stiff_wall(runs: &Runs) {
    assert!(runs.classical.is_none());
    let contacts = runs.reverse.contacts_s();
    assert_eq!(contacts.len(), 5);
    assert_between(contacts[0], 0.3455, 0.3465);
    assert_between(runs.reverse.peak_fx(), 242.0, 246.0);
    assert_between(runs.reverse.final_fx(), 30.0 - 1e-6, 30.0 + 1e-6);
}

fn stiff_wall_singular(runs: &Runs) {
    assert_between(runs.reverse.final_fx(), 30.0 - 1e-3, 30.0 + 1e-3);
    assert_between(runs.reverse.contacts_s()[0], 0.3, 0.4);
    let classical = runs.classical.as_ref().unwrap();
    assert!(classical.contacts_s().is_empty());
    assert_eq!(classical.peak_fx(), 0.0);
}

/// Returns the numbers of a method in the table, one line per scenario; a dash is `None`.
fn lines(table: &str, method: &str) -> Vec<Vec<Option<f64>>> {
    let lines = table.lines().filter_map(|line| line.trim_start().strip_prefix(method));
    lines.map(|line| line.split_whitespace().map(|cell| cell.parse().ok()).collect()).collect()
}

/// In every scenario the solvers give the same commands; the last scenario has active limits, and no closed form.
fn solvers_agree(table: &str, page: &str) {
    let differences: Vec<f64> = lines(table, "reverse priority").iter().map(|cells| cells[4].unwrap()).collect();
    assert_eq!(differences.len(), SCENARIOS.len() + 1);
    assert!(differences.iter().all(|difference| *difference <= COINCIDE), "{differences:?}");
    for periods in ["20000 of 20000", "5000 of 5000"] {
        assert!(page.contains(&format!("certified optimal in {periods} periods")), "{periods}");
    }
}

/// In more than half of the periods of one scenario a limit is active.
fn limits_act(table: &str, out: &Path) {
    assert_eq!(table.matches("a limit acts in").count(), 1, "{table}");
    assert!(table.contains("stiff_wall_limits: a limit acts in 6"), "{table}");
    let paths = Trace::read(&out.join("stiff_wall_limits-reverse_priority-auto.csv")).words("path");
    let active = paths.iter().filter(|path| *path == "active_set").count();
    assert!(paths.len() == 2000 && active > 1000, "{active} of {}", paths.len());
}

/// The table has the requests that the servers counted: one per period and run, and two that open and close each session.
fn every_period_was_a_request(table: &str) {
    let at_limits = 2.0 * 2002.0;
    for (method, runs, more) in [("reverse priority", 3.0, Some(at_limits)), ("damped least squares", 1.0, None)] {
        let lines = lines(table, method);
        let requests: Vec<f64> = lines.iter().map(|cells| cells[5].expect("no requests")).collect();
        let periods = [20_000.0, 20_000.0, 5000.0, 5000.0];
        let expected: Vec<f64> = periods.iter().map(|periods| runs * (periods + 2.0)).chain(more).collect();
        assert_eq!(requests, expected);
        assert!(lines.iter().all(|cells| 0.0 < cells[6].unwrap() && cells[6] <= cells[7]), "{table}");
    }
}

/// The law `contact` meets the same wall once and never presses with more than a few newtons above the target.
fn contact_law_settles_without_a_peak(out: &Path) {
    let trace = Trace::read(&out.join("stiff_wall_contact-reverse_priority-auto.csv"));
    assert_eq!(trace.contacts_s().len(), 1);
    assert_between(trace.peak_fx(), 29.0, 36.0);
    assert_between(trace.final_fx(), 29.0, 31.0);
}

/// Without a terminal, standard error has a line when a run starts and when it ends.
fn progress_is_printed(lines: &str) {
    for scenario in SCENARIOS {
        for solver in ["closed_form", "qp", "auto"] {
            for event in ["started", "finished"] {
                let line = format!("{scenario}, reverse_priority, {solver}: {event}");
                assert!(lines.lines().any(|printed| printed == line), "no `{line}` in {lines}");
            }
        }
    }
}

#[test]
fn demo_reproduces_the_experiments_of_the_paper() {
    let scratch = Scratch::new("demo");
    let out = scratch.path();
    let demo = program(&["demo", "--traces", "csv,parquet", "--out", out.to_str().unwrap()]).output().unwrap();
    let [table, progress] = [demo.stdout, demo.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(demo.status.success(), "{progress}");
    progress_is_printed(&progress);
    // The last line is the path of the page, of any length.
    let (lines, page) = table.trim_end().rsplit_once('\n').unwrap();
    // 100 columns with times of up to five digits. No time decides this test.
    // With the path and the prompt of the shell, a terminal of 24 lines shows all.
    assert!(lines.lines().count() <= 22 && lines.lines().all(|line| line.chars().count() <= 105), "{table}");
    assert_eq!(std::path::Path::new(page), out.join("index.html"));
    let files = files(out);
    let with_ending = |ending: &str| files.iter().filter(|name| name.ends_with(ending)).collect::<Vec<_>>();
    // From the nominal posture both methods move alike, and solvers do everywhere. One run is at limits, and one has another law.
    assert_eq!((with_ending("csv").len(), with_ending("parquet").len()), (8, 8), "{files:?}");
    contact_law_settles_without_a_peak(out);
    assert!(with_ending("svg").len() >= 4, "{files:?}");
    let defaults = ["parquet", "svg", "html", "json"].map(with_ending).concat();
    let bytes: u64 = defaults.iter().map(|name| out.join(name).metadata().unwrap().len()).sum();
    assert!(bytes < 20_000_000, "{bytes} bytes");
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("<svg") && page.contains("does not reach the wall"));
    assert!(
        page.contains("Under the classical control the same arm does not reach it in 5 s.")
            && page.contains("The peak of 244 N")
    );
    assert!(!page.contains("src=\"http"), "the page must not load anything");
    solvers_agree(&table, &page);
    limits_act(&table, out);
    assert!(page.contains("✓ confirmed") && !page.contains("not confirmed") && !page.contains("not judged"));
    assert!(table.contains("Clarabel: ") && table.contains("before it, 0 % are above 1e-6"), "{table}");
    every_period_was_a_request(&table);
    assert!(page.contains("to the service over HTTP") && page.contains("round trip") && page.contains("20002"));
    let checks = [force_tracking, force_tracking_singular, stiff_wall, stiff_wall_singular];
    for (scenario, check) in SCENARIOS.iter().zip(checks) {
        check(&Runs::read(out, scenario));
    }
}

/// The output of the program is a full device.
#[cfg(target_os = "linux")]
#[test]
fn quick_demo_writes_its_files_before_it_prints_and_judges_no_claim() {
    let scratch = Scratch::new("demo_quick");
    let out = scratch.path().to_str().unwrap();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let demo = program(&["demo", "--quick", "--out", out]).stdout(full).output().unwrap();
    let message = String::from_utf8(demo.stderr).unwrap();
    assert_eq!(demo.status.code(), Some(1), "{message}");
    assert!(message.contains("error: cannot print: "), "{message}");
    let page = std::fs::read_to_string(scratch.path().join("index.html")).unwrap();
    assert_eq!(page.matches("– not judged").count(), 8);
    assert!(page.contains("only the first 1 s of 20 s ran") && !page.contains("confirmed"));
    for words in [&format!("<code>revprio demo --quick --out {out}</code>")[..], "auto and qp: median ", "Clarabel: "] {
        assert!(page.contains(words), "no `{words}` in the page");
    }
}

#[test]
fn help_names_the_servers_and_its_own_default() {
    let help = success(&["demo", "--help"]);
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for words in ["a server of its own on a free port", "no --server", "stiff_wall_limits", "[default: parquet]"] {
        assert!(help.contains(words), "no `{words}` in {help}");
    }
    assert!(success(&["simulate", "--help"]).contains("[default: csv]"));
}
