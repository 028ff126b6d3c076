//! The structure of the repository, read from manifests and sources: which crate and which file may use what.

use std::path::{Path, PathBuf};

mod circles;
mod module_graph;

/// The manifest of each crate and the crates of the workspace that it may use.
const LAYERS: [(&str, &[&str]); 12] = [
    ("crates/robot", &[]),
    ("crates/problem", &[]),
    // Neither knows the other: two solvers that agree are two accounts of the same mathematics.
    ("crates/core", &["revprio-problem", "revprio-robot"]),
    ("crates/reference", &["revprio-problem"]),
    ("api/rust", &[]),
    // Never the core: the simulator sees the service as every client does.
    ("crates/lab", &["revprio-api", "revprio-robot"]),
    // Bodies to controllers and back, without a server.
    ("crates/local", &["revprio-api", "revprio-core", "revprio-lab", "revprio-reference", "revprio-robot"]),
    ("crates/wasm", &["revprio-api", "revprio-lab", "revprio-local", "revprio-robot"]),
    (".", &["revprio-api", "revprio-core", "revprio-lab", "revprio-local", "revprio-reference", "revprio-robot"]),
    ("api/python/native", &["revprio", "revprio-api"]),
    ("tools/bench", &["revprio", "revprio-api", "revprio-core", "revprio-lab", "revprio-robot"]),
    ("tools/fuzz", &["revprio", "revprio-api", "revprio-robot"]),
];

/// Crates of others, and the only files and folders that may name them.
const MAY_NAME: [(&str, &[&str]); 23] = [
    ("axum", &["src/service/", "crates/local/src/error/answer.rs", "tools/bench/src/http/peers.rs"]),
    ("clarabel", &["crates/reference/src/clarabel.rs", "tools/bench/"]),
    ("faer", &["crates/reference/src/svd.rs", "crates/core/src/controller/stability/tests.rs", "tools/bench/"]),
    ("flate2", &["src/service/body.rs", "src/service/simulations/trace.rs", "tools/fuzz/src/corpus.rs"]),
    ("foxglove", &["crates/lab/src/simulator/recording/mcap_log/"]),
    ("futures_util", &["src/service/"]),
    ("hyper", &["src/service/"]),
    ("hyper_util", &["src/service/"]),
    ("swagger_ui_dist", &["src/service/handlers/docs.rs"]),
    ("mcap", &["crates/lab/src/simulator/recording/"]),
    ("parquet", &["crates/lab/src/simulator/recording/", "crates/lab/src/sweep/"]),
    ("plotters", &["crates/lab/src/report/"]),
    ("prometheus_client", &["src/service/"]),
    ("rayon", &["src/cli/parallel_runs.rs", "src/cli/sweep.rs"]),
    ("resvg", &["crates/lab/src/report/"]),
    ("rmp_serde", &["src/service/format/", "tools/fuzz/src/"]),
    ("rustix", &["crates/local/src/all_cores.rs", "tools/bench/src/http/affinity.rs", "tools/fuzz/src/budget.rs"]),
    ("sd_notify", &["src/cli/supervisor.rs"]),
    ("signal_hook", &["src/cli/supervisor.rs"]),
    (
        "tokio",
        &[
            "src/service/",
            "crates/local/src/clock.rs",
            "crates/local/src/simulation/",
            "src/cli/serve.rs",
            "tools/bench/src/",
            "tools/fuzz/src/connection.rs",
        ],
    ),
    ("tokio_rustls", &["src/service/"]),
    ("tower_http", &["src/service/"]),
    ("utoipa_axum", &["src/service/routes.rs", "src/service/app.rs", "src/service/openapi/"]),
];

/// What can be added, words that name an existing one, its own file, and the other files that know it: at most three.
/// These are the first five rows of the table in `docs/architecture.md`.
const KINDS: [(&str, &[&str], &str, &[&str]); 5] = [
    (
        "law",
        &["Law::Impedance", "ImpedanceLaw", "Self::Impedance"],
        "crates/core/src/law/impedance.rs",
        &["crates/core/src/law/mod.rs", "api/rust/src/wire/law.rs", "crates/local/src/convert/task.rs"],
    ),
    (
        "task kind",
        &["TaskRows::Joints", "Self::Joints", "JointRows"],
        "crates/core/src/rows/joints.rs",
        &["crates/core/src/rows/mod.rs", "crates/local/src/convert/task.rs"],
    ),
    (
        "constraint",
        &["Constraint::Plane", "VirtualPlane", "Self::Plane"],
        "crates/core/src/constraint/plane.rs",
        &[
            "crates/core/src/constraint/mod.rs",
            "api/rust/src/wire/inequality.rs",
            "crates/local/src/convert/inequalities.rs",
        ],
    ),
    (
        "method",
        &["SingularityRobust"],
        "crates/core/src/resolution/plan.rs",
        &["crates/problem/src/problem.rs", "api/rust/src/wire/enums.rs", "crates/local/src/convert/terms.rs"],
    ),
    (
        "joint kind",
        &["Prismatic", "JointKind::Revolute"],
        "",
        &["crates/robot/src/joint_kind.rs", "api/rust/src/wire/enums.rs", "crates/local/src/convert/terms.rs"],
    ),
];

/// The files of the reference crate that know the methods.
const OTHER_ACCOUNTS: [&str; 2] = ["crates/reference/src/closed_form.rs", "crates/reference/src/step.rs"];

