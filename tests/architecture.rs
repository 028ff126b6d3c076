//! The import table of the crate: which module may use which, read off the sources.
//!
//! What a folder hides (one file using its neighbour) is its own affair; what crosses a border stands in the table.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Path, PathBuf};

/// Each module and what it may import of ours. `a::b` allows that part of `a` alone.
const MAY_IMPORT: [(&str, &[&str]); 15] = [
    ("linalg", &[]),
    ("wire", &[]),
    ("robot", &[]),
    ("kinematics", &["robot", "linalg"]),
    ("limits", &["robot", "kinematics", "linalg"]),
    ("task", &["linalg"]),
    ("law", &["linalg"]),
    ("resolution", &["task", "limits", "linalg"]),
    ("controller", &["robot", "kinematics", "task", "limits", "resolution", "law", "linalg"]),
    ("client", &["wire"]),
    // The service runs the simulator against itself, through the client and the network like everybody.
    (
        "service",
        &[
            "controller",
            "robot",
            "kinematics",
            "task",
            "limits",
            "resolution",
            "law",
            "linalg",
            "wire",
            "client",
            "simulator",
            "report::metrics",
        ],
    ),
    // Never control or resolution: it cannot cheat. Set-points over time move walls and people as they move targets.
    ("simulator", &["client", "wire", "robot", "kinematics", "law"]),
    // The page tells scenarios in words.
    ("report", &["simulator::recording", "simulator::Scenario", "wire"]),
    // Measures what the others do, from the inside and from the outside.
    (
        "bench",
        &[
            "controller",
            "robot",
            "kinematics",
            "limits",
            "task",
            "resolution",
            "linalg",
            "wire",
            "service",
            "client",
            "simulator",
            "report",
        ],
    ),
    ("cli", &["robot", "service", "simulator", "client", "report", "wire", "bench"]),
];

/// Crates of others that only some files may name, and the paths (from `src`) that may.
const MAY_NAME: [(&str, &[&str]); 21] = [
    ("clarabel", &["resolution/qp_cascade/clarabel_level.rs", "bench/core/level.rs"]),
    ("axum", &["service/", "bench/http/peers.rs"]),
    ("flate2", &["service/body.rs", "service/simulations/trace.rs"]),
    ("foxglove", &["simulator/recording/mcap_log/"]),
    ("futures_util", &["service/"]),
    ("hyper", &["service/"]),
    ("hyper_util", &["service/"]),
    ("mcap", &["simulator/recording/"]),
    ("parquet", &["simulator/recording/", "cli/sweep/file.rs"]),
    ("rayon", &["cli/sweep/"]),
    ("rmp_serde", &["service/format/message_pack.rs"]),
    ("tower_http", &["service/"]),
    ("tokio", &["service/", "cli/serve.rs", "cli/load/", "bench/http/peers.rs"]),
    ("rustix", &["service/background.rs", "bench/http/affinity.rs"]),
    ("tokio_rustls", &["service/"]),
    ("rand_pcg", &["simulator/chance.rs"]),
    ("tungstenite", &["bench/http/websocket.rs"]),
    ("prometheus_client", &["service/"]),
    ("utoipa", &["service/", "simulator/", "wire/"]),
    ("utoipa_axum", &["service/app.rs"]),
    ("utoipa_swagger_ui", &["service/openapi/docs.rs"]),
];

/// One line of code.
struct Line {
    /// Path below `src`.
    file: PathBuf,
    number: usize,
    code: String,
}

impl fmt::Display for Line {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "src/{}:{}: `{}`", self.file.display(), self.number, self.code.trim())
    }
}

impl Line {
    /// The top-level module that the line belongs to; `None` in `lib.rs` and `main.rs`, which see everything.
    fn module(&self) -> Option<&str> {
        (self.file.components().count() > 1).then(|| self.file.iter().next()?.to_str()).flatten()
    }

    /// Paths that follow `crate::`, as far as the second word: `simulator::recording`.
    fn imports(&self) -> Vec<String> {
        let after = self.code.split("crate::").skip(1);
        after.flat_map(branches).collect()
    }
}

/// `a::b::C` → `a::b`; `{a, b::C}` → `a`, `b::C`.
fn branches(rest: &str) -> Vec<String> {
    let branches = match rest.strip_prefix('{') {
        Some(list) => list.split('}').next().unwrap_or(list).split(',').collect(),
        None => vec![rest],
    };
    branches.into_iter().map(|branch| leading_words(branch.trim())).collect()
}

