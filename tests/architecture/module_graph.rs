//! Which module of a crate imports which, read from the sources.
//!
//! A path counts as an import of the file that defines what it names: re-exports are followed, also through other folders.

use std::collections::{BTreeMap, BTreeSet};

/// The path of a module from the root of its crate; empty for the root.
pub type ModulePath = Vec<String>;

/// The modules of a crate with the paths that each of them names.
#[derive(Debug, Default)]
pub struct Crate {
    modules: BTreeMap<ModulePath, Module>,
}

#[derive(Debug, Default)]
struct Module {
    /// Names that `use` brings into the module, with the paths that they stand for.
    names: BTreeMap<String, ModulePath>,
    /// Modules of which `use` brings all names into this one. They cannot be followed.
    globs: Vec<ModulePath>,
    /// Modules that it declares, also those whose file is elsewhere.
    declared: BTreeSet<String>,
    /// Paths in the code and in private `use` declarations.
    imports: Vec<ModulePath>,
    /// Paths in public `use` declarations.
    re_exports: Vec<ModulePath>,
}

/// A path in a `use` declaration.
#[derive(Debug, PartialEq)]
struct Used {
    path: ModulePath,
    /// The name in the module; `None` for a glob.
    name: Option<String>,
}

impl Crate {
    /// Reads the modules from their sources, without comments and tests or with them.
    pub fn new<'a>(sources: impl IntoIterator<Item = (ModulePath, &'a str)>) -> Self {
        let modules = sources.into_iter().map(|(path, code)| (path, Module::new(code))).collect();
        Self { modules }
    }

    /// Returns the folders of the crate, as paths of modules that have modules of their own.
    pub fn folders(&self) -> BTreeSet<ModulePath> {
        self.modules.keys().filter_map(|path| path.split_last()).map(|(_, folder)| folder.to_vec()).collect()
    }

    /// Returns the modules that bring all names of another module of the crate into scope, which hides where a name comes from.
    pub fn globs(&self) -> Vec<&ModulePath> {
        let is_own = |module: &Module, glob: &ModulePath| {
            let first = glob.first().map(String::as_str).unwrap_or_default();
            matches!(first, "crate" | "super" | "self") || module.declared.contains(first)
        };
        let has_own = |module: &Module| module.globs.iter().any(|glob| is_own(module, glob));
        self.modules.iter().filter(|(_, module)| has_own(module)).map(|(path, _)| path).collect()
    }

    /// Returns which module of a folder imports which others of it. The file of the folder itself (`mod.rs`, `lib.rs`) is
    /// the module [`FOLDER`].
    pub fn graph(&self, folder: &[String]) -> BTreeMap<String, BTreeSet<String>> {
        let mut graph = BTreeMap::<String, BTreeSet<String>>::new();
        for (path, module) in &self.modules {
            let Some(importing) = inside(folder, path) else { continue };
            let imported = graph.entry(importing.to_owned()).or_default();
            imported.extend(self.imports(path, module).filter_map(|file| inside(folder, &file).map(str::to_owned)));
            imported.remove(importing);
        }
        graph
    }

    /// Returns the modules whose files define what a module names. A folder that re-exports its own parts does not use them.
    fn imports<'a>(&'a self, path: &'a ModulePath, module: &'a Module) -> impl Iterator<Item = ModulePath> + 'a {
        let defined = move |import: &ModulePath| self.defined_in(path, import, DEPTH);
        let others = module.re_exports.iter().filter_map(defined).filter(move |file| !file.starts_with(path));
        module.imports.iter().filter_map(defined).chain(others)
    }

    /// Returns the module whose file defines what a path in `module` names; `None` for paths of other crates.
    fn defined_in(&self, module: &[String], path: &[String], depth: u32) -> Option<ModulePath> {
        let (first, rest) = path.split_first()?;
        let start = match first.as_str() {
            "crate" => Vec::new(),
            "self" => module.to_vec(),
            "super" => module.split_last()?.1.to_vec(),
            name => return self.named_in(module, name, rest, depth),
        };
        match rest.split_first() {
            None => Some(start),
            Some((next, _)) if next == "super" => self.defined_in(&start, rest, depth),
            Some((next, rest)) => self.named_in(&start, next, rest, depth).or(Some(start)),
        }
    }

    /// Returns the module that defines `name::rest` of `module`: one of its modules, or a name that it imports.
    fn named_in(&self, module: &[String], name: &str, rest: &[String], depth: u32) -> Option<ModulePath> {
        let depth = depth.checked_sub(1)?;
        let child: ModulePath = module.iter().cloned().chain([name.to_owned()]).collect();
        let source = self.modules.get(module);
        if self.modules.contains_key(&child) || source.is_some_and(|source| source.declared.contains(name)) {
            let Some((next, rest)) = rest.split_first() else { return Some(child) };
            return self.named_in(&child, next, rest, depth).or(Some(child));
        }
        let path = source?.names.get(name)?;
        let path: ModulePath = path.iter().chain(rest).cloned().collect();
        self.defined_in(module, &path, depth)
    }
}

