//! The line on which answers travel to the arm.

use revprio_api::wire::StepAnswer;

use super::chance::{Chance, Purpose};
use super::faults::Faults;

/// A line with faults.
pub struct LossyChannel {
    faults: Faults,
    chance: Chance,
    /// Answers on their way, with the period in which they arrive.
    travelling: Vec<(u64, StepAnswer)>,
    /// The line is jammed before this period.
    free_from: u64,
    /// Sequence number of the newest answer that arrived.
    newest: Option<u64>,
}

/// What becomes of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fate {
    Dropped,
    Late,
    Repeated,
    Reordered,
    Arrives,
}

impl LossyChannel {
    /// A line with these faults, the same for the same seed.
    pub fn new(faults: Faults, seed: u64) -> Self {
        let chance = Chance::new(seed, Purpose::LossyChannel);
        Self { faults, chance, travelling: Vec::new(), free_from: 0, newest: None }
    }

    /// Whether the service is dead at a time, s.
    pub fn is_dead(&self, time_s: f64) -> bool {
        self.faults.is_dead(time_s)
    }

    /// Sends what the service answered in a period, if it did, and gives the newest answer that arrives in it, if there is
    /// one that is newer than all before.
    pub fn pass(&mut self, period: u64, answer: Option<StepAnswer>) -> Option<StepAnswer> {
        let fate = self.fate();
        if let Some(answer) = answer {
            self.send(period, if self.newest.is_none() { Fate::Arrives } else { fate }, answer);
        }
        let arrived = self.travelling.extract_if(.., |(due, _)| *due <= period).map(|(_, answer)| answer);
        let newest = arrived.max_by_key(|answer| answer.sequence);
        let newest = newest.filter(|answer| self.newest.is_none_or(|known| answer.sequence > known));
        self.newest = newest.as_ref().map_or(self.newest, |answer| Some(answer.sequence));
        newest
    }

    /// Drawn in each period, with an answer or without, so that one fault does not change those after it.
    fn fate(&mut self) -> Fate {
        let Faults { dropped, late, repeated, reordered, .. } = self.faults;
        let mut left = self.chance.uniform();
        let shares =
            [(Fate::Dropped, dropped), (Fate::Late, late), (Fate::Repeated, repeated), (Fate::Reordered, reordered)];
        for (fate, share) in shares {
            if left < share {
                return fate;
            }
            left -= share;
        }
        Fate::Arrives
    }

    fn send(&mut self, period: u64, fate: Fate, answer: StepAnswer) {
        if fate == Fate::Late {
            self.free_from = self.free_from.max(period + self.faults.late_periods as u64);
        }
        let due = period.max(self.free_from);
        match fate {
            Fate::Dropped => return,
            Fate::Repeated => self.travelling.push((due + 1, answer.clone())),
            Fate::Reordered => return self.travelling.push((due + 1, answer)),
            Fate::Late | Fate::Arrives => (),
        }
        self.travelling.push((due, answer));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sequence numbers of the answers that the arm takes, period by period.
    fn taken(faults: Faults, periods: u64) -> Vec<Option<u64>> {
        let answer: StepAnswer =
            serde_json::from_str(include_str!("../../../../api/examples/answers/step.json")).unwrap();
        let mut line = LossyChannel::new(faults, 3);
        let period = |period| {
            let answer = StepAnswer { sequence: period, ..answer.clone() };
            line.pass(period, Some(answer)).map(|answer| answer.sequence)
        };
        (0..periods).map(period).collect()
    }

    fn on_time(taken: &[Option<u64>]) -> usize {
        taken.iter().zip(0..).filter(|(taken, period)| **taken == Some(*period)).count()
    }

    #[test]
    fn without_faults_each_answer_arrives_in_its_period() {
        assert_eq!(on_time(&taken(Faults::default(), 100)), 100);
    }

    #[test]
    fn of_dropped_answers_nothing_arrives_but_the_first() {
        let taken = taken(Faults { dropped: 1.0, ..Faults::default() }, 10);
        assert_eq!(taken[0], Some(0));
        assert!(taken[1..].iter().all(Option::is_none));
    }

    #[test]
    fn a_share_of_dropped_answers_is_that_share() {
        let missing = 10_000 - on_time(&taken(Faults { dropped: 0.2, ..Faults::default() }, 10_000));
        assert!((1850..2150).contains(&missing), "{missing}");
    }

    #[test]
    fn after_a_jam_the_newest_answer_counts() {
        let taken = taken(Faults { late: 0.05, late_periods: 4, ..Faults::default() }, 1000);
        let silence = taken.iter().position(Option::is_none).unwrap();
        assert!(taken[silence..silence + 4].iter().all(Option::is_none), "{:?}", &taken[silence..silence + 6]);
        let arrived: Vec<u64> = taken.iter().flatten().copied().collect();
        assert!(arrived.is_sorted_by(|one, next| one < next));
        // A second jam behind the first holds back the new answers, not those that waited for the first.
        assert!(
            taken
                .iter()
                .zip(0..)
                .all(|(taken, period)| taken.is_none_or(|taken| taken <= period && period <= taken + 4))
        );
    }

    #[test]
    fn repeated_answers_change_nothing_and_overtaken_ones_are_old() {
        assert_eq!(on_time(&taken(Faults { repeated: 1.0, ..Faults::default() }, 100)), 100);
        let taken = taken(Faults { reordered: 0.3, ..Faults::default() }, 1000);
        // Overtaken by the next: never obeyed. Only where the next one is delayed too, the old one counts, a period late.
        assert!(
            taken
                .iter()
                .zip(0..)
                .all(|(taken, period)| taken.is_none_or(|taken| taken == period || taken + 1 == period))
        );
        assert!(taken.iter().flatten().is_sorted_by(|one, next| one < next));
    }
}
