//! What the paper claims of its two examples, against what the runs show.
//!
//! The words are ours; each claim names the place in Su et al., *Materials* 2022, 15, 6611.

use super::experiment::{COINCIDE, Run};
use super::metrics::{Metrics, largest_difference};
use super::notes::of_method;
use super::number::significant;
use super::paper_figures::{CLASSICAL, REVERSE_PRIORITY};

/// A force that stays this near to its target (RMSE, N) follows it: 5 % of the paper's 30 N.
const FOLLOWS: f64 = 1.5;
/// A contact that ends this near to its target (N) is a stable one.
const HOLDS: f64 = 0.01;

/// A claim and what came of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Claim {
    /// Where the paper says it.
    pub place: &'static str,
    /// What it says, in our words.
    pub claim: &'static str,
    /// Name of the scenario that it was tried in.
    pub scenario: String,
    /// What was measured.
    pub measured: String,
    /// Whether it was seen.
    pub verdict: Verdict,
}

/// Whether a claim was seen in the runs of a scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Yes.
    Seen,
    /// No difference between the methods: both keep it.
    NoDifference,
    /// No.
    NotSeen,
}

impl Verdict {
    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Seen => "seen",
            Self::NoDifference => "no difference here",
            Self::NotSeen => "not seen",
        }
    }
}

/// The claims that the runs can judge: those of scenarios of the paper for which both of its methods were run.
#[must_use]
pub fn of_runs(runs: &[Run]) -> Vec<Claim> {
    runs.chunk_by(|a, b| a.recording.scenario == b.recording.scenario).flat_map(of_scenario).collect()
}

/// The two methods in one scenario.
struct Pair<'a> {
    reverse: &'a Run,
    classical: &'a Run,
}

fn of_scenario(runs: &[Run]) -> Vec<Claim> {
    let methods = (of_method(runs, REVERSE_PRIORITY), of_method(runs, CLASSICAL));
    let (Some(reverse), Some(classical)) = methods else { return Vec::new() };
    let pair = Pair { reverse, classical };
    match runs[0].recording.scenario.as_str() {
        "force_tracking" | "force_tracking_singular" => tracking(&pair),
        "stiff_wall" | "stiff_wall_singular" => wall(&pair),
        _ => Vec::new(),
    }
}

impl Pair<'_> {
    fn metrics(&self) -> [Metrics; 2] {
        [self.reverse, self.classical].map(|run| Metrics::of(&run.recording))
    }

    fn difference(&self) -> f64 {
        largest_difference(&self.reverse.recording, &self.classical.recording)
    }

    fn claim(&self, place: &'static str, claim: &'static str, measured: String, verdict: Verdict) -> Claim {
        Claim { place, claim, scenario: self.reverse.recording.scenario.clone(), measured, verdict }
    }

    /// Better, the same to rounding, or not better.
    fn better(&self, is_better: bool) -> Verdict {
        match is_better {
            _ if self.difference() <= COINCIDE => Verdict::NoDifference,
            true => Verdict::Seen,
            false => Verdict::NotSeen,
        }
    }

    fn coincide(&self) -> String {
        format!("both methods command the same, to {} rad/s", significant(self.difference(), 2))
    }
}

fn seen(seen: bool) -> Verdict {
    if seen { Verdict::Seen } else { Verdict::NotSeen }
}

fn tracking(pair: &Pair) -> Vec<Claim> {
    let [Some(reverse), Some(classical)] = pair.metrics().map(|metrics| metrics.rmse_fx) else { return Vec::new() };
    let both = format!("RMSE of F_x {} N against {} N", significant(reverse, 3), significant(classical, 3));
    let comparison = if pair.difference() <= COINCIDE { pair.coincide() } else { both };
    vec![
        pair.claim(
            "5.1, Figure 5",
            "with reverse priority the tool follows a force that swings slowly between 25 and 35 N",
            format!("RMSE of F_x {} N", significant(reverse, 3)),
            seen(reverse <= FOLLOWS),
        ),
        pair.claim(
            "5.1, Figures 5 and 6",
            "F_x, the primary task, is followed visibly better than by the classical control",
            comparison,
            pair.better(reverse < classical),
        ),
    ]
}

fn wall(pair: &Pair) -> Vec<Claim> {
    let [reverse, classical] = pair.metrics();
    let ends = |metrics: &Metrics| match (metrics.first_contact_s, metrics.final_force) {
        (Some(time), Some(force)) => {
            format!("touches after {} s, ends at {} N", significant(time, 3), significant(force, 5))
        }
        _ => "does not reach the wall".to_owned(),
    };
    let holds = |metrics: &Metrics| {
        metrics.first_contact_s.is_some() && metrics.steady_error.is_some_and(|error| error.abs() <= HOLDS)
    };
    let comparison = if pair.difference() <= COINCIDE {
        pair.coincide()
    } else {
        format!("reverse priority {}, the classical control {}", ends(&reverse), ends(&classical))
    };
    let better = holds(&reverse) && !holds(&classical);
    vec![
        pair.claim(
            "5.2, Figure 7",
            "the tool approaches an aluminium wall, touches it and stays at a steady 30 N",
            format!(
                "{}, after a peak of {} N in {} contacts",
                ends(&reverse),
                significant(reverse.peak_force, 3),
                reverse.contacts
            ),
            seen(holds(&reverse)),
        ),
        pair.claim(
            "5.2, Figures 7 and 8",
            "reverse priority surpasses the classical control on the way to the wall and at it",
            comparison,
            pair.better(better),
        ),
    ]
}
