//! Which log lines are written.

use tracing::level_filters::LevelFilter;
use tracing_subscriber::filter::Targets;

/// Reads a level, or a list of levels and of targets with levels: `info`, `warn,revprio=debug`. Returns `None` for other texts.
///
/// A word alone that is no level, such as `warning`, would be a target: all lines of other targets would be left out.
pub fn log_filter(text: &str) -> Option<Targets> {
    // The parser takes no word at all for `error`.
    let is_level = |word: &str| !word.trim().is_empty() && word.trim().parse::<LevelFilter>().is_ok();
    let is_directive = |part: &str| match part.split_once('=') {
        Some((target, level)) => !target.trim().is_empty() && is_level(level),
        None => is_level(part),
    };
    text.split(',').all(is_directive).then(|| text.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_and_targets_with_levels_are_filters() {
        for text in ["off", "error", "warn", "info", "debug", "trace", "INFO", "info,revprio=debug", "revprio=off"] {
            assert!(log_filter(text).is_some(), "{text}");
        }
    }

    #[test]
    fn other_words_are_none() {
        for text in ["warning", "bogus", "", "info,", "revprio", "revprio=loud", "=info", "a=b=c", "info,bogus"] {
            assert!(log_filter(text).is_none(), "{text}");
        }
    }
}
