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
fn every_guide_is_in_the_index() {
    let index = Page::read("docs/README.md".as_ref());
    for page in pages().iter().filter(|page| page.path.starts_with("docs") && page.path != index.path) {
        let below_docs = page.path.strip_prefix("docs").unwrap();
        assert!(index.links.iter().any(|(_, link)| below_docs.as_os_str() == link.as_str()), "{}", page.path.display());
    }
}

#[test]
fn links_are_valid() {
    let dead = |page: &Page| -> Vec<String> {
        let directory = root().join(page.path.parent().unwrap());
        let missing = page.links.iter().filter(|(_, link)| !directory.join(link).exists());
        missing.map(|(line, link)| format!("{}: {link}", page.at(*line))).collect()
    };
    let dead: Vec<String> = pages().iter().flat_map(dead).collect();
    assert!(dead.is_empty(), "\n{}", dead.join("\n"));
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
