//! Text for standard output and standard error.

use std::fmt::Display;
use std::io::{ErrorKind, Result, Write as _, stderr, stdout};

/// Prints a text to standard output.
///
/// A reader that ends early, such as `head`, closes the pipe: it has all that it wants, and this is no error.
pub fn print_text(text: impl Display) -> Result<()> {
    let mut out = stdout().lock();
    without_broken_pipe(write!(out, "{text}").and_then(|()| out.flush()))
}

/// Prints a remark to standard error. There is nobody to tell if this fails, and the command goes on.
pub fn print_remark(text: impl Display) {
    let _ = writeln!(stderr(), "{text}");
}

fn without_broken_pipe(written: Result<()>) -> Result<()> {
    match written {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_broken_pipe_is_no_error() {
        assert!(without_broken_pipe(Err(ErrorKind::BrokenPipe.into())).is_ok());
        let full = without_broken_pipe(Err(ErrorKind::StorageFull.into()));
        assert_eq!(full.unwrap_err().kind(), ErrorKind::StorageFull);
    }
}
