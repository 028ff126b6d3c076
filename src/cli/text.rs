//! Text for a terminal of 100 columns.

use std::ffi::OsString;

use console::{Style, StyledObject};

/// Columns of a terminal that every output fits.
pub const WIDTH: usize = 100;

/// Breaks a text between words, into lines of at most `width` characters.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Returns the program with these arguments as a line for a shell.
pub fn command_line(arguments: &[OsString]) -> String {
    let arguments = arguments.iter().map(|argument| quoted(&argument.to_string_lossy()));
    std::iter::once("revprio".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// Returns an argument as a shell reads it.
pub fn quoted(argument: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-./,=:@%+".contains(c);
    if argument.chars().all(is_plain) && !argument.is_empty() {
        argument.to_owned()
    } else {
        format!("'{}'", argument.replace('\'', r"'\''"))
    }
}

/// Formats rows as aligned columns; `is_number`: columns that are aligned to the right.
pub fn columns(rows: &[Vec<String>], is_number: impl Fn(usize) -> bool) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let length = |cell: &String| cell.chars().count();
    let widths: Vec<usize> =
        (0..count).map(|i| rows.iter().filter_map(|row| row.get(i)).map(length).max().unwrap_or(0)).collect();
    let cell = |(i, cell): (usize, &String)| {
        let width = widths[i];
        if is_number(i) { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
    };
    let line = |row: &Vec<String>| row.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ");
    rows.iter().map(|row| line(row).trim_end().to_owned() + "\n").collect()
}

/// Shows good news in green and bad news in red, if standard output is a terminal and `NO_COLOR` is not set.
pub fn judged<T>(value: T, is_good: bool) -> StyledObject<T> {
    let style = if is_good { Style::new().green() } else { Style::new().red().bold() };
    style.for_stdout().apply_to(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_breaks_between_words() {
        assert_eq!(wrapped("one two three", 7), ["one two", "three"]);
        assert_eq!(wrapped("a-word-that-is-too-long b", 4), ["a-word-that-is-too-long", "b"]);
        assert!(wrapped("", 10).is_empty());
    }

    #[test]
    fn a_command_line_can_be_pasted_into_a_shell() {
        let line = |arguments: &[&str]| command_line(&arguments.iter().map(OsString::from).collect::<Vec<_>>());
        assert_eq!(
            line(&["demo", "--out", "/tmp/a-1", "--traces", "csv,mcap"]),
            "revprio demo --out /tmp/a-1 --traces csv,mcap"
        );
        assert_eq!(line(&["demo", "--out", "my results"]), "revprio demo --out 'my results'");
        assert_eq!(line(&["demo", "--out", "it's"]), r"revprio demo --out 'it'\''s'");
    }

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let rows = [vec!["a".to_owned(), "1".to_owned()], vec!["bcd".to_owned(), "23".to_owned()]];
        assert_eq!(columns(&rows, |i| i == 1), "a     1\nbcd  23\n");
    }
}