fn leading_words(path: &str) -> String {
    let end = path.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(path.len());
    path[..end].split("::").filter(|word| !word.is_empty()).take(2).collect::<Vec<_>>().join("::")
}

fn files(directory: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "rs"));
    files.sort();
    files
}

/// All lines of `src` that are no comments.
fn code() -> Vec<Line> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    files(&source).iter().flat_map(|path| lines(path, &source)).collect()
}

fn lines(path: &Path, source: &Path) -> Vec<Line> {
    let text = std::fs::read_to_string(path).unwrap();
    let file = path.strip_prefix(source).unwrap();
    let line = |(i, code): (usize, &str)| Line { file: file.to_owned(), number: i + 1, code: code.to_owned() };
    text.lines().enumerate().filter(|(_, code)| !code.trim_start().starts_with("//")).map(line).collect()
}

/// What the module may import; nothing if the table does not have it.
fn allowed(module: &str) -> &'static [&'static str] {
    MAY_IMPORT.iter().find(|(name, _)| *name == module).map_or(&[], |(_, allowed)| *allowed)
}

fn may_import(module: &str, import: &str) -> bool {
    let within = |allowed: &&str| import == *allowed || import.starts_with(&format!("{allowed}::"));
    module == import.split("::").next().unwrap_or(import) || allowed(module).iter().any(within)
}

#[test]
fn every_module_stands_in_the_table() {
    let known: BTreeSet<&str> = MAY_IMPORT.iter().map(|(name, _)| *name).collect();
    let code = code();
    let found: BTreeSet<&str> = code.iter().filter_map(Line::module).collect();
    assert_eq!(found, known);
}

#[test]
fn modules_import_what_the_table_allows() {
    let code = code();
    let mut broken = Vec::new();
    for (line, module) in code.iter().filter_map(|line| line.module().map(|module| (line, module))) {
        let forbidden = line.imports().into_iter().filter(|import| !may_import(module, import));
        broken.extend(
            forbidden.map(|import| format!("{line}: `{module}` may not import `{import}`, only {:?}", allowed(module))),
        );
    }
    assert!(broken.is_empty(), "\n{}", broken.join("\n"));
}

#[test]
fn the_table_has_no_circle() {
    let mut left: BTreeMap<&str, BTreeSet<&str>> = MAY_IMPORT
        .iter()
        .map(|(name, allowed)| (*name, allowed.iter().map(|path| path.split("::").next().unwrap()).collect()))
        .collect();
    while !left.is_empty() {
        let free: Vec<&str> = left
            .iter()
            .filter(|(_, needs)| needs.iter().all(|need| !left.contains_key(need)))
            .map(|(name, _)| *name)
            .collect();
        assert!(!free.is_empty(), "these import each other: {:?}", left.keys());
        left.retain(|name, _| !free.contains(name));
    }
}

#[test]
fn crates_of_others_stay_where_they_belong() {
    let code = code();
    let mut broken = Vec::new();
    for ((name, places), line) in MAY_NAME.iter().flat_map(|rule| code.iter().map(move |line| (rule, line))) {
        let file = line.file.to_str().unwrap();
        if names(&line.code, name) && !places.iter().any(|place| file.starts_with(place)) {
            broken.push(format!("{line}: `{name}` is named only in {places:?}"));
        }
    }
    assert!(broken.is_empty(), "\n{}", broken.join("\n"));
}

/// Whether the code has a path that begins with the crate's name.
fn names(code: &str, name: &str) -> bool {
    code.match_indices(&format!("{name}::"))
        .any(|(at, _)| !code[..at].ends_with(|before: char| before.is_alphanumeric() || before == '_' || before == ':'))
}

#[test]
fn the_reader_of_this_test_sees_every_form_of_import() {
    let imports = |code: &str| Line { file: PathBuf::new(), number: 1, code: code.to_owned() }.imports();
    assert_eq!(imports("use revprio_api::wire;"), ["wire"]);
    assert_eq!(imports("use revprio_lab::simulator::recording::{Recording, Sample};"), ["simulator::recording"]);
    assert_eq!(imports("use crate::{wire, client::Client};"), ["wire", "client::Client"]);
    assert_eq!(imports("fn f(a: &revprio_core::task::Task, b: revprio_core::law::Law)"), ["task::Task", "law::Law"]);
    assert!(names("use clarabel::solver;", "clarabel") && names("let a = clarabel::b();", "clarabel"));
    assert!(!names("use super::clarabel::level;", "clarabel") && !names("my_clarabel::level", "clarabel"));
}
