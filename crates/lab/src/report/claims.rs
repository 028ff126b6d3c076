//! Claims of the paper about its two examples, compared with the measured runs.
//!
//! The claims are paraphrased. Each names its place in Su et al., *Materials* 2022, 15, 6611.

use super::comparison::MethodPair;
use super::run::Run;
use crate::metrics::Metrics;
use crate::number::{significant, trimmed};
use crate::simulator::Scenario;

/// Largest RMSE (N) of a force that counts as following its target: 5 % of the paper's 30 N.
const MAX_TRACKING_RMSE: f64 = 1.5;
/// Largest steady error (N) of a contact that counts as settled.
const MAX_STEADY_ERROR: f64 = 0.01;

/// A claim and its result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Claim {
    /// Section and figures of the paper.
    pub place: &'static str,
    /// The claim, paraphrased.
    pub claim: &'static str,
    /// Name of the scenario that tests it.
    pub scenario: String,
    /// The measured values.
    pub measured: String,
    /// The result.
    pub verdict: Verdict,
}

/// Whether the runs of a scenario confirm a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The runs confirm it.
    Confirmed,
    /// Both methods give the same commands.
    NoDifference,
    /// The runs do not confirm it.
    NotConfirmed,
    /// The runs are shorter than the experiment of the paper.
    NotJudged,
}

impl Verdict {
    /// Returns the verdict as text.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::NoDifference => "no difference",
            Self::NotConfirmed => "not confirmed",
            Self::NotJudged => "not judged",
        }
    }

    const fn from_bool(is_confirmed: bool) -> Self {
        if is_confirmed { Self::Confirmed } else { Self::NotConfirmed }
    }
}

/// Returns the claims for each of the paper's scenarios in which both methods were run. A changed scenario has none.
#[must_use]
pub fn of_runs(runs: &[Run]) -> Vec<Claim> {
    runs.chunk_by(|a, b| a.recording.scenario == b.recording.scenario).flat_map(of_scenario).collect()
}

fn of_scenario(runs: &[Run]) -> Vec<Claim> {
    let Some(pair) = MethodPair::from_runs(runs).filter(MethodPair::is_built_in) else { return Vec::new() };
    let name = runs[0].recording.scenario.as_str();
    let claims = match name {
        "force_tracking" | "force_tracking_singular" => tracking(&pair),
        "stiff_wall" | "stiff_wall_singular" => wall(&pair),
        _ => return Vec::new(),
    };
    let shortest = runs.iter().map(|run| run.scenario.duration_s).fold(f64::INFINITY, f64::min);
    let whole = Scenario::find(name).map_or(0.0, |scenario| scenario.duration_s);
    if shortest >= whole {
        return claims;
    }
    let measured = format!("only the first {} s of {} s ran", trimmed(shortest), trimmed(whole));
    claims.into_iter().map(|claim| not_judged(claim, &measured)).collect()
}

/// Returns a claim without a result. A part of an experiment can neither confirm nor refute it.
fn not_judged(claim: Claim, measured: &str) -> Claim {
    Claim { measured: measured.to_owned(), verdict: Verdict::NotJudged, ..claim }
}

fn metrics(pair: &MethodPair) -> [Metrics; 2] {
    [pair.reverse, pair.classical].map(|run| Metrics::of(&run.recording))
}

fn claim(pair: &MethodPair, place: &'static str, claim: &'static str, measured: String, verdict: Verdict) -> Claim {
    Claim { place, claim, scenario: pair.reverse.recording.scenario.clone(), measured, verdict }
}

/// A claim that reverse priority is better; `measured` describes two runs that differ.
fn comparison(pair: &MethodPair, place: &'static str, text: &'static str, measured: String, better: bool) -> Claim {
    if !pair.coincide() {
        return claim(pair, place, text, measured, Verdict::from_bool(better));
    }
    let measured = match pair.difference() {
        0.0 => "both methods command identical joint velocities".to_owned(),
        difference => format!("the commands differ by at most {} rad/s", significant(difference, 2)),
    };
    claim(pair, place, text, measured, Verdict::NoDifference)
}

fn tracking(pair: &MethodPair) -> Vec<Claim> {
    let [Some(reverse), Some(classical)] = metrics(pair).map(|metrics| metrics.rmse_fx) else { return Vec::new() };
    vec![
        claim(
            pair,
            "5.1, Figure 5",
            "with reverse priority, the force follows a target that oscillates slowly between 25 and 35 N",
            format!("RMSE of F_x {} N", significant(reverse, 3)),
            Verdict::from_bool(reverse <= MAX_TRACKING_RMSE),
        ),
        comparison(
            pair,
            "5.1, Figures 5 and 6",
            "reverse priority tracks F_x, the primary task, visibly better than the classical control",
            format!("RMSE of F_x {} N; classical control {} N", significant(reverse, 3), significant(classical, 3)),
            reverse < classical,
        ),
    ]
}

fn wall(pair: &MethodPair) -> Vec<Claim> {
    let [reverse, classical] = metrics(pair);
    let result = |metrics: &Metrics| match (metrics.first_contact_s, metrics.final_force) {
        (Some(time), Some(force)) => {
            format!("first contact at {} s, final force {} N", significant(time, 3), significant(force, 5))
        }
        _ => "does not reach the wall".to_owned(),
    };
    let settles = |metrics: &Metrics| {
        metrics.first_contact_s.is_some() && metrics.steady_error.is_some_and(|error| error.abs() <= MAX_STEADY_ERROR)
    };
    let (peak, contacts) = (significant(reverse.peak_force, 3), reverse.contacts);
    vec![
        claim(
            pair,
            "5.2, Figure 7",
            "the tool approaches an aluminium wall, touches it and settles at 30 N",
            format!("{}, peak {peak} N, {contacts} contacts", result(&reverse)),
            Verdict::from_bool(settles(&reverse)),
        ),
        comparison(
            pair,
            "5.2, Figures 7 and 8",
            "reverse priority is better than the classical control during the approach and in contact",
            format!("reverse priority: {}; classical control: {}", result(&reverse), result(&classical)),
            settles(&reverse) && !settles(&classical),
        ),
    ]
}
