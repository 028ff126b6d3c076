//! Timing. The subjects are timed alternately in short turns, so that a disturbance affects all of them.

use std::hint::black_box;
use std::time::{Duration, Instant};

use super::error::BenchError;

/// Shortest sample: many times the resolution of the clock.
const MIN_SAMPLE: Duration = Duration::from_micros(1);

/// Longest warm-up.
const MAX_WARM_UP: Duration = Duration::from_millis(100);

/// Number of samples to measure the cost of reading the clock.
const CLOCK_SAMPLES: usize = 10_000;

/// Duration of a measurement.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    /// Number of turns per subject.
    pub turns: usize,
    /// Length of one turn.
    pub turn: Duration,
}

impl Budget {
    /// Returns the same number of turns, each `times` times as long.
    pub fn stretched(self, times: u32) -> Self {
        Self { turn: self.turn * times, ..self }
    }
}

/// A named operation to time.
pub struct Subject<'a> {
    name: String,
    call: Box<dyn FnMut() -> Result<(), BenchError> + 'a>,
}

impl<'a> Subject<'a> {
    /// Returns a subject; the compiler cannot remove the result of `call`.
    pub fn new<T>(name: impl Into<String>, mut call: impl FnMut() -> T + 'a) -> Self {
        Self::fallible(name, move || Ok(call()))
    }

    /// Returns a subject that can fail; an error ends the measurement.
    pub fn fallible<T>(name: impl Into<String>, mut call: impl FnMut() -> Result<T, BenchError> + 'a) -> Self {
        Self { name: name.into(), call: Box::new(move || call().map(|result| drop(black_box(result)))) }
    }
}

/// Times of one subject, s per call.
#[derive(Debug, Clone)]
pub struct Times {
    /// Name.
    pub name: String,
    /// All samples, ascending.
    samples: Vec<f64>,
    /// The median of each turn, in the order of the turns.
    turns: Vec<f64>,
}

impl Times {
    /// Returns times that were measured elsewhere, s, as one turn.
    pub fn of(name: impl Into<String>, mut samples: Vec<f64>) -> Self {
        samples.sort_by(f64::total_cmp);
        let turns = vec![quantile(&samples, 0.5)];
        Self { name: name.into(), samples, turns }
    }

    /// Returns a quantile, s.
    pub fn quantile(&self, share: f64) -> f64 {
        quantile(&self.samples, share)
    }

    /// Returns the median, s.
    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }

    /// Returns all samples, s, ascending.
    pub fn samples(&self) -> &[f64] {
        &self.samples
    }

    /// Returns the mean, s.
    pub fn mean(&self) -> f64 {
        self.samples.iter().sum::<f64>() / self.samples.len().max(1) as f64
    }

    /// Returns the ratio to another subject: the median of the ratios of adjacent turns.
    pub fn ratio(&self, other: &Self) -> f64 {
        let mut ratios: Vec<f64> = self.turns.iter().zip(&other.turns).map(|(own, other)| own / other).collect();
        ratios.sort_by(f64::total_cmp);
        quantile(&ratios, 0.5)
    }
}

/// Times `call(index)` for each problem from 0 to `count`, in order, in as many rounds as the budget allows.
///
/// A sample is the median of one problem over all rounds: other load on the machine does not reach the quantiles.
pub fn problem_by_problem(
    name: &str,
    budget: Budget,
    count: usize,
    mut call: impl FnMut(usize) -> Result<(), BenchError>,
) -> Result<Times, BenchError> {
    if count == 0 {
        return Err(BenchError::Defect(format!("there are no problems for `{name}`")));
    }
    let clock = clock_cost()?;
    let (start, mut rounds) = (Instant::now(), vec![Vec::new(); count]);
    while rounds[0].len() < budget.turns || start.elapsed() < budget.turn * 10 {
        for (index, times) in rounds.iter_mut().enumerate() {
            let start = Instant::now();
            call(index)?;
            times.push((start.elapsed().as_secs_f64() - clock).max(0.0));
        }
    }
    Ok(Times::of(name, rounds.iter().map(|times| median(times)).collect()))
}

/// Times the subjects alternately.
pub fn side_by_side(budget: Budget, mut subjects: Vec<Subject>) -> Result<Vec<Times>, BenchError> {
    let clock = clock_cost()?;
    let calls: Vec<u32> = subjects.iter_mut().map(calls_per_sample).collect::<Result<_, _>>()?;
    let mut turns: Vec<Vec<Vec<f64>>> = vec![Vec::new(); subjects.len()];
    for _ in 0..budget.turns {
        for ((subject, &calls), turns) in subjects.iter_mut().zip(&calls).zip(&mut turns) {
            turns.push(turn(subject, calls, clock, budget.turn)?);
        }
    }
    let times = |(subject, turns): (Subject, Vec<Vec<f64>>)| Times {
        turns: turns.iter().map(|turn| median(turn)).collect(),
        ..Times::of(subject.name, turns.concat())
    };
    Ok(subjects.into_iter().zip(turns).map(times).collect())
}

