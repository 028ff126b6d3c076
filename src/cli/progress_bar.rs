//! The progress of a run on the terminal.

use std::fmt;

use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use revprio_lab::report::number::significant;

/// The line of a terminal with enough columns. `wide_msg` gets the columns that are left, and is cut to them.
const LINE: &str = "{wide_msg} {bar:20} {pos:>6}/{len:6} {rate:>8} {eta:>5} left";

/// The line of a narrow terminal.
const SHORT_LINE: &str = "{wide_msg} {percent:>3} %";

/// Columns from which a terminal has room for [`LINE`].
const ROOM: u16 = 72;

/// Returns a progress bar of one line; it is hidden without a terminal.
pub fn progress_bar(periods: u64, label: &str) -> ProgressBar {
    let (_, columns) = console::Term::stderr().size();
    let style = style(if columns < ROOM { SHORT_LINE } else { LINE });
    let bar = ProgressBar::new(periods).with_message(label.to_owned());
    style.map_or(bar.clone(), |style| bar.with_style(style))
}

fn style(template: &str) -> Option<ProgressStyle> {
    let rate = |state: &ProgressState, text: &mut dyn fmt::Write| {
        let _ = write!(text, "{}/s", significant(state.per_sec(), 3));
    };
    Some(ProgressStyle::with_template(template).ok()?.with_key("rate", rate))
}

#[cfg(test)]
mod tests {
    use std::io;
    use std::sync::{Arc, Mutex};

    use indicatif::{ProgressDrawTarget, TermLike};

    use super::*;

    /// A terminal that keeps what is written.
    #[derive(Debug, Clone)]
    struct Terminal {
        columns: u16,
        written: Arc<Mutex<String>>,
    }

    impl TermLike for Terminal {
        fn width(&self) -> u16 {
            self.columns
        }

        fn move_cursor_up(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_down(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_right(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_left(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn write_line(&self, text: &str) -> io::Result<()> {
            self.write_str(&format!("{text}\n"))
        }

        fn write_str(&self, text: &str) -> io::Result<()> {
            self.written.lock().unwrap().push_str(text);
            Ok(())
        }

        fn clear_line(&self) -> io::Result<()> {
            self.written.lock().unwrap().clear();
            Ok(())
        }

        fn flush(&self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_bar_takes_one_line_whatever_its_label_and_the_width() {
        for (columns, template) in [(80, LINE), (ROOM, LINE), (ROOM - 1, SHORT_LINE), (20, SHORT_LINE)] {
            let terminal = Terminal { columns, written: Arc::default() };
            let label = "stiff_wall_acceleration_slow, strict_reverse_priority, closed_form, and more and more of it";
            let bar = ProgressBar::new(1_000_000).with_message(label);
            bar.set_draw_target(ProgressDrawTarget::term_like(Box::new(terminal.clone())));
            bar.set_style(style(template).unwrap());
            bar.set_position(123_456);
            bar.tick();
            let written = terminal.written.lock().unwrap().clone();
            let line = written.split(['\n', '\r']).rfind(|line| !line.is_empty()).unwrap();
            assert!(line.chars().count() <= usize::from(columns), "{columns}: {line} in {written:?}");
            assert!(line.starts_with("stiff_"), "{line}");
        }
    }
}