/// The file of a folder itself, among the modules of the folder.
pub const FOLDER: &str = "mod.rs";

/// Longest chain of re-exports that is followed.
const DEPTH: u32 = 16;

/// Returns the module of a folder that the file of a module belongs to.
fn inside<'a>(folder: &[String], path: &'a [String]) -> Option<&'a str> {
    Some(path.strip_prefix(folder)?.first().map_or(FOLDER, String::as_str))
}

/// Returns the modules of a graph that import themselves through others.
pub fn in_circles(graph: &BTreeMap<String, BTreeSet<String>>) -> BTreeSet<String> {
    let reaches_itself = |start: &&String| {
        let (mut open, mut seen) = (vec![*start], BTreeSet::new());
        while let Some(module) = open.pop() {
            for imported in graph.get(module).into_iter().flatten() {
                if imported == *start {
                    return true;
                }
                if seen.insert(imported) {
                    open.push(imported);
                }
            }
        }
        false
    };
    graph.keys().filter(reaches_itself).cloned().collect()
}

impl Module {
    fn new(code: &str) -> Self {
        let tokens = tokens(code);
        let (mut module, mut at) = (Self::default(), 0);
        let mut is_public = false;
        while at < tokens.len() {
            let token = tokens[at];
            if token == "use" {
                let mut used = Vec::new();
                at = use_tree(&tokens, at + 1, &[], &mut used);
                module.add(used, is_public);
            } else if token == "mod" && tokens.get(at + 2) == Some(&";") {
                module.declared.insert(tokens[at + 1].to_owned());
                at += 3;
            } else if is_name(token) {
                let end = path_end(&tokens, at);
                let path: ModulePath = tokens[at..end].iter().step_by(2).map(|&name| name.to_owned()).collect();
                // `pub(super) use` is public as well.
                is_public = token == "pub" || (is_public && matches!(token, "crate" | "super" | "self" | "in"));
                if path.len() > 1 {
                    module.imports.push(path);
                }
                at = end;
            } else {
                is_public &= matches!(token, "(" | ")");
                at += 1;
            }
        }
        module
    }

    fn add(&mut self, used: Vec<Used>, is_public: bool) {
        for Used { path, name } in used {
            if is_public { &mut self.re_exports } else { &mut self.imports }.push(path.clone());
            match name {
                Some(name) => drop(self.names.insert(name, path)),
                None => self.globs.push(path),
            }
        }
    }
}

/// Reads the tree of a `use` declaration that begins at a token; returns the place after it.
fn use_tree(tokens: &[&str], mut at: usize, prefix: &[String], used: &mut Vec<Used>) -> usize {
    let mut path = prefix.to_vec();
    while at < tokens.len() {
        match tokens[at] {
            "{" => {
                at += 1;
                while at < tokens.len() && tokens[at] != "}" {
                    at = use_tree(tokens, at, &path, used);
                    at += usize::from(tokens.get(at) == Some(&","));
                }
                return at + 1;
            }
            "*" => {
                used.push(Used { path, name: None });
                return at + 1;
            }
            "::" => at += 1,
            "as" => {
                used.push(Used { path, name: tokens.get(at + 1).map(|&name| name.to_owned()) });
                return at + 2;
            }
            // `{self}` names the path before it.
            "self" if !path.is_empty() => at += 1,
            name if is_name(name) => {
                path.push(name.to_owned());
                at += 1;
            }
            _ => break,
        }
    }
    used.push(Used { name: path.last().cloned(), path });
    at
}

