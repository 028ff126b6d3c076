//! Motion of the arm while the service does not answer.

use super::figure::{Colour, Curve, Stroke};
use crate::number::significant;
use crate::simulator::recording::{Recording, Sample};

/// Returns a remark on a run with missing answers; `None` if every period had one.
#[must_use]
pub fn of_run(run: &Recording) -> Option<String> {
    let missing = run.samples.iter().filter(|sample| !sample.answered).count();
    let periods = run.samples.len();
    let gap = longest_gap(run)?;
    let [first, .., last] = gap else { return Some(format!("{missing} of {periods} periods had no answer.")) };
    let held = gap.iter().take_while(|sample| sample.joint_velocity == first.joint_velocity).count();
    let since = |sample: &Sample| significant(sample.time_s - first.time_s, 3);
    let result = match gap.iter().find(|sample| speed(sample) == 0.0) {
        Some(still) => format!("came to rest {} s after the gap began", since(still)),
        None => format!("still moved at {} rad/s when the gap ended", significant(speed(last), 3)),
    };
    Some(format!(
        "{missing} of {periods} periods had no answer. The longest gap began at {} s and lasted {} s. The arm held the \
         last command for {} s and {result}.",
        significant(first.time_s, 4),
        significant(gap.len() as f64 * run.period_s, 3),
        significant(held as f64 * run.period_s, 3),
    ))
}

/// Returns the speed of the fastest joint over time, with the longest gap marked; `None` if every period had an answer.
#[must_use]
pub fn curves(run: &Recording) -> Option<Vec<Curve>> {
    let points = |samples: &[Sample]| samples.iter().map(|sample| (sample.time_s, speed(sample))).collect();
    let gap = points(longest_gap(run)?);
    let curve = |label: &str, colour, stroke, points| Curve { label: label.to_owned(), colour, stroke, points };
    Some(vec![
        curve("longest gap without answers", Colour::Orange, Stroke::Wide, gap),
        curve("fastest joint", Colour::Blue, Stroke::Thin, points(&run.samples)),
    ])
}

/// Returns the longest sequence of samples without an answer.
fn longest_gap(run: &Recording) -> Option<&[Sample]> {
    let parts = run.samples.chunk_by(|one, next| one.answered == next.answered);
    parts.filter(|part| !part[0].answered).max_by_key(|part| part.len())
}

fn speed(sample: &Sample) -> f64 {
    sample.joint_velocity.iter().map(|speed| speed.abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One joint at 1 rad/s. One answer is missing; later all answers are missing while the joint has the given speeds.
    /// The period is 0.1 s.
    fn run(speeds_in_gap: &[f64]) -> Recording {
        let sample = |(period, &(answered, speed)): (usize, &(bool, f64))| Sample {
            time_s: 0.1 * period as f64,
            joint_velocity: vec![speed],
            answered,
            ..Sample::at_rest()
        };
        let gap = speeds_in_gap.iter().map(|&speed| (false, speed));
        let periods: Vec<_> = [(true, 1.0), (false, 1.0), (true, 1.0)].into_iter().chain(gap).collect();
        let samples = periods.iter().enumerate().map(sample).collect();
        Recording { period_s: 0.1, joint_names: vec!["a".to_owned()], samples, ..Recording::empty() }
    }

    #[test]
    fn remark_reports_the_longest_gap_and_the_time_to_rest() {
        let note = of_run(&run(&[1.0, 1.0, 0.5, 0.0, 0.0])).unwrap();
        assert_eq!(
            note,
            "6 of 8 periods had no answer. The longest gap began at 0.3000 s and lasted 0.500 s. The arm held the last \
             command for 0.200 s and came to rest 0.300 s after the gap began."
        );
        assert!(of_run(&run(&[1.0, 0.5])).unwrap().ends_with("still moved at 0.500 rad/s when the gap ended."));
    }

    #[test]
    fn no_remark_if_every_period_has_an_answer() {
        let mut run = run(&[]);
        run.samples.remove(1);
        assert!(of_run(&run).is_none() && curves(&run).is_none());
    }

    #[test]
    fn curve_of_the_gap_is_part_of_the_speed_curve() {
        let curves = curves(&run(&[1.0, 0.5, 0.0])).unwrap();
        assert!(curves[0].points.iter().all(|point| curves[1].points.contains(point)));
        assert_eq!(curves[0].points.len(), 3);
    }
}
