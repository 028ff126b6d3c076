//! Which modules import each other in a circle.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::module_graph::{Crate, ModulePath, in_circles};
use super::{LAYERS, code, files, root};

/// Returns the source folder of each crate, and of each test program that has several files.
fn sources() -> impl Iterator<Item = String> {
    LAYERS.iter().flat_map(|(folder, _)| {
        let folder = Path::new(folder).strip_prefix(".").unwrap_or(Path::new(folder));
        let entries = std::fs::read_dir(root().join(folder).join("tests")).into_iter().flatten();
        let tests = entries.map(|entry| entry.unwrap().path()).filter(|path| path.join("main.rs").exists());
        let mut tests: Vec<PathBuf> = tests.map(|path| path.strip_prefix(root()).unwrap().to_owned()).collect();
        tests.sort();
        std::iter::once(folder.join("src")).chain(tests).map(|path| path.to_str().unwrap().to_owned())
    })
}

/// Returns the path of a module from its file; `None` for other programs of the crate and for tests.
fn module_path(sources: &str, file: &Path, has_library: bool) -> Option<ModulePath> {
    let inside = file.strip_prefix(sources).unwrap().with_extension("");
    let mut path: ModulePath = inside.iter().map(|name| name.to_str().unwrap().to_owned()).collect();
    if path.iter().any(|name| matches!(name.as_str(), "bin" | "tests")) || (has_library && path == ["main"]) {
        return None;
    }
    if path.last().is_some_and(|last| last == "mod") || path == ["lib"] || path == ["main"] {
        path.pop();
    }
    Some(path)
}

/// Reads the modules of a crate from its source folder.
fn read(sources: &str) -> Crate {
    let files = files(sources.as_ref());
    let has_library = files.contains(&Path::new(sources).join("lib.rs"));
    let modules: Vec<(ModulePath, String)> =
        files.iter().filter_map(|file| Some((module_path(sources, file, has_library)?, code(file)))).collect();
    Crate::new(modules.iter().map(|(path, code)| (path.clone(), code.as_str())))
}

#[test]
fn no_modules_import_each_other_in_a_circle() {
    let (mut found, mut modules, mut folders) = (BTreeMap::new(), 0, 0);
    for sources in sources() {
        let crate_modules = read(&sources);
        for folder in crate_modules.folders() {
            let graph = crate_modules.graph(&folder);
            (modules, folders) = (modules + graph.len(), folders + 1);
            let circles = in_circles(&graph);
            if !circles.is_empty() {
                let path = folder.iter().fold(sources.clone(), |path, name| format!("{path}/{name}"));
                println!("{path}: {circles:?}");
                found.insert(path, circles.len());
            }
        }
    }
    println!("{modules} modules in {folders} folders");
    assert!(modules > 450 && folders > 40, "{modules} modules in {folders} folders: too few are found");
    assert_eq!(found, BTreeMap::new());
}

#[test]
fn no_module_imports_all_names_of_another_one() {
    for sources in sources() {
        assert_eq!(read(&sources).globs(), [] as [&ModulePath; 0], "{sources}: a glob hides where a name comes from");
    }
}
