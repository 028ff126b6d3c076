//! What `cargo publish` would send.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

/// Files that a package without tests consists of, at most, bytes.
const LARGEST: u64 = 2 << 20;

fn packaged() -> BTreeSet<PathBuf> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["package", "--list", "--allow-dirty", "--locked", "--offline"]).current_dir(root());
    let output = cargo.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(PathBuf::from).collect()
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// `a/../b` → `b`
fn plain(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, part| {
        if part == Component::ParentDir {
            plain.pop();
        } else {
            plain.push(part);
        }
        plain
    })
}

/// Files or, where a macro puts the name together, directories that the source includes.
fn included(source: &Path) -> Vec<PathBuf> {
    let text = std::fs::read_to_string(root().join(source)).unwrap();
    let after = text.split("include_str!").chain(text.split("include_bytes!").skip(1)).skip(1);
    let literals = after.filter_map(|rest| rest.split('"').nth(1));
    literals.map(|literal| plain(&source.parent().unwrap().join(literal))).collect()
}

#[test]
fn the_package_holds_what_its_sources_include() {
    let packaged = packaged();
    let mut count = 0;
    for source in packaged.iter().filter(|path| path.extension().is_some_and(|ending| ending == "rs")) {
        for path in included(source) {
            count += 1;
            let on_disk = root().join(&path);
            let needed = if on_disk.is_dir() {
                std::fs::read_dir(on_disk).unwrap().map(|entry| path.join(entry.unwrap().file_name())).collect()
            } else {
                vec![path]
            };
            // Where a macro picks files of a directory, the whole directory is packaged, but not what lies deeper.
            for file in needed.iter().filter(|file| !root().join(file).is_dir()) {
                assert!(packaged.contains(file), "{} needs {}", source.display(), file.display());
            }
        }
    }
    assert!(count > 8, "includes are not found any more");
}

#[test]
fn the_package_is_small_and_complete_for_its_users() {
    let packaged = packaged();
    for needed in ["Cargo.lock", "LICENSE", "README.md", "CHANGELOG.md", "CITATION.cff", "examples/methods.rs"] {
        assert!(packaged.contains(Path::new(needed)), "{needed}");
    }
    // Tests, and golden data of several MB, stay in the repository. `revprio check` needs one of the tools.
    let is_for_contributors = |path: &PathBuf| {
        ["tests", "tools", "api/python"].iter().any(|dir| path.starts_with(dir))
            && !path.ends_with("tools/check/check.py")
    };
    assert!(!packaged.iter().any(is_for_contributors));
    let bytes: u64 = packaged.iter().filter_map(|path| Some(root().join(path).metadata().ok()?.len())).sum();
    assert!(bytes < LARGEST, "{bytes} bytes");
}

#[test]
fn the_version_stands_in_one_place() {
    let read = |path: &str| std::fs::read_to_string(root().join(path)).unwrap();
    let version = env!("CARGO_PKG_VERSION");
    let manifest = read("Cargo.toml");
    let stated =
        |line: &&str| line.contains("version = \"") && (line.starts_with("version") || line.contains("path ="));
    let lines: Vec<_> = manifest.lines().filter(stated).collect();
    assert!(
        lines.len() > 4 && lines.iter().all(|line| line.contains(&format!("version = \"{version}\""))),
        "{lines:?}"
    );
    // A release writes the version into the copy that it packs.
    assert!(read("api/typescript/package.json").contains("\"version\": \"0.0.0\""));
    assert!(read("api/python/pyproject.toml").contains("dynamic = [\"version\"]"));
}
