//! The pages for users: commands run and print the shown output, and links are valid.
//!
//! Every ```` ```sh ```` block of README.md and docs/guides is run, unless the line before it is
//! `<!-- not run: WHY -->`. A block that is `revprio serve` alone starts the server of the blocks that follow. A block
//! ```` ```text output ```` shows what the commands before it print; `…` in it stands for any text.

mod examples;
mod page;
mod shell;

use page::{Page, pages, root};
use shell::Shell;

/// Returns whether the commands of a page are run.
fn is_guide(page: &Page) -> bool {
    page.path.starts_with("docs/guides") || page.path.as_os_str() == "README.md"
}

/// Returns whether the printed text matches the shown text, in which `…` stands for any text. Spaces may differ.
fn shows(shown: &str, printed: &str) -> bool {
    let (shown, printed) = (single_spaced(shown), single_spaced(printed));
    let mut parts = shown.split('…');
    let Some(mut rest) = printed.strip_prefix(parts.next().unwrap_or("")) else { return false };
    let mut parts: Vec<&str> = parts.collect();
    let Some(last) = parts.pop() else { return rest.is_empty() };
    for part in parts {
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    rest.ends_with(last)
}

/// Returns the text with single spaces.
fn single_spaced(text: &str) -> String {
    let line = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    text.trim().lines().map(line).collect::<Vec<_>>().join("\n")
}

/// Runs a page from top to bottom and returns its errors.
fn follow(page: &Page) -> Vec<String> {
    let mut shell = Shell::new(&page.path.with_extension("").to_string_lossy().replace('/', "-"));
    let mut wrong = Vec::new();
    let mut printed = String::new();
    for block in &page.blocks {
        let at = page.at(block.line);
        let is_serve = |text: &str| text.lines().count() == 1 && text.contains(" serve") && !text.contains('|');
        match block.kind.as_str() {
            "sh" if !block.is_run => printed.clear(),
            "sh" if is_serve(&block.text) => {
                wrong.extend(shell.serve(&block.text).err().map(|why| format!("{at}: {why}\n{}", block.text)));
            }
            "sh" => match shell.run(&block.text) {
                Ok(output) => printed = output,
                Err(why) => wrong.push(format!("{at}: {}\n{why}", block.text)),
            },
            "text output" if !shows(&block.text, &printed) => {
                wrong.push(format!("{at}: shows\n{}\nbut the command prints\n{printed}", block.text));
            }
            _ => {}
        }
    }
    wrong
}

#[test]
fn commands_run_and_print_the_shown_output() {
    for needed in ["curl", "jq"] {
        let found = std::process::Command::new(needed).arg("--version").output();
        assert!(found.is_ok(), "install the programs that the pages use: tests/packages curl jq");
    }
    let pages = pages();
    let guides: Vec<&Page> = pages.iter().filter(|page| is_guide(page)).collect();
    assert!(guides.len() > 6, "guides are missing");
    // One after the other, because commands of concurrent pages could wait too long for their service.
    let wrong: Vec<String> = guides.into_iter().flat_map(follow).collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n\n"));
}

#[test]
fn no_page_has_a_placeholder() {
    // `@A1` and `@FIGURES@` are, `@types/node` and `name@HOST` are not.
    let is_placeholder = |word: &str| word.starts_with('@') && word[1..].starts_with(|c: char| c.is_ascii_uppercase());
    for page in pages() {
        let text = std::fs::read_to_string(root().join(&page.path)).unwrap();
        let found = text.split(|c: char| !c.is_alphanumeric() && c != '@').find(|word| is_placeholder(word));
        assert_eq!(found, None, "{}", page.path.display());
    }
}

#[test]
fn every_guide_is_in_the_index() {
    let index = Page::read("docs/README.md".as_ref());
    for page in pages().iter().filter(|page| page.path.starts_with("docs") && page.path != index.path) {
        let below_docs = page.path.strip_prefix("docs").unwrap();
        let is_linked = index.links.iter().any(|(_, (link, _))| below_docs.as_os_str() == link.as_str());
        assert!(is_linked, "{}", page.path.display());
    }
}

#[test]
fn links_are_valid() {
    let is_dead = |page: &Page, path: &str, fragment: &str| {
        let target = root().join(page.path.parent().unwrap()).join(path);
        let has = |page: &Page| page.headings.iter().any(|heading| heading == fragment);
        match (path.is_empty(), fragment.is_empty()) {
            (true, _) => !has(page),
            (false, true) => !target.exists(),
            (false, false) => !target.is_file() || !has(&Page::read(&target)),
        }
    };
    let dead = |page: &Page| -> Vec<String> {
        let dead = page.links.iter().filter(|(_, (path, fragment))| is_dead(page, path, fragment));
        dead.map(|(line, (path, fragment))| format!("{}: {path}#{fragment}", page.at(*line))).collect()
    };
    let pages = pages();
    let with_fragment = pages.iter().flat_map(|page| &page.links).filter(|(_, (_, fragment))| !fragment.is_empty());
    assert!(with_fragment.count() > 20, "fragments are not read");
    let dead: Vec<String> = pages.iter().flat_map(dead).collect();
    assert!(dead.is_empty(), "\n{}", dead.join("\n"));
}

#[test]
fn the_site_has_every_page_in_its_contents_and_no_link_leaves_it() {
    let book = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("site");
    let _ = std::fs::remove_dir_all(&book);
    let stage =
        std::process::Command::new("python3").arg("tools/site/stage.py").arg(&book).current_dir(root()).output();
    let stage = stage.expect("python3 is needed");
    assert!(stage.status.success(), "{}", String::from_utf8_lossy(&stage.stderr));
    let book = book.join("src");
    let contents = Page::read(&book.join("SUMMARY.md"));
    let chapters: Vec<&str> = contents.links.iter().map(|(_, (path, _))| path.as_str()).collect();
    for page in pages().iter().filter(|page| page.path.starts_with("docs")) {
        assert!(chapters.contains(&page.path.to_str().unwrap()), "{} is not in the contents", page.path.display());
    }
    for chapter in &chapters {
        let page = Page::read(&book.join(chapter));
        for (line, (path, _)) in page.links.iter().filter(|(_, (path, _))| !path.is_empty()) {
            let target = page.path.parent().unwrap().join(path);
            let is_written_later =
                ["rust/", "http/"].iter().any(|part| path.trim_start_matches("../").starts_with(part));
            assert!(is_written_later || target.is_file(), "{}: {path}", page.at(*line));
            let is_page = target.extension().is_some_and(|ending| ending == "md");
            let name = target.canonicalize().ok().filter(|_| is_page);
            let Some(name) = name.as_deref().and_then(|name| name.strip_prefix(book.canonicalize().unwrap()).ok())
            else {
                continue;
            };
            assert!(chapters.contains(&name.to_str().unwrap()), "{}: {path} is no chapter", page.at(*line));
        }
    }
}

#[test]
fn json_and_toml_on_the_pages_are_valid() {
    for page in &pages() {
        for block in &page.blocks {
            let why = match block.kind.as_str() {
                "json" => serde_json::from_str::<serde_json::Value>(&block.text).err().map(|why| why.to_string()),
                "toml" => toml::from_str::<toml::Table>(&block.text).err().map(|why| why.to_string()),
                _ => None,
            };
            assert!(why.is_none(), "{}: {}", page.at(block.line), why.unwrap_or_default());
        }
    }
}

#[test]
fn only_dots_stand_for_any_text() {
    assert!(shows("a … c\n", "a b c"));
    assert!(shows("a …\n… e", "a b\nc\nd e\n"));
    assert!(shows("a", "a\n") && shows("a … 1  2", "a b  1    2"));
    assert!(!shows("a", "a b") && !shows("a … c", "a b d") && !shows("… b", "a b c") && !shows("a … b … a", "a b"));
}
