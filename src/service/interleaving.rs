//! Clients that step the same session alternately.

/// Where a state comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// A request.
    Request,
    /// The stream with this number.
    Stream(u64),
}

/// Number of steps after which a source counts as given up.
const REMEMBERED_STEPS: u32 = 100;

/// Finds clients that step the same session alternately.
#[derive(Debug, Default)]
pub struct Interleaving {
    /// States refused since the last step because their sequence number was too low.
    refused: u64,
    /// The last source, and the source before it with the number of steps since then.
    last: Option<Source>,
    before: Option<(Source, u32)>,
}

impl Interleaving {
    /// Counts a state whose sequence number was too low.
    pub fn count_refused(&mut self) {
        self.refused += 1;
    }

    /// Counts a step, and adds a warning if another client seems to step the same session.
    pub fn count_step(&mut self, source: Source, warnings: &mut Vec<String>) {
        let refused = std::mem::take(&mut self.refused);
        let came_back = self.last != Some(source) && self.before.is_some_and(|(before, _)| before == source);
        match &mut self.before {
            _ if self.last != Some(source) => self.before = self.last.map(|last| (last, 0)),
            Some((_, steps)) if *steps < REMEMBERED_STEPS => *steps += 1,
            before => *before = None,
        }
        self.last = Some(source);
        if refused == 0 && !came_back {
            return;
        }
        let seen = if came_back {
            "states come from two connections alternately".to_owned()
        } else {
            format!("{refused} states with lower sequence numbers were refused since the last step")
        };
        warnings.push(format!(
            "{seen}: two clients step this session. Give each arm one client, and open the session with an owner token \
             (header `Revprio-Owner`)"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the steps, from 0, that get a warning.
    fn warned(sources: &[Source]) -> Vec<usize> {
        let mut interleaving = Interleaving::default();
        let warned = |(i, source): (usize, &Source)| {
            let mut warnings = Vec::new();
            interleaving.count_step(*source, &mut warnings);
            (!warnings.is_empty()).then_some(i)
        };
        sources.iter().enumerate().filter_map(warned).collect()
    }

    #[test]
    fn sources_that_alternate_are_reported() {
        use Source::{Request, Stream};
        assert_eq!(warned(&[Request, Stream(1), Request, Stream(1)]), [2, 3]);
        assert_eq!(warned(&[Stream(1), Stream(1), Stream(2), Stream(2), Stream(1)]), [4]);
        // A stream that replaces requests, or a stream after a broken stream.
        assert_eq!(warned(&[Request, Request, Stream(1), Stream(1), Stream(2)]), [0; 0]);
        // A source is given up 100 steps after the first one of the next source.
        let after = |steps: usize| warned(&[vec![Stream(1)], vec![Request; 1 + steps], vec![Stream(1)]].concat());
        assert_eq!((after(100), after(101)), (vec![102], vec![]));
    }
}