/// Runs one turn and returns times per call, s.
fn turn(subject: &mut Subject, calls: u32, clock: f64, length: Duration) -> Result<Vec<f64>, BenchError> {
    let (start, mut samples) = (Instant::now(), Vec::new());
    while samples.is_empty() || start.elapsed() < length {
        samples.push((sample(subject, calls)?.as_secs_f64() - clock).max(0.0) / f64::from(calls));
    }
    Ok(samples)
}

fn sample(subject: &mut Subject, calls: u32) -> Result<Duration, BenchError> {
    let start = Instant::now();
    for _ in 0..calls {
        (subject.call)()?;
    }
    Ok(start.elapsed())
}

/// Returns the number of calls for a sample that is long enough. This is also the warm-up.
fn calls_per_sample(subject: &mut Subject) -> Result<u32, BenchError> {
    let mut calls = 1;
    while shortest(subject, calls)? < MIN_SAMPLE {
        calls *= 2;
    }
    Ok(calls)
}

/// Returns the shortest of some samples. It stops early for slow subjects, so that connections of others do not time
/// out.
fn shortest(subject: &mut Subject, calls: u32) -> Result<Duration, BenchError> {
    let (start, mut shortest) = (Instant::now(), sample(subject, calls)?);
    for _ in 1..20 {
        if start.elapsed() > MAX_WARM_UP {
            break;
        }
        shortest = shortest.min(sample(subject, calls)?);
    }
    Ok(shortest)
}

/// Returns the time to read the clock twice, s.
fn clock_cost() -> Result<f64, BenchError> {
    let mut nothing = Subject::new("", || ());
    let sample = |_| sample(&mut nothing, 0).map(|time| time.as_secs_f64());
    let samples = (0..CLOCK_SAMPLES).map(sample).collect::<Result<_, _>>()?;
    Ok(Times::of("", samples).median())
}

/// Returns the median of values in any order; zero if there are none.
fn median(values: &[f64]) -> f64 {
    let mut ascending = values.to_vec();
    ascending.sort_by(f64::total_cmp);
    quantile(&ascending, 0.5)
}

/// Returns a quantile of ascending values; zero if there are none.
pub fn quantile(ascending: &[f64], share: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let place = (share * ascending.len().saturating_sub(1) as f64).round() as usize;
    ascending.get(place).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratio_compares_adjacent_turns_and_ignores_a_disturbed_one() {
        let times = |turns: &[f64]| Times { turns: turns.to_vec(), ..Times::of("", turns.to_vec()) };
        // The machine was half as fast in the second turn, and one subject was disturbed in the third.
        let (own, other) = (times(&[2.0, 4.0, 90.0]), times(&[1.0, 2.0, 1.0]));
        assert_eq!(own.ratio(&other), 2.0);
    }

    #[test]
    fn every_subject_is_timed_with_the_smallest_budget() {
        let budget = Budget { turns: 2, turn: Duration::ZERO };
        let sleeping = Subject::new("sleeps", || std::thread::sleep(Duration::from_millis(1)));
        let times = side_by_side(budget, vec![Subject::new("nothing", || ()), sleeping]).unwrap();
        assert_eq!(times.iter().map(|times| times.turns.len()).collect::<Vec<_>>(), [2, 2]);
        assert!(times[1].quantile(0.0) >= 0.9e-3);
    }

    #[test]
    fn every_problem_has_one_sample() {
        let mut calls = [0; 3];
        let call = |index: usize| {
            calls[index] += 1;
            Ok(())
        };
        let times = problem_by_problem("", Budget { turns: 4, turn: Duration::ZERO }, 3, call).unwrap();
        assert_eq!(times.samples().len(), 3);
        assert!(calls[0] >= 4 && calls == [calls[0]; 3], "{calls:?}");
    }

    #[test]
    fn a_slow_round_does_not_change_the_median() {
        assert_eq!(median(&[2.0, 500.0, 1.0]), 2.0);
        assert_eq!(median(&[]), 0.0);
    }

    #[test]
    fn errors_end_the_measurement() {
        let fails = Subject::fallible("fails", || Err::<(), _>(BenchError::Defect("meant".to_owned())));
        assert!(side_by_side(Budget { turns: 1, turn: Duration::ZERO }, vec![fails]).is_err());
    }

    #[test]
    fn quantiles_are_measured_values() {
        assert_eq!([0.0, 0.5, 0.99, 1.0].map(|share| quantile(&[1.0, 2.0, 3.0], share)), [1.0, 2.0, 3.0, 3.0]);
        assert_eq!(quantile(&[], 0.5), 0.0);
    }
}
