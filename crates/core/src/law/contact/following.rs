//! Whether the arm moves as its model does.
//!
//! The law counts with the modelled position of the tool. A brake, a stop of the drives or a slider of the robot's speed holds the arm back: the model
//! moves on, the tool does not. A force that does not change then looks like a soft surface, and a retreat like one that has happened. So the
//! model is compared with the measured positions: ahead, by how much it has moved further lately, must stay below what an unstated lag, play, and
//! the resolution of positions explain. While it does not, the modelled position moves as the measured one does.
//!
//! A drive that yields to the force is ahead as well. But then the force changes as the model moves, and the model is right.

use super::settings::ContactSettings;
use super::timing::ContactTiming;

/// Lag that nobody stated, s, and as a multiple of the reaction time.
const UNSTATED: (f64, f64) = (0.1, 3.0);

/// Time in which what the model is ahead is forgotten, over that lag: an arm that does half of what it is told is held back.
const FORGOTTEN: f64 = 3.0;

/// Time for which an arm must be too far behind to be held back, over that lag.
const LASTS: f64 = 1.5;

/// Way of play, yielding and resolution, m.
const PLAY: f64 = 2e-4;

/// Stiffness of the softest drive that yields, N/m, and the change of the force that noise does not explain, in units of σ.
const YIELDS: f64 = 1e3;
const SIGMAS: f64 = 4.0;

/// Share of the velocity of the model from which an arm follows again, if it moves by half of the play within the unstated lag.
const AGAIN: f64 = 0.5;

/// How well the arm follows its model along an axis. For an axis of rotation read rad for m and N·m for N.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Following {
    /// x at the last step, m.
    pub position: f64,
    /// How far the model has moved beyond the measured way lately, m.
    pub ahead: f64,
    /// How much the force has risen in the same time, N.
    pub force: f64,
    /// Mean velocities of the model and of the tool, m/s.
    pub velocities: [f64; 2],
    /// For how long the model has been too far ahead, s.
    pub time: f64,
}

impl Following {
    /// An axis at the first step.
    pub(super) const START: Self = Self { position: 0.0, ahead: 0.0, force: 0.0, velocities: [0.0; 2], time: 0.0 };

    /// Adds the ways of the model and of the tool, m, and the change of the force, N, in a time, s.
    pub(super) fn add(
        &mut self,
        (settings, timing): (&ContactSettings, &ContactTiming),
        ([modelled, measured], change): ([f64; 2], f64),
        time: f64,
    ) {
        let unstated = unstated(timing);
        let kept = |constant: f64| (-time / constant).exp();
        let remembered = kept(FORGOTTEN * unstated);
        self.ahead = remembered * (self.ahead + modelled - measured);
        self.force = remembered * (self.force + change);
        let share = 1.0 - kept(unstated);
        for (mean, way) in self.velocities.iter_mut().zip([modelled, measured]) {
            *mean += if time > 0.0 { share * (way / time - *mean) } else { 0.0 };
        }
        let goes_on = if self.is_held_back(timing) {
            !self.follows_again(settings, unstated)
        } else {
            self.is_too_far(settings, unstated)
        };
        self.time = if goes_on { self.time + time } else { 0.0 };
    }

    /// Returns whether the model is further ahead than an unstated lag, s, play, and a drive that yields explain.
    fn is_too_far(&self, settings: &ContactSettings, unstated: f64) -> bool {
        let ([modelled, _], ahead) = (self.velocities, self.ahead.abs());
        let least = (YIELDS / settings.metre * ahead).max(SIGMAS * settings.noise);
        let yields = self.force * self.ahead.signum() > least;
        self.ahead * modelled > 0.0 && !yields && ahead > PLAY * settings.metre + unstated * modelled.abs()
    }

    /// Returns whether an arm that was held back moves as it is told.
    fn follows_again(&self, settings: &ContactSettings, unstated: f64) -> bool {
        let [modelled, measured] = self.velocities;
        let is_seen = unstated * measured.abs() > 0.5 * PLAY * settings.metre;
        is_seen && measured * modelled.signum() > AGAIN * modelled.abs()
    }

    /// Returns whether the arm is held back: for longer than an impact stops a motor at its largest torque.
    pub(super) fn is_held_back(&self, timing: &ContactTiming) -> bool {
        self.time > LASTS * unstated(timing)
    }
}

/// Returns a lag that nobody stated, s.
fn unstated(timing: &ContactTiming) -> f64 {
    UNSTATED.0.max(UNSTATED.1 * timing.reaction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Drive;

    fn timing() -> ContactTiming {
        ContactTiming::new(0.001, Drive { lag_s: 0.005, delay_periods: 1 }, 0.0, 0.0)
    }

    /// Returns how often an arm is held back in a second, and what is known at its end. `ways`: of model and tool in a period, mm.
    fn held_back(following: Following, ways: impl Fn(f64) -> [f64; 2]) -> (usize, Following) {
        held_back_by(following, 0.0, ways)
    }

    /// The same with a drive of this stiffness, N/m.
    fn held_back_by(mut following: Following, stiffness: f64, ways: impl Fn(f64) -> [f64; 2]) -> (usize, Following) {
        let periods = (0..1000).map(f64::from);
        let count = periods.filter(|k| {
            let [modelled, measured] = ways(*k).map(|way| 1e-3 * way);
            let change = stiffness * (modelled - measured);
            following.add((&ContactSettings::default(), &timing()), ([modelled, measured], change), 1e-3);
            following.is_held_back(&timing())
        });
        (count.count(), following)
    }

    #[test]
    fn an_arm_that_does_less_than_half_of_what_it_is_told_is_held_back() {
        for (share, is) in [(0.0, true), (0.2, true), (0.4, true), (0.8, false), (1.0, false), (1.2, false)] {
            let (count, at_end) = held_back(Following::START, |_| [0.02, 0.02 * share]);
            assert_eq!((count > 0, at_end.is_held_back(&timing())), (is, is), "{share}: {count}");
        }
    }

    #[test]
    fn lags_that_nobody_stated_play_and_rest_hold_no_arm_back() {
        let late = |lag: f64| move |k: f64| [0.05, if k < lag { 0.0 } else { 0.05 }];
        let there_and_back = |k: f64| (k / 50.0).sin();
        for lag in [20.0, 80.0] {
            assert_eq!(held_back(Following::START, late(lag)).0, 0, "{lag}");
        }
        assert_eq!(held_back(Following::START, |k| [0.002 * there_and_back(k), 0.0]).0, 0);
        assert_eq!(held_back(Following::START, |k| [0.0, 0.01 * there_and_back(k)]).0, 0);
    }

    #[test]
    fn a_drive_that_yields_to_the_force_holds_no_arm_back() {
        for stiffness in [5e3, 3e4, 1e5] {
            assert_eq!(held_back_by(Following::START, stiffness, |_| [0.02, 0.0]).0, 0, "{stiffness}");
        }
    }

    #[test]
    fn a_released_arm_follows_again() {
        let (_, held) = held_back(Following::START, |_| [0.02, 0.0]);
        let (_, free) = held_back(held, |_| [0.02, 0.02]);
        assert!(held.is_held_back(&timing()) && !free.is_held_back(&timing()));
    }
}