/// Source folders of the crates that users build.
const SOURCES: [&str; 8] = [
    "crates/robot/src",
    "crates/problem/src",
    "crates/core/src",
    "crates/reference/src",
    "api/rust/src",
    "crates/lab/src",
    "crates/local/src",
    "src",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Rust files below a folder, by path from the root.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap());
    let mut files = Vec::new();
    for entry in entries {
        let path = folder.join(entry.file_name());
        if entry.path().is_dir() {
            files.extend(self::files(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") && !path.ends_with("tests.rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// The code of a file without comments and without its tests.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(root().join(path)).unwrap();
    let text = &text[..start_of_tests(&text)];
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// Where `mod tests {` begins with its attributes.
fn start_of_tests(text: &str) -> usize {
    let Some(tests) = text.find("\nmod tests {") else { return text.len() };
    let attributes = text[..tests].lines().rev().take_while(|line| line.starts_with("#["));
    tests - attributes.map(|line| line.len() + 1).sum::<usize>()
}

/// Whether the code contains the word, not as a part of a longer one.
fn contains_word(code: &str, word: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(word)
        .any(|(at, _)| !code[..at].ends_with(is_part) && !code[at + word.len()..].starts_with(is_part))
}

/// Whether the code has a path that begins with the crate's name.
fn names_crate(code: &str, name: &str) -> bool {
    let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    code.match_indices(&format!("{name}::")).any(|(at, _)| !code[..at].ends_with(is_path))
}

/// Reads the manifest of a crate from its folder.
fn manifest(folder: &str) -> toml::Table {
    let manifest = std::fs::read_to_string(root().join(folder).join("Cargo.toml")).unwrap();
    manifest.parse().unwrap()
}

#[test]
fn crates_use_only_the_layers_below_them() {
    for (folder, allowed) in LAYERS {
        let manifest = manifest(folder);
        let used = manifest["dependencies"].as_table().unwrap().keys().filter(|name| name.starts_with("revprio"));
        let used: Vec<&str> = used.map(String::as_str).collect();
        assert_eq!(used, allowed, "{folder}");
    }
}

#[test]
fn every_crate_of_the_workspace_has_its_layer() {
    let manifest = manifest(".");
    let members = manifest["workspace"]["members"].as_array().unwrap().iter().map(|member| member.as_str().unwrap());
    let crates = std::fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().file_name());
    let crates = crates.map(|name| format!("crates/{}", name.to_str().unwrap()));
    for folder in members.filter(|member| *member != "crates/*").map(str::to_owned).chain(crates) {
        assert!(LAYERS.iter().any(|(layer, _)| *layer == folder), "{folder} is missing in LAYERS");
    }
}

#[test]
fn the_reference_and_the_core_know_nothing_of_each_other() {
    let reference = manifest("crates/reference");
    for kind in ["dependencies", "dev-dependencies", "build-dependencies", "target"] {
        let named = reference.get(kind).map(toml::Value::to_string).unwrap_or_default();
        assert!(!named.contains("revprio-core"), "{kind} of crates/reference: {named}");
    }
    let core = manifest("crates/core");
    for kind in ["dependencies", "build-dependencies", "target"] {
        let named = core.get(kind).map(toml::Value::to_string).unwrap_or_default();
        assert!(!named.contains("revprio-reference"), "{kind} of crates/core: {named}");
    }
    for (folder, other) in [
        ("crates/reference", "revprio_core"),
        ("crates/core/src", "revprio_reference"),
        ("crates/problem", "revprio_core"),
    ] {
        for file in files(folder.as_ref()) {
            assert!(!contains_word(&code(&file), other), "{} names {other}", file.display());
        }
    }
}

#[test]
fn the_core_needs_at_most_a_dozen_crates() {
    assert!(manifest("crates/core")["dependencies"].as_table().unwrap().len() <= 12);
}

#[test]
fn heavy_crates_are_named_only_where_they_belong() {
    let mut wrong = Vec::new();
    for file in SOURCES.iter().chain(&["tools/bench/src", "tools/fuzz/src"]).flat_map(|folder| files(folder.as_ref())) {
        let (code, path) = (code(&file), file.to_str().unwrap());
        for (name, places) in MAY_NAME {
            if names_crate(&code, name) {
                let allowed = places.iter().any(|place| path.starts_with(place));
                wrong.extend((!allowed).then(|| format!("{path}: `{name}` may be named only in {places:?}")));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn each_kind_is_known_to_at_most_three_files_and_its_own() {
    let page = std::fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let sources: Vec<PathBuf> = SOURCES.iter().flat_map(|folder| files(folder.as_ref())).collect();
    for (kind, words, own, others) in KINDS {
        assert!(others.len() <= 3 && page.contains(kind), "{kind}");
        for file in &sources {
            let (code, path) = (code(file), file.to_str().unwrap());
            // The reference crate is a second and a third account of every method, which knows nothing of the core.
            let is_other_account = kind == "method" && OTHER_ACCOUNTS.contains(&path);
            if path != own && !others.contains(&path) && !is_other_account {
                let known = words.iter().find(|word| contains_word(&code, word));
                assert_eq!(known, None, "{path} knows a {kind}; only {own} and {others:?} may");
            }
        }
        for file in others.iter().chain(&[own]).filter(|file| !file.is_empty()) {
            assert!(root().join(file).exists(), "{kind}: {file} does not exist");
        }
    }
}

#[test]
fn words_and_crates_are_found_as_a_whole() {
    assert!(names_crate("let a = clarabel::b();", "clarabel") && !names_crate("super::clarabel::a", "clarabel"));
    assert!(contains_word("JointKind::Prismatic", "Prismatic") && !contains_word("Prismatics", "Prismatic"));
}
