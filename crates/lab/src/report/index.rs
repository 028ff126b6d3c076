//! Indices in plain text. In `F_x`, with one character on either side of the underscore, `x` is an index.
//! `force_tracking` has no index.

/// A part of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Piece<'a> {
    /// Normal text.
    Line(&'a str),
    /// An index.
    Index(&'a str),
}

/// Splits a text into normal text and indices, in order.
#[must_use]
pub fn pieces(text: &str) -> Vec<Piece<'_>> {
    let mut pieces = Vec::new();
    let mut from = 0;
    for (at, _) in text.match_indices('_') {
        if let Some(end) = index_end(text, at) {
            pieces.push(Piece::Line(&text[from..at]));
            pieces.push(Piece::Index(&text[at + 1..end]));
            from = end;
        }
    }
    pieces.push(Piece::Line(&text[from..]));
    pieces.retain(|piece| *piece != Piece::Line(""));
    pieces
}

/// Returns the end of the index after the underscore at `at`; `None` if the underscore is part of a name.
fn index_end(text: &str, at: usize) -> Option<usize> {
    let mut before = text[..at].chars().rev();
    let mut after = text[at + 1..].chars();
    let symbol = before.next().is_some_and(char::is_alphabetic);
    let index = after.next().filter(|c| c.is_alphanumeric())?;
    let is_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    let alone = symbol && !is_word(before.next()) && !is_word(after.next());
    alone.then(|| at + 1 + index.len_utf8())
}

#[cfg(test)]
mod tests {
    use super::Piece::{Index, Line};
    use super::pieces;

    #[test]
    fn symbols_have_an_index() {
        assert_eq!(pieces("F_x, F_y (N)"), [Line("F"), Index("x"), Line(", F"), Index("y"), Line(" (N)")]);
        assert_eq!(pieces("−λ_2"), [Line("−λ"), Index("2")]);
    }

    #[test]
    fn names_have_no_index() {
        for name in ["force_tracking", "x_axis", "stiff_w", "_x", "a_", "a_b_c", ""] {
            let whole: Vec<_> = [Line(name)].into_iter().filter(|_| !name.is_empty()).collect();
            assert_eq!(pieces(name), whole);
        }
    }
}
