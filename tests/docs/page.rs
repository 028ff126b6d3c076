//! Reads code blocks and links of a Markdown page.

use std::path::{Path, PathBuf};

/// A code block.
pub struct Block {
    /// Line of the opening fence, from 1.
    pub line: usize,
    /// Text after the opening fence: `sh`, `json`, `text output`.
    pub kind: String,
    pub text: String,
    /// Whether the line before the fence is not `<!-- not run: WHY -->`.
    pub is_run: bool,
}

/// A page: code blocks, and links outside them.
pub struct Page {
    /// Path from the root of the repository.
    pub path: PathBuf,
    pub blocks: Vec<Block>,
    /// Targets of relative links, each with its line: path and fragment, of which one can be empty.
    pub links: Vec<(usize, (String, String))>,
    /// Fragments of the headings.
    pub headings: Vec<String>,
}

impl Page {
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(root().join(path)).unwrap();
        let (mut blocks, mut links, mut headings, mut open) = (Vec::new(), Vec::new(), Vec::new(), None::<Block>);
        let mut before = "";
        for (i, line) in text.lines().enumerate() {
            match (&mut open, line.strip_prefix("```")) {
                (Some(_), Some("")) => blocks.extend(open.take()),
                (Some(block), _) => block.text.extend([line, "\n"]),
                (None, Some(kind)) => open = Some(opened(i + 1, kind, before)),
                (None, None) => {
                    links.extend(links_in(line).map(|link| (i + 1, link)));
                    headings.extend(heading(line).map(|heading| fragment(heading, &headings)));
                }
            }
            before = line;
        }
        assert!(open.is_none(), "{}: a fence is not closed", path.display());
        Self { path: path.to_owned(), blocks, links, headings }
    }

    /// Returns path and line.
    pub fn at(&self, line: usize) -> String {
        format!("{}:{line}", self.path.display())
    }
}

fn opened(line: usize, kind: &str, before: &str) -> Block {
    let reason = before.strip_prefix("<!-- not run:").and_then(|rest| rest.strip_suffix("-->"));
    let is_run = reason.is_none_or(|reason| reason.trim().is_empty());
    Block { line, kind: kind.trim().to_owned(), text: String::new(), is_run }
}

/// Returns the targets of links and pictures in a line that are inside the repository: path and fragment.
fn links_in(line: &str) -> impl Iterator<Item = (String, String)> {
    let targets = line.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0));
    let inside = targets.filter(|target| !target.contains("://"));
    inside.map(|target| target.split_once('#').unwrap_or((target, ""))).map(|(path, name)| (path.into(), name.into()))
}

/// Returns the text of a heading.
fn heading(line: &str) -> Option<&str> {
    let text = line.trim_start_matches('#');
    (text.len() < line.len()).then(|| text.strip_prefix(' ')).flatten()
}

/// Returns the fragment of a heading, as GitHub and mdBook write it. The `others` stand before it.
fn fragment(heading: &str, others: &[String]) -> String {
    let is_part = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    let name: String = heading.trim().to_lowercase().chars().filter(is_part).collect::<String>().replace(' ', "-");
    let repeated = others.iter().filter(|other| **other == name).count();
    if repeated == 0 { name } else { format!("{name}-{repeated}") }
}

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns README and all pages below `docs` and `api`.
pub fn pages() -> Vec<Page> {
    let mut paths = vec![PathBuf::from("README.md")];
    let mut directories = vec![PathBuf::from("docs"), PathBuf::from("api")];
    while let Some(directory) = directories.pop() {
        for entry in std::fs::read_dir(root().join(&directory)).unwrap().map(Result::unwrap) {
            let path = directory.join(entry.file_name());
            let name = entry.file_name();
            if entry.path().is_dir() {
                // Skip directories of package managers.
                let is_foreign = name == "node_modules" || name.to_string_lossy().starts_with('.');
                directories.extend((!is_foreign).then_some(path));
            } else if path.extension().is_some_and(|ending| ending == "md") {
                paths.push(path);
            }
        }
    }
    paths.sort();
    paths.iter().map(|path| Page::read(path)).collect()
}
