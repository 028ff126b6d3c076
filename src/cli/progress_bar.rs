//! The progress of a run on the terminal.

use std::fmt;

use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use revprio_lab::report::number::significant;

/// Returns a progress bar; it is hidden without a terminal.
pub fn progress_bar(periods: u64, label: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix:<60} {bar:30} {pos:>6}/{len} {rate:>8}, {eta} left");
    let rate = |state: &ProgressState, text: &mut dyn fmt::Write| {
        let _ = write!(text, "{}/s", significant(state.per_sec(), 3));
    };
    let style = style.map(|style| style.with_key("rate", rate));
    let bar = ProgressBar::new(periods).with_prefix(label.to_owned());
    style.map_or(bar.clone(), |style| bar.with_style(style))
}
