//! The connection over which answers reach the arm, with faults.

use revprio_api::wire::StepAnswer;

use super::faults::Faults;
use super::random::{Purpose, RandomSource};

/// A connection with faults.
pub struct LossyChannel {
    faults: Faults,
    random: RandomSource,
    /// Answers in transit, with the period in which they arrive.
    in_transit: Vec<(u64, StepAnswer)>,
    /// No answer arrives before this period.
    blocked_until: u64,
    /// Sequence number of the newest answer that has arrived.
    newest: Option<u64>,
}

/// How an answer is delivered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Delivery {
    Dropped,
    Late,
    Repeated,
    Reordered,
    OnTime,
}

impl LossyChannel {
    /// Returns a connection with these faults; the same seed gives the same faults.
    pub fn new(faults: Faults, seed: u64) -> Self {
        let random = RandomSource::new(seed, Purpose::LossyChannel);
        Self { faults, random, in_transit: Vec::new(), blocked_until: 0, newest: None }
    }

    /// Returns whether the service is down at a time, s.
    pub fn is_down(&self, time_s: f64) -> bool {
        self.faults.is_down(time_s)
    }

    /// Sends the answer of a period, if any. Returns the newest answer that arrives in this period, if it is newer than all
    /// answers before.
    pub fn pass(&mut self, period: u64, answer: Option<StepAnswer>) -> Option<StepAnswer> {
        let delivery = self.draw_delivery();
        if let Some(answer) = answer {
            self.send(period, if self.newest.is_none() { Delivery::OnTime } else { delivery }, answer);
        }
        let arrived = self.in_transit.extract_if(.., |(due, _)| *due <= period).map(|(_, answer)| answer);
        let newest = arrived.max_by_key(|answer| answer.sequence);
        let newest = newest.filter(|answer| self.newest.is_none_or(|known| answer.sequence > known));
        self.newest = newest.as_ref().map_or(self.newest, |answer| Some(answer.sequence));
        newest
    }

    /// Draws the delivery of an answer. It is drawn in every period, also without an answer, so that one fault does not change
    /// later ones.
    fn draw_delivery(&mut self) -> Delivery {
        let Faults { dropped, late, repeated, reordered, .. } = self.faults;
        let mut left = self.random.uniform();
        let shares = [
            (Delivery::Dropped, dropped),
            (Delivery::Late, late),
            (Delivery::Repeated, repeated),
            (Delivery::Reordered, reordered),
        ];
        for (delivery, share) in shares {
            if left < share {
                return delivery;
            }
            left -= share;
        }
        Delivery::OnTime
    }

    fn send(&mut self, period: u64, delivery: Delivery, answer: StepAnswer) {
        if delivery == Delivery::Late {
            self.blocked_until = self.blocked_until.max(period + self.faults.late_periods as u64);
        }
        let due = period.max(self.blocked_until);
        match delivery {
            Delivery::Dropped => return,
            Delivery::Repeated => self.in_transit.push((due + 1, answer.clone())),
            Delivery::Reordered => return self.in_transit.push((due + 1, answer)),
            Delivery::Late | Delivery::OnTime => (),
        }
        self.in_transit.push((due, answer));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the sequence numbers of the answers that arrive, period by period.
    fn arrivals(faults: Faults, periods: u64) -> Vec<Option<u64>> {
        let answer: StepAnswer =
            serde_json::from_str(include_str!("../../../../api/examples/answers/step.json")).unwrap();
        let mut channel = LossyChannel::new(faults, 3);
        let period = |period| {
            let answer = StepAnswer { sequence: period, ..answer.clone() };
            channel.pass(period, Some(answer)).map(|answer| answer.sequence)
        };
        (0..periods).map(period).collect()
    }

    fn on_time(arrivals: &[Option<u64>]) -> usize {
        arrivals.iter().zip(0..).filter(|(arrival, period)| **arrival == Some(*period)).count()
    }

    #[test]
    fn without_faults_each_answer_arrives_in_its_period() {
        assert_eq!(on_time(&arrivals(Faults::default(), 100)), 100);
    }

    #[test]
    fn only_the_first_answer_arrives_if_all_are_dropped() {
        let arrivals = arrivals(Faults { dropped: 1.0, ..Faults::default() }, 10);
        assert_eq!(arrivals[0], Some(0));
        assert!(arrivals[1..].iter().all(Option::is_none));
    }

    #[test]
    fn share_of_dropped_answers_is_as_configured() {
        let missing = 10_000 - on_time(&arrivals(Faults { dropped: 0.2, ..Faults::default() }, 10_000));
        assert!((1850..2150).contains(&missing), "{missing}");
    }

    #[test]
    fn newest_answer_is_used_after_late_answers() {
        let arrivals = arrivals(Faults { late: 0.05, late_periods: 4, ..Faults::default() }, 1000);
        let gap = arrivals.iter().position(Option::is_none).unwrap();
        assert!(arrivals[gap..gap + 4].iter().all(Option::is_none), "{:?}", &arrivals[gap..gap + 6]);
        let arrived: Vec<u64> = arrivals.iter().flatten().copied().collect();
        assert!(arrived.is_sorted_by(|one, next| one < next));
        // A second late answer delays the new answers, not those that already wait.
        assert!(
            arrivals
                .iter()
                .zip(0..)
                .all(|(arrival, period)| arrival.is_none_or(|arrival| arrival <= period && period <= arrival + 4))
        );
    }

    #[test]
    fn repeated_and_overtaken_answers_are_ignored() {
        assert_eq!(on_time(&arrivals(Faults { repeated: 1.0, ..Faults::default() }, 100)), 100);
        let arrivals = arrivals(Faults { reordered: 0.3, ..Faults::default() }, 1000);
        // An overtaken answer is not used. If the next answer is delayed too, the old one is used one period late.
        assert!(
            arrivals
                .iter()
                .zip(0..)
                .all(|(arrival, period)| arrival.is_none_or(|arrival| arrival == period || arrival + 1 == period))
        );
        assert!(arrivals.iter().flatten().is_sorted_by(|one, next| one < next));
    }
}