/// Returns the end of the path `a::b::c` that begins at a token.
fn path_end(tokens: &[&str], start: usize) -> usize {
    let mut end = start + 1;
    while tokens.get(end) == Some(&"::") && tokens.get(end + 1).is_some_and(|token| is_name(token)) {
        end += 2;
    }
    end
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Splits code into names, `::` and single characters, without comments, strings and numbers.
fn tokens(code: &str) -> Vec<&str> {
    let (mut rest, mut tokens) = (code, Vec::new());
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '/' if rest.starts_with("/*") => rest.find("*/").map_or(rest.len(), |end| end + 2),
            '"' => string_length(rest),
            'r' if rest.starts_with("r\"") || rest.starts_with("r#\"") => raw_string_length(rest),
            '\'' => character_length(rest),
            c if c.is_alphanumeric() || c == '_' => {
                let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
                tokens.push(&rest[..end]);
                end
            }
            ':' if rest.starts_with("::") => {
                tokens.push(&rest[..2]);
                2
            }
            c if c.is_whitespace() => c.len_utf8(),
            c => {
                tokens.push(&rest[..c.len_utf8()]);
                c.len_utf8()
            }
        };
        rest = &rest[length..];
    }
    tokens
}

/// Returns the length of a string with its quotes.
fn string_length(text: &str) -> usize {
    let mut is_escaped = false;
    let end = text.char_indices().skip(1).find(|&(_, c)| {
        let ends = c == '"' && !is_escaped;
        is_escaped = c == '\\' && !is_escaped;
        ends
    });
    end.map_or(text.len(), |(at, _)| at + 1)
}

fn raw_string_length(text: &str) -> usize {
    let hashes = text[1..].chars().take_while(|&c| c == '#').count();
    let (start, end) = (hashes + 2, format!("\"{}", "#".repeat(hashes)));
    text[start..].find(&end).map_or(text.len(), |at| start + at + end.len())
}

