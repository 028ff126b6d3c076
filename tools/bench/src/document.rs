//! Files, and marked tables of Markdown documents.

use std::fs;
use std::path::Path;

use super::error::BenchError;

/// Replaces every text between `<!-- bench:NAME -->` and `<!-- end -->`.
pub fn filled(text: &str, name: &str, content: &str) -> String {
    let (begin, end) = (format!("<!-- bench:{name} -->\n"), "<!-- end -->");
    let mut parts = text.split(&begin);
    let mut whole = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let after = part.find(end).map_or("", |at| &part[at..]);
        whole.extend([begin.as_str(), "\n", content, "\n", after]);
    }
    whole
}

pub fn read(path: &Path) -> Result<String, BenchError> {
    fs::read_to_string(path).map_err(|source| BenchError::File { path: path.to_owned(), source })
}

pub fn read_bytes(path: &Path) -> Result<Vec<u8>, BenchError> {
    fs::read(path).map_err(|source| BenchError::File { path: path.to_owned(), source })
}

pub fn write(path: &Path, text: &str) -> Result<(), BenchError> {
    fs::write(path, text).map_err(|source| BenchError::File { path: path.to_owned(), source })
}

pub fn make_directory(path: &Path) -> Result<(), BenchError> {
    fs::create_dir_all(path).map_err(|source| BenchError::File { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_text_between_the_marks_is_replaced() {
        let text = "a\n<!-- bench:x -->\n\nold\n\n<!-- end -->\nb\n<!-- bench:y -->\n<!-- end -->\n";
        let expected = "a\n<!-- bench:x -->\n\nnew\n\n<!-- end -->\nb\n<!-- bench:y -->\n<!-- end -->\n";
        assert_eq!(filled(text, "x", "new\n"), expected);
        assert_eq!(filled(expected, "x", "new\n"), expected);
        assert_eq!(filled("no marks", "x", "new"), "no marks");
    }
}
