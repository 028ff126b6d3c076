//! Checks that the solver `qp` called Clarabel, that Clarabel was accurate, and that its answers are certified. Each returns
//! what is wrong, in words.
//!
//! The answers of all solvers can agree although Clarabel is inaccurate: the polish of a level needs nothing but the right
//! active set. These checks look at Clarabel's own answers, before the polish.

use revprio_api::wire::{Solver, Status};

use super::run::Run;
use crate::number::significant;
use crate::simulator::recording::{ClarabelLevels, PRECISE, Recording};

/// Largest share of levels whose residual before the polish is above [`PRECISE`]. `docs/testing.md` has the measured shares.
pub const MAX_IMPRECISE: f64 = 0.01;

/// Largest share of answers that are not certified.
pub const MAX_NOT_CERTIFIED: f64 = 0.01;

/// Returns what is wrong with the runs of the solver `qp`.
#[must_use]
pub fn clarabel_failures(runs: &[Run]) -> Vec<String> {
    let recordings = runs.iter().map(|run| &run.recording).filter(|recording| recording.solver == Solver::Qp);
    recordings
        .flat_map(|recording| [not_called(recording), inaccuracy(recording), uncertainty(recording)])
        .flatten()
        .collect()
}

/// Returns what Clarabel did in all runs of the solver `qp` together; `None` without such a run, and for runs that were read
/// from files, which do not have it.
#[must_use]
pub fn of_all(runs: &[Run]) -> Option<ClarabelLevels> {
    let recordings = runs.iter().map(|run| &run.recording).filter(|recording| recording.solver == Solver::Qp);
    recordings.filter_map(|recording| recording.clarabel).reduce(ClarabelLevels::and)
}

/// Describes [`of_all`] in two lines of up to 98 columns.
#[must_use]
pub fn lines(levels: &ClarabelLevels) -> [String; 2] {
    let calls = format!(
        "Clarabel: {} levels in {} answers of qp, {} iterations per level",
        levels.count,
        levels.answers,
        significant(levels.iterations as f64 / levels.count as f64, 2),
    );
    let residuals = format!(
        "residuals: up to {} before and {} after the polish; before it, {} are above {PRECISE:e}",
        significant(levels.largest_residual, 2),
        significant(levels.largest_polished, 2),
        percent(levels.imprecise as f64 / levels.count as f64),
    );
    [calls, residuals]
}

fn label(recording: &Recording) -> String {
    format!("{}, {}", recording.scenario, recording.method)
}

fn answered(recording: &Recording) -> u64 {
    recording.samples.iter().filter(|sample| sample.answered).count() as u64
}

/// Returns how many answers have no level that Clarabel solved; `None` if none.
fn not_called(recording: &Recording) -> Option<String> {
    let (all, answered) = (answered(recording), recording.clarabel.unwrap_or_default().answers);
    (answered < all).then(|| {
        let missing = all - answered;
        format!("{}: Clarabel solved no level in {missing} of {all} answers of the solver qp", label(recording))
    })
}

/// Returns how many levels Clarabel solved inaccurately; `None` if hardly any.
fn inaccuracy(recording: &Recording) -> Option<String> {
    let levels = recording.clarabel?;
    let share = levels.imprecise as f64 / levels.count as f64;
    (share > MAX_IMPRECISE).then(|| {
        format!(
            "{}: before the polish, Clarabel's relative residual is above {PRECISE:e} at {} of the levels, at most {} are \
             normal; the largest one is {}",
            label(recording),
            percent(share),
            percent(MAX_IMPRECISE),
            significant(levels.largest_residual, 2),
        )
    })
}

/// Returns how many answers are not certified; `None` if hardly any.
fn uncertainty(recording: &Recording) -> Option<String> {
    let samples = recording.samples.iter().filter(|sample| sample.answered);
    let unsure = samples.filter(|sample| sample.status != Status::Optimal).count();
    let share = unsure as f64 / answered(recording).max(1) as f64;
    (share > MAX_NOT_CERTIFIED).then(|| {
        format!(
            "{}: {} of the answers of the solver qp are not certified, at most {} are normal",
            label(recording),
            percent(share),
            percent(MAX_NOT_CERTIFIED),
        )
    })
}

fn percent(share: f64) -> String {
    if share > 0.0 { format!("{} %", significant(100.0 * share, 2)) } else { "0 %".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::recording::Sample;

    /// A run of `qp` with 200 answers of two levels each, of which some are imprecise or not certified.
    fn run(imprecise: u64, not_certified: usize) -> Run {
        let status = |i| if i < not_certified { Status::NotCertified } else { Status::Optimal };
        let samples = (0..200).map(|i| Sample { status: status(i), ..Sample::at_rest() }).collect();
        let clarabel = ClarabelLevels {
            answers: 200,
            count: 400,
            iterations: 2600,
            imprecise,
            largest_residual: if imprecise > 0 { 3e-4 } else { 2e-9 },
            largest_polished: 1e-15,
        };
        Run::of(Recording { solver: Solver::Qp, samples, clarabel: Some(clarabel), ..Recording::empty() })
    }

    #[test]
    fn an_accurate_and_certified_run_has_no_failure() {
        assert!(clarabel_failures(&[run(0, 0)]).is_empty());
        assert!(clarabel_failures(&[run(4, 2)]).is_empty());
    }

    #[test]
    fn a_run_without_clarabel_fails() {
        let mut runs = [run(0, 0)];
        runs[0].recording.clarabel = None;
        let none = ["stiff_wall, reverse_priority: Clarabel solved no level in 200 of 200 answers of the solver qp"];
        assert_eq!(clarabel_failures(&runs), none);
        // The other solvers do not call it.
        runs[0].recording.solver = Solver::Auto;
        assert!(clarabel_failures(&runs).is_empty());
    }

    #[test]
    fn one_answer_without_clarabel_fails() {
        let mut runs = [run(0, 0)];
        runs[0].recording.clarabel.as_mut().unwrap().answers = 199;
        let failures = clarabel_failures(&runs);
        assert!(failures.len() == 1 && failures[0].contains("no level in 1 of 200 answers"), "{failures:?}");
    }

    #[test]
    fn inaccurate_answers_of_clarabel_fail() {
        let words = "stiff_wall, reverse_priority: before the polish, Clarabel's relative residual is above 1e-6 at 1.2 % of \
                     the levels, at most 1.0 % are normal; the largest one is 3.0e-4";
        assert_eq!(clarabel_failures(&[run(5, 0)]), [words]);
    }

    #[test]
    fn answers_that_are_not_certified_fail() {
        let words = "stiff_wall, reverse_priority: 1.5 % of the answers of the solver qp are not certified, at most 1.0 % are \
                     normal";
        assert_eq!(clarabel_failures(&[run(0, 3)]), [words]);
    }

    #[test]
    fn the_lines_count_all_runs_of_qp() {
        let mut runs = [run(4, 0), run(0, 0), run(0, 0)];
        runs[2].recording.solver = Solver::Auto;
        let [calls, residuals] = lines(&of_all(&runs).unwrap());
        assert_eq!(calls, "Clarabel: 800 levels in 400 answers of qp, 6.5 iterations per level");
        let all = "residuals: up to 3.0e-4 before and 1.0e-15 after the polish; before it, 0.50 % are above 1e-6";
        assert_eq!(residuals, all);
        assert!(all.chars().count() <= 98);
        assert_eq!(of_all(&runs[2..]), None);
        runs[0].recording.clarabel = None;
        assert_eq!(of_all(&runs[..1]), None);
    }
}