/// Returns the length of a character with its quotes, or of the quote of a lifetime.
fn character_length(text: &str) -> usize {
    let mut characters = text.char_indices().skip(1);
    match (characters.next(), characters.next()) {
        (Some((_, '\\')), _) => text[3..].find('\'').map_or(text.len(), |at| at + 4),
        (Some(_), Some((end, '\''))) => end + 1,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(text: &str) -> ModulePath {
        text.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect()
    }

    fn circles(sources: &[(&str, &str)], folder: &str) -> Vec<String> {
        let sources = sources.iter().map(|(module, code)| (path(module), *code));
        in_circles(&Crate::new(sources).graph(&path(folder))).into_iter().collect()
    }

    #[test]
    fn an_added_circle_is_found() {
        let line = [("", "mod a; mod b; mod c;"), ("a", "use super::b::B;"), ("b", "use crate::c::C;"), ("c", "")];
        assert!(circles(&line, "").is_empty());
        let circle = [line[0], line[1], line[2], ("c", "fn c() -> crate::a::A {}")];
        assert_eq!(circles(&circle, ""), ["a", "b", "c"]);
    }

    #[test]
    fn a_module_that_imports_a_circle_is_not_in_it() {
        let sources = [("a", "use super::b::B;"), ("b", "use super::a::A;"), ("c", "use super::{a::A, b};")];
        assert_eq!(circles(&sources, ""), ["a", "b"]);
    }

    #[test]
    fn a_re_export_counts_as_an_import_of_the_file_that_defines_it() {
        let root = ("f", "mod a; mod b; pub use a::A; pub(super) use b::{B, Other as Renamed};");
        for import in ["use super::B;", "use super::Renamed;", "use crate::f::{self, B};", "fn f(b: super::B) {}"] {
            assert_eq!(circles(&[root, ("f::a", import), ("f::b", "use super::A;")], "f"), ["a", "b"], "{import}");
            assert!(circles(&[root, ("f::a", import), ("f::b", "use super::Unknown;")], "f").is_empty());
        }
    }

    #[test]
    fn a_re_export_of_another_module_is_an_import() {
        let sources = [("f::a", "pub use super::b::B;"), ("f::b", "use super::a::A;"), ("f", "mod a; mod b;")];
        assert_eq!(circles(&sources, "f"), ["a", "b"]);
    }

    #[test]
    fn the_file_of_a_folder_is_one_of_its_modules() {
        let child = ("f::a", "use super::Shared;");
        let used = ["use a::A; struct Shared;", "struct Shared; fn f() -> a::A {}"];
        for folder in used.map(|code| format!("mod a; {code}")) {
            assert_eq!(circles(&[("f", &folder), child], "f"), ["a", FOLDER], "{folder}");
        }
        assert!(
            circles(&[("f", "mod a; pub use a::A; pub(crate) use self::a::C; struct Shared;"), child], "f").is_empty()
        );
    }

    #[test]
    fn a_module_with_a_file_elsewhere_is_no_part_of_the_folder() {
        let sources = [("", "mod a; #[path = \"../b.rs\"] mod b; use a::A;"), ("a", "use crate::b::B;")];
        assert!(circles(&sources, "").is_empty());
        let here = [("", "mod a; use a::A;"), sources[1]];
        assert_eq!(circles(&here, ""), ["a", FOLDER]);
    }

    #[test]
    fn a_re_export_is_followed_through_other_folders() {
        let sources = [
            ("f", "pub mod a; pub mod b;"),
            ("f::a", "use crate::g::B;"),
            ("f::b", "use crate::h::A;"),
            ("g", "pub use crate::f::b::B;"),
            ("h", "pub use super::f::a::A;"),
        ];
        assert_eq!(circles(&sources, "f"), ["a", "b"]);
    }

    #[test]
    fn globs_of_the_crate_are_named() {
        let sources = [
            ("a", "use super::b::*;"),
            ("b", "use nalgebra::prelude::*;"),
            ("c", "use crate::{a, b::*};"),
            ("d", "mod e; pub use e::*;"),
        ];
        let tree = Crate::new(sources.map(|(module, code)| (path(module), code)));
        assert_eq!(tree.globs(), [&path("a"), &path("c"), &path("d")]);
    }

    #[test]
    fn an_import_of_a_deeper_file_is_one_of_its_folder() {
        let sources = [
            ("f::a", "use super::super::g::x::X;"),
            ("g", "mod x;"),
            ("g::x", "let y = crate::f::a::Y;"),
            ("f", "mod a;"),
        ];
        assert_eq!(circles(&sources, ""), ["f", "g"]);
        assert!(circles(&sources, "g").is_empty());
    }

    #[test]
    fn comments_strings_and_lifetimes_are_no_imports() {
        let code = "// use super::b;\n/* super::b */ const A: &'static str = \"super::b \\\" super::b\"; const B: char = '\"';\n\
                    const C: &str = r#\"super::b \" \"#; const D: char = '\\'';";
        assert!(Module::new(code).imports.is_empty(), "{:?}", Module::new(code));
        let again = format!("{code} use super::b;");
        assert_eq!(Module::new(&again).imports, [path("super::b")]);
    }

    #[test]
    fn every_form_of_import_is_read() {
        let imports = |code: &str| Module::new(code).imports;
        assert_eq!(imports("use crate::{law, task::{self, A}, b::*};").len(), 4);
        assert_eq!(
            imports("fn f(a: &crate::task::Task) -> law::Law {}"),
            [path("crate::task::Task"), path("law::Law")]
        );
        assert!(imports("pub use a::B; pub(crate) use c::D; pub(in crate::a) use e::F;").len() <= 1);
    }
}
