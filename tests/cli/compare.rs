//! `revprio compare`, and the numbers of docs/paper.md.

use std::path::Path;

use crate::program::{Scratch, failure, files, program, success};
use crate::trace::Trace;

/// A built-in scenario with a shorter duration.
fn short(name: &str, duration_s: f64) -> String {
    let path = format!("{}/fixtures/scenarios/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let duration = format!("duration_s = {duration_s}");
    let lines = text.lines().map(|line| if line.starts_with("duration_s") { &duration } else { line });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn compare_prints_runs_side_by_side_and_writes_a_directory() {
    let scratch = Scratch::new("compare");
    let file = scratch.write("mine.toml", &short("stiff_wall_singular", 0.2));
    let out = scratch.argument("out");
    let methods = ["--methods", "reverse_priority,damped_least_squares,reverse_priority"];
    let table = success(&[&["compare", &file, "--solvers", "closed_form,auto", "--out", &out][..], &methods].concat());
    let line = |start: &str| -> Vec<&str> {
        let line = table.lines().find(|line| line.trim_start().starts_with(start));
        line.unwrap_or_else(|| panic!("no `{start}` in {table}"))
            .split("  ")
            .map(str::trim)
            .filter(|cell| !cell.is_empty())
            .collect()
    };
    let [reverse, classical] = ["reverse priority", "damped least squares"];
    assert_eq!(line("method"), ["method", reverse, reverse, classical, classical]);
    assert_eq!(line("solver"), ["solver", "closed form", "auto", "closed form", "auto"]);
    assert_eq!(line("status")[2..], ["optimal 200"; 4]);
    assert_eq!(line("limit excess").len(), 5);
    let files = files(&scratch.path().join("out"));
    for name in [
        "index.html",
        "experiment.json",
        "comparison_stiff_wall_singular.svg",
        "figure7_singular.png",
        "stiff_wall_singular-damped_least_squares-auto.csv",
    ] {
        assert!(files.contains(&name.to_owned()), "no {name} in {files:?}");
    }
}

#[test]
fn runs_in_the_process_have_the_recordings_of_runs_over_http_and_no_requests() {
    let scratch = Scratch::new("compare_in_process");
    let file = scratch.write("mine.toml", &short("stiff_wall_singular", 0.1));
    let compare = |out: &str, more: &[&str]| {
        let options = ["--solvers", "auto,qp", "--write", "traces,page", "--out", out];
        success(&[&["compare", &file][..], &options, more].concat())
    };
    let [http, in_process] = ["http", "in_process"].map(|out| scratch.argument(out));
    let [printed, printed_in_process] = [compare(&http, &[]), compare(&in_process, &["--in-process"])];
    let requests = |printed: &str| -> Vec<String> {
        let line = printed.lines().find(|line| line.trim_start().starts_with("requests"));
        line.unwrap_or_default().split_whitespace().skip(1).map(str::to_owned).collect()
    };
    assert_eq!(requests(&printed), ["102"; 4]);
    assert!(
        printed.contains("  round trip, median / 99th perc.  ") && !printed_in_process.contains("round trip"),
        "{printed_in_process}"
    );
    assert!(requests(&printed_in_process).is_empty());
    for method in ["damped_least_squares", "reverse_priority"] {
        for solver in ["auto", "qp"] {
            let trace = format!("stiff_wall_singular-{method}-{solver}.csv");
            let [one, other] = [&http, &in_process].map(|out| std::fs::read(Path::new(out).join(&trace)).unwrap());
            assert!(one == other, "{trace}");
        }
    }
    let page = std::fs::read_to_string(Path::new(&in_process).join("index.html")).unwrap();
    assert!(page.contains("--solvers auto,qp --in-process"));
}

#[test]
fn options_of_recordings_that_are_not_written_are_refused() {
    for (option, given) in [("--traces", &["--traces", "mcap"][..]), ("--timings", &["--timings"])] {
        let error = failure(&[&["compare", "stiff_wall", "--write", "page"][..], given].concat());
        assert!(error.contains(option) && error.contains("add `traces` to --write"), "{error}");
    }
}

#[test]
fn compare_names_the_page_whatever_else_it_writes() {
    let scratch = Scratch::new("compare_written");
    let file = scratch.write("mine.toml", &short("stiff_wall", 0.01));
    let out = scratch.argument("out");
    let written = |kinds: &str| {
        let output = program(&["compare", &file, "--write", kinds, "--out", &out]).output().unwrap();
        let lines = String::from_utf8(output.stderr).unwrap();
        lines.lines().last().unwrap().strip_prefix("written: ").unwrap().to_owned()
    };
    for kinds in ["page", "page,svg,png", "page,traces"] {
        assert_eq!(Path::new(&written(kinds)), Path::new(&out).join("index.html"), "{kinds}");
    }
    assert_eq!(written("svg"), out);
}

#[test]
fn json_output_has_the_metrics_of_every_run() {
    let scratch = Scratch::new("compare_json");
    let file = scratch.write("mine.toml", &short("force_tracking", 0.1));
    let options = ["--methods", "task_priority", "--solvers", "qp", "--format", "json", "--write", "traces"];
    let out = scratch.argument("out");
    let printed = success(&[&["compare", &file, "--out", &out][..], &options].concat());
    let runs = &serde_json::from_str::<serde_json::Value>(&printed).unwrap()["runs"];
    assert_eq!(runs.as_array().unwrap().len(), 1);
    let run = &runs[0];
    assert_eq!((&run["method"], &run["solver"]), (&"task_priority".into(), &"qp".into()));
    assert_eq!(run["metrics"]["statuses"]["optimal"], 100);
    assert_eq!(run["metrics"]["paths"]["qp"], 100);
    assert_eq!(run["requests"]["count"], 102);
    let trace = Trace::read(&scratch.path().join("out/force_tracking-task_priority-qp.csv"));
    let largest = trace.numbers("residual_task_2").into_iter().fold(0.0, f64::max);
    assert_eq!(run["metrics"]["residuals"][1]["largest"], largest);
    assert!(
        !files(&scratch.path().join("out"))
            .iter()
            .any(|name| [".svg", ".html"].iter().any(|ending| name.ends_with(ending)))
    );
}

#[test]
fn scenarios_of_the_same_name_are_refused_before_the_first_run() {
    let scratch = Scratch::new("compare_same_name");
    let text = short("stiff_wall", 0.01);
    let [first, second] = [("first.toml", &text), ("second.toml", &text.replacen("1e5", "1e4", 1))]
        .map(|(name, text)| scratch.write(name, text));
    let out = scratch.argument("out");
    let refusal = |scenarios: [&str; 2]| failure(&[&["compare"], &scenarios[..], &["--out", &out]].concat());
    let message = refusal([&first, &second]);
    let words = format!("{first} and {second} have the same name, `stiff_wall`, and");
    assert!(message.contains(&words) && message.contains("change `name` in one of the files"), "{message}");
    assert!(refusal(["stiff_wall", &second]).contains("stiff_wall and "));
    assert!(!Path::new(&out).exists());
    let other = scratch.write("other.toml", &text.replacen("\"stiff_wall\"", "\"soft wall\"", 1));
    success(&["compare", &first, &other, "--write", "traces", "--out", &out]);
    assert!(files(Path::new(&out)).contains(&"soft wall-reverse_priority-auto.csv".to_owned()));
}

#[test]
fn errors_name_unknown_methods_scenarios_and_invalid_postures() {
    let unknown = program(&["compare", "stiff_wall", "--methods", "reverse_priority,newton"]).output().unwrap();
    assert_eq!(unknown.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("newton"));
    assert!(
        failure(&["compare", "stiff_wall", "stif_wall"])
            .contains("no scenario `stif_wall`; did you mean `stiff_wall`?")
    );
    let scratch = Scratch::new("compare_broken");
    let far = scratch.write("far.toml", &short("stiff_wall", 0.1).replacen("2.9, ", "1e300, ", 1));
    let message = failure(&["compare", &far, "--out", &scratch.argument("out")]);
    assert!(message.contains("start_joint_position"), "{message}");
}

/// Splits a line of a table into numbers and words.
fn tokens(line: &str) -> Vec<&str> {
    line.split([' ', '|', '(', ')', ',', '/']).filter(|token| !token.is_empty()).collect()
}

/// Returns whether words are equal, and numbers are equal within 1 % or both rounding errors.
fn same(a: &str, b: &str) -> bool {
    let number = |text: &str| text.parse::<f64>().ok();
    match (number(a), number(b)) {
        (Some(a), Some(b)) => (a - b).abs() <= 0.01 * a.abs().max(b.abs()) || a.abs().max(b.abs()) < 1e-9,
        _ => a == b,
    }
}

fn same_line(a: &str, b: &str) -> bool {
    let (a, b) = (tokens(a), tokens(b));
    a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| same(a, b))
}

/// Returns the tables of a Markdown text as lines.
fn tables(markdown: &str) -> Vec<Vec<&str>> {
    let lines: Vec<&str> = markdown.lines().collect();
    let tables = lines.chunk_by(|a, b| a.starts_with('|') == b.starts_with('|'));
    tables.filter(|lines| lines[0].starts_with('|')).map(<[&str]>::to_vec).collect()
}

#[test]
fn page_of_the_paper_has_the_numbers_that_its_command_prints() {
    let scratch = Scratch::new("compare_paper");
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/paper.md")).unwrap();
    let options = ["--methods", "damped_least_squares,reverse_priority", "--solvers", "closed_form"];
    let more = ["--format", "markdown", "--write", "svg", "--out", &scratch.argument("out")];
    let printed = success(&[&["compare", "stiff_wall", "stiff_wall_singular"][..], &options, &more].concat());
    let quoted = tables(&page);
    // The last table contains the claims. The page has the claims of all four scenarios in one table.
    let tables = tables(&printed);
    let (claims, measures) = tables.split_last().unwrap();
    assert_eq!(measures.len(), 2);
    for table in measures {
        let stands = quoted
            .iter()
            .any(|other| other.len() == table.len() && other.iter().zip(table).all(|(a, b)| same_line(a, b)));
        assert!(stands, "docs/paper.md does not have\n{}", table.join("\n"));
    }
    for claim in claims {
        assert!(quoted.iter().flatten().any(|line| same_line(line, claim)), "docs/paper.md does not have\n{claim}");
    }
}

#[test]
fn report_writes_the_same_page_again() {
    let scratch = Scratch::new("report");
    let file = scratch.write("mine.toml", &short("stiff_wall", 0.1));
    let out = scratch.argument("out");
    let compared = success(&["compare", &file, "--format", "markdown", "--out", &out]);
    let page = scratch.path().join("out/index.html");
    let first = std::fs::read_to_string(&page).unwrap();
    std::fs::remove_file(&page).unwrap();
    assert_eq!(success(&["report", &out, "--format", "markdown"]), compared);
    // The only measured time on the page is the speed of the machine, which is stored in the directory.
    assert!(std::fs::read_to_string(&page).unwrap() == first, "the second page differs from the first");
}

#[test]
fn report_names_missing_and_invalid_files() {
    let scratch = Scratch::new("report_nothing");
    let directory = scratch.argument(".");
    let message = failure(&["report", &directory]);
    assert!(message.contains("experiment.json") && message.contains("--out"), "{message}");
    scratch.write("experiment.json", "{}");
    assert!(failure(&["report", &directory]).contains("missing field `title`"));
    let file = scratch.write("mine.toml", &short("stiff_wall", 0.01));
    let out = scratch.argument("out");
    success(&["compare", &file, "--methods", "reverse_priority", "--write", "traces", "--out", &out]);
    let trace = scratch.path().join("out/stiff_wall-reverse_priority-auto.csv");
    let text = std::fs::read_to_string(&trace).unwrap();
    std::fs::write(&trace, text.replacen("optimal", "perfect", 1)).unwrap();
    assert!(failure(&["report", &out]).contains("row 1: column `status`"));
    std::fs::remove_file(&trace).unwrap();
    assert!(failure(&["report", &out]).contains("stiff_wall-reverse_priority-auto.csv"));
}
