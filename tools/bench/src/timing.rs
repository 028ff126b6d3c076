//! How things are timed: side by side, in short turns, so that what disturbs one disturbs the other.

use std::hint::black_box;
use std::time::{Duration, Instant};

use super::BenchError;

/// A sample lasts at least this long: many times the resolution of the clock.
const SHORTEST_SAMPLE: Duration = Duration::from_micros(1);

/// Warming up ends after this.
const LONGEST_WARM_UP: Duration = Duration::from_millis(100);

/// Samples to learn how long the clock itself takes.
const CLOCK_SAMPLES: usize = 10_000;

/// How long to measure.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    /// Turns of each.
    pub turns: usize,
    /// Length of one turn.
    pub turn: Duration,
}

impl Budget {
    /// The same number of turns, each so many times as long.
    pub fn stretched(self, times: u32) -> Self {
        Self { turn: self.turn * times, ..self }
    }
}

/// Something to be timed, by name.
pub struct Subject<'a> {
    name: String,
    call: Box<dyn FnMut() -> Result<(), BenchError> + 'a>,
}

impl<'a> Subject<'a> {
    /// `call` is what is timed; its result is kept from being optimised away.
    pub fn new<T>(name: impl Into<String>, mut call: impl FnMut() -> T + 'a) -> Self {
        Self::fallible(name, move || Ok(call()))
    }

    /// The same for what can fail; a failure ends the measurement.
    pub fn fallible<T>(name: impl Into<String>, mut call: impl FnMut() -> Result<T, BenchError> + 'a) -> Self {
        Self { name: name.into(), call: Box::new(move || call().map(|result| drop(black_box(result)))) }
    }
}

/// Times of one subject, s per call.
#[derive(Debug, Clone)]
pub struct Times {
    /// What was timed.
    pub name: String,
    /// All of it, ascending.
    samples: Vec<f64>,
    /// The median of each turn, in the order of the turns.
    turns: Vec<f64>,
}

impl Times {
    /// Times that were taken elsewhere, s, in one turn.
    pub fn of(name: impl Into<String>, mut samples: Vec<f64>) -> Self {
        samples.sort_by(f64::total_cmp);
        let turns = vec![quantile(&samples, 0.5)];
        Self { name: name.into(), samples, turns }
    }

    /// The time that a share of the calls stays below, s.
    pub fn quantile(&self, share: f64) -> f64 {
        quantile(&self.samples, share)
    }

    /// s.
    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }

    /// All of them, s, ascending.
    pub fn samples(&self) -> &[f64] {
        &self.samples
    }

    /// s.
    pub fn mean(&self) -> f64 {
        self.samples.iter().sum::<f64>() / self.samples.len().max(1) as f64
    }

    /// How many times as long as the other: the median over the turns, of which each compares neighbours in time.
    pub fn ratio(&self, other: &Self) -> f64 {
        let mut ratios: Vec<f64> = self.turns.iter().zip(&other.turns).map(|(own, other)| own / other).collect();
        ratios.sort_by(f64::total_cmp);
        quantile(&ratios, 0.5)
    }
}

/// Times the subjects in turns.
pub fn side_by_side(budget: Budget, mut subjects: Vec<Subject>) -> Result<Vec<Times>, BenchError> {
    let clock = clock_cost()?;
    let calls: Vec<u32> = subjects.iter_mut().map(calls_per_sample).collect::<Result<_, _>>()?;
    let mut turns: Vec<Vec<Vec<f64>>> = vec![Vec::new(); subjects.len()];
    for _ in 0..budget.turns {
        for ((subject, &calls), turns) in subjects.iter_mut().zip(&calls).zip(&mut turns) {
            turns.push(turn(subject, calls, clock, budget.turn)?);
        }
    }
    let times = |(subject, turns): (Subject, Vec<Vec<f64>>)| {
        let median = |turn: &Vec<f64>| {
            let mut turn = turn.clone();
            turn.sort_by(f64::total_cmp);
            quantile(&turn, 0.5)
        };
        Times { turns: turns.iter().map(median).collect(), ..Times::of(subject.name, turns.concat()) }
    };
    Ok(subjects.into_iter().zip(turns).map(times).collect())
}

/// One turn: times per call, s.
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

/// So many calls that a sample is long enough; warms up meanwhile.
fn calls_per_sample(subject: &mut Subject) -> Result<u32, BenchError> {
    let mut calls = 1;
    while shortest(subject, calls)? < SHORTEST_SAMPLE {
        calls *= 2;
    }
    Ok(calls)
}

/// The shortest of some samples; of one where it takes long, for another subject's connection must not lie idle meanwhile.
fn shortest(subject: &mut Subject, calls: u32) -> Result<Duration, BenchError> {
    let (start, mut shortest) = (Instant::now(), sample(subject, calls)?);
    for _ in 1..20 {
        if start.elapsed() > LONGEST_WARM_UP {
            break;
        }
        shortest = shortest.min(sample(subject, calls)?);
    }
    Ok(shortest)
}

/// What reading the clock twice takes, s.
fn clock_cost() -> Result<f64, BenchError> {
    let mut nothing = Subject::new("", || ());
    let sample = |_| sample(&mut nothing, 0).map(|time| time.as_secs_f64());
    let samples = (0..CLOCK_SAMPLES).map(sample).collect::<Result<_, _>>()?;
    Ok(Times::of("", samples).median())
}

/// Of ascending values; zero without any.
pub fn quantile(ascending: &[f64], share: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let place = (share * ascending.len().saturating_sub(1) as f64).round() as usize;
    ascending.get(place).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_compares_neighbours_and_survives_a_disturbed_turn() {
        let times = |turns: &[f64]| Times { turns: turns.to_vec(), ..Times::of("", turns.to_vec()) };
        // The machine was twice as slow in the second turn, and one of the two was held up in the third.
        let (own, other) = (times(&[2.0, 4.0, 90.0]), times(&[1.0, 2.0, 1.0]));
        assert_eq!(own.ratio(&other), 2.0);
    }

    #[test]
    fn every_subject_is_timed_however_small_the_budget() {
        let budget = Budget { turns: 2, turn: Duration::ZERO };
        let sleeping = Subject::new("sleeps", || std::thread::sleep(Duration::from_millis(1)));
        let times = side_by_side(budget, vec![Subject::new("nothing", || ()), sleeping]).unwrap();
        assert_eq!(times[1].turns.len(), 2);
        assert!(times[0].median() < times[1].median() && times[1].quantile(0.0) >= 0.9e-3);
    }

    #[test]
    fn what_fails_is_not_timed() {
        let fails = Subject::fallible("fails", || Err::<(), _>(BenchError::Defect("meant".to_owned())));
        assert!(side_by_side(Budget { turns: 1, turn: Duration::ZERO }, vec![fails]).is_err());
    }

    #[test]
    fn quantiles_are_values_that_occurred() {
        assert_eq!([0.0, 0.5, 0.99, 1.0].map(|share| quantile(&[1.0, 2.0, 3.0], share)), [1.0, 2.0, 3.0, 3.0]);
        assert_eq!(quantile(&[], 0.5), 0.0);
    }
}
