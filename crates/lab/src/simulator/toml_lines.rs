//! Line numbers of fields in a TOML text.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Returns the line (from 1) of the field at a JSON pointer, or of the nearest enclosing field; `None` if the text is not
/// TOML.
pub fn line_of(text: &str, pointer: &str) -> Option<usize> {
    let table = DeTable::parse(text).ok()?;
    let mut at = table.span().start;
    let mut value: Option<&DeValue> = None;
    for word in pointer.split('/').skip(1) {
        let inner: Option<&Spanned<DeValue>> = match value {
            None => entry(table.get_ref(), word, &mut at),
            Some(DeValue::Table(table)) => entry(table, word, &mut at),
            Some(DeValue::Array(array)) => word.parse().ok().and_then(|i: usize| array.get(i)).inspect(|item| {
                at = item.span().start;
            }),
            Some(_) => None,
        };
        let Some(inner) = inner else { break };
        value = Some(inner.get_ref());
    }
    Some(text[..at].matches('\n').count() + 1)
}

/// Returns the value of a key and sets `at` to the position of the key.
fn entry<'a, 'i>(table: &'a DeTable<'i>, word: &str, at: &mut usize) -> Option<&'a Spanned<DeValue<'i>>> {
    let (key, value) = table.iter().find(|(key, _)| key.get_ref() == word)?;
    *at = key.span().start;
    Some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a = 1\n\n[[list]]\nb = 2\n\n[[list]]\nb = 3\nc = { d = [\n  4,\n  5] }\n";

    #[test]
    fn line_of_a_field_is_the_line_of_its_key() {
        let line = |pointer| line_of(TEXT, pointer).unwrap();
        assert_eq!(["/a", "/list/0/b", "/list/1/b", "/list/1/c/d/1"].map(line), [1, 4, 7, 10]);
    }

    #[test]
    fn line_of_a_missing_field_is_the_line_of_its_table() {
        assert_eq!(line_of(TEXT, "/list/1/missing"), Some(6));
        assert_eq!(line_of("not toml", "/a"), None);
    }
}
