//! What an arm does while no answer comes.

use super::figure::{Colour, Curve, Stroke};
use super::number::significant;
use crate::simulator::recording::{Recording, Sample};

/// Remarks on a run in which answers were missing; none if all came.
#[must_use]
pub fn of_run(run: &Recording) -> Option<String> {
    let missing = run.samples.iter().filter(|sample| !sample.answered).count();
    let silence = longest(run)?;
    let [first, .., last] = silence else { return Some(format!("No answer came in {missing} periods.")) };
    let held = silence.iter().take_while(|sample| sample.joint_velocity == first.joint_velocity).count();
    let since = |sample: &Sample| significant(sample.time_s - first.time_s, 3);
    let fate = match silence.iter().find(|sample| speed(sample) == 0.0) {
        Some(still) => format!("stood still {} s after its beginning", since(still)),
        None => format!("was still at {} rad/s at its end", significant(speed(last), 3)),
    };
    Some(format!(
        "No answer came in {missing} of {} periods. In the longest silence, {} s from {} s on, the arm kept the last \
         command for {} s and {fate}.",
        run.samples.len(),
        significant(silence.len() as f64 * run.period_s, 3),
        significant(first.time_s, 4),
        significant(held as f64 * run.period_s, 3),
    ))
}

/// Speed of the fastest joint over time, and where in it the longest silence lies; none if all answers came.
#[must_use]
pub fn curves(run: &Recording) -> Option<Vec<Curve>> {
    let points = |samples: &[Sample]| samples.iter().map(|sample| (sample.time_s, speed(sample))).collect();
    let silence = points(longest(run)?);
    let curve = |label: &str, colour, stroke, points| Curve { label: label.to_owned(), colour, stroke, points };
    Some(vec![
        curve("longest silence", Colour::Orange, Stroke::Wide, silence),
        curve("fastest joint", Colour::Blue, Stroke::Thin, points(&run.samples)),
    ])
}

/// The most samples in a row without an answer.
fn longest(run: &Recording) -> Option<&[Sample]> {
    let spells = run.samples.chunk_by(|one, next| one.answered == next.answered);
    spells.filter(|spell| !spell[0].answered).max_by_key(|spell| spell.len())
}

fn speed(sample: &Sample) -> f64 {
    sample.joint_velocity.iter().map(|speed| speed.abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint at 1 rad/s that misses one answer, then has these speeds without any; periods of 0.1 s.
    fn run(silent_speeds: &[f64]) -> Recording {
        let sample = |(period, &(answered, speed)): (usize, &(bool, f64))| Sample {
            time_s: 0.1 * period as f64,
            joint_velocity: vec![speed],
            answered,
            ..Sample::at_rest()
        };
        let silence = silent_speeds.iter().map(|&speed| (false, speed));
        let periods: Vec<_> = [(true, 1.0), (false, 1.0), (true, 1.0)].into_iter().chain(silence).collect();
        let samples = periods.iter().enumerate().map(sample).collect();
        Recording { period_s: 0.1, joint_names: vec!["a".to_owned()], samples, ..Recording::empty() }
    }

    #[test]
    fn the_longest_silence_is_told_with_the_time_to_rest() {
        let note = of_run(&run(&[1.0, 1.0, 0.5, 0.0, 0.0])).unwrap();
        assert!(
            note.starts_with("No answer came in 6 of 8 periods. In the longest silence, 0.500 s from 0.3000 s on"),
            "{note}"
        );
        assert!(
            note.ends_with("kept the last command for 0.200 s and stood still 0.300 s after its beginning."),
            "{note}"
        );
        assert!(of_run(&run(&[1.0, 0.5])).unwrap().ends_with("was still at 0.500 rad/s at its end."));
    }

    #[test]
    fn where_all_answers_came_nothing_is_told() {
        let mut run = run(&[]);
        run.samples.remove(1);
        assert!(of_run(&run).is_none() && curves(&run).is_none());
    }

    #[test]
    fn the_curve_of_the_silence_lies_on_that_of_the_speed() {
        let curves = curves(&run(&[1.0, 0.5, 0.0])).unwrap();
        assert!(curves[0].points.iter().all(|point| curves[1].points.contains(point)));
        assert_eq!(curves[0].points.len(), 3);
    }
}
