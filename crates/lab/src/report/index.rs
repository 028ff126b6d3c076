//! Indices in plain text: in `F_x`, a single character on either side of the underscore, the `x` is
//! an index; `force_tracking` stays a name.

/// A stretch of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Piece<'a> {
    /// On the line.
    Line(&'a str),
    /// To be set smaller and lower.
    Index(&'a str),
}

/// Splits a text into what stands on the line and what is an index, in order.
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

/// Where the index behind the underscore at `at` ends; `None` when the underscore is part of a name.
fn index_end(text: &str, at: usize) -> Option<usize> {
    let mut before = text[..at].chars().rev();
    let mut after = text[at + 1..].chars();
    let symbol = before.next().is_some_and(char::is_alphabetic);
    let index = after.next().filter(|c| c.is_alphanumeric())?;
    let goes_on = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    let alone = symbol && !goes_on(before.next()) && !goes_on(after.next());
    alone.then(|| at + 1 + index.len_utf8())
}

#[cfg(test)]
mod tests {
    use super::Piece::{Index, Line};
    use super::pieces;

    #[test]
    fn a_symbol_has_an_index() {
        assert_eq!(pieces("F_x, F_y (N)"), [Line("F"), Index("x"), Line(", F"), Index("y"), Line(" (N)")]);
        assert_eq!(pieces("−λ_2"), [Line("−λ"), Index("2")]);
    }

    #[test]
    fn a_name_has_none() {
        for name in ["force_tracking", "x_axis", "stiff_w", "_x", "a_", "a_b_c", ""] {
            let whole: Vec<_> = [Line(name)].into_iter().filter(|_| !name.is_empty()).collect();
            assert_eq!(pieces(name), whole);
        }
    }
}
