//! What a controller remembers so that its arm comes to rest: how its joints turn, and what its tasks gained by it.
//!
//! # Why
//!
//! A target out of reach, a singular posture or a limit can give a sampled loop behind a drive an unstable point of rest. Its joints
//! then swing or chatter for ever, although no task gains anything. So motion is free, but turning has a price, and tasks earn
//! when they come nearer to their targets than ever before. When a controller has spent its budget, its requests fade.
//!
//! # The budget
//!
//! In each period each joint pays for two kinds of turning:
//!
//! - *Velocity.* Let ℓ be the command at the last turning point and c the extreme since then. When the command is more than ε off c,
//!   c becomes a turning point, for t_0 max(0, |c − ℓ| − ε).
//! - *Position.* Let x_0, x_1 be the positions (at rest) of the last two turns and x_2 the extreme since then. When the joint is more
//!   than h off x_2, it has turned there, after the way a = |x_2 − x_1|. If x_2 is near x_0, it swings: it pays
//!   b r^m w a/(a + a_0), where w = max(0, 1 − 2|x_2 − x_0|/a), and m counts how often in a row w was above 0.2.
//!
//! For each position task let e be its distance from the target (m and rad together), and e* the least one since a target changed. A
//! period earns g = max(0, e* + d − e) + d for each task, where d is the way of its target in this period; e* ← min(e* + d, e). Then
//!
//! W ← clamp(W + Σ paid − κ Σ g − T W/τ, 0, l + l_1) and s = clamp((l − W)/l_0, 0, 1).
//!
//! s scales all requests of the next period alike, so that their balance stays. τ = τ_0 2^k, where k counts how often W has reached
//! l. Targets that move faster than v_0 or jump start anew with W = 0, and so does an arm that is elsewhere than in the period before:
//! joints that follow a moving target turn with it, and those that make way for a moving obstacle turn with that. A motion that
//! leaves a posture ([`Progress`](super::Progress)) neither pays nor fades, and starts anew as well; there are at most
//! [`MAX_ATTEMPTS`](crate::controller::MAX_ATTEMPTS) of these.
//!
//! # What remains
//!
//! *Claim.* Let the targets and the obstacles rest, and let nothing start anew. From any time on, what joints pay in a time t, each payment
//! counted as far as W takes it, is at most (l + l_1)(1 + t/τ) + κ Σ e, with the τ and the e at the start. While W ≥ l all requests are zero.
//! So the rate of paying is halved each time W has reached l, until k is at its largest.
//!
//! *Proof.* W stays between 0 and l + l_1, and τ never falls. e* never grows while d = 0, so Σ g is at most Σ e. What is paid is the change
//! of W, what is forgotten, ∫ W/τ, and κ Σ g. ∎
//!
//! What has no price remains: commands that change by at most ε, and joints that turn by at most h with less than ε.
//!
//! # The constants
//!
//! They were chosen with 1500 random loops (`tests/controller/rest.rs`), and tried with others.

use crate::streaming::TargetValue;

/// ε, change of a command that counts as no turning point, rad/s or m/s: above the noise of measured positions times usual gains.
const EPSILON: f64 = 0.02;

/// t_0, s: two joints that change between ±2 rad/s in each period spend everything in a dozen periods.
const TURN: f64 = 0.02;

/// h, rad or m: above the noise of measured positions.
const HYSTERESIS: f64 = 0.004;

/// b and a_0, rad or m: what the first swing over a large way costs, and the way at which it costs half of it.
const SWING: (f64, f64) = (0.05, 0.05);

/// w above which a joint turns where it has turned before.
const SAME_TURN: f64 = 0.2;

/// r, and the largest m − 1: an arm that approaches its target may turn twice at the same place, seldom four times.
const GROWTH: (f64, u32) = (3.0, 6);

/// κ, 1/m and 1/rad: progress by a decimetre pays the start and the stop of most joints.
const GAIN: f64 = 5.0;

/// l: what approaches over long ways through singular postures need.
const BUDGET: f64 = 2.1;

/// l_0: s fades over this part of the budget.
const FADING: f64 = 0.3;

/// l_1: what may be spent beyond l, so that a little progress does not wake an arm at once.
const BEYOND: f64 = 0.6;

/// τ_0, s, and the largest k: two and a half years.
const FORGETTING: (f64, u32) = (600.0, 17);

/// Way of a target in one period from which on it is another target, m or rad.
const TARGET_JUMP: f64 = 0.02;

/// v_0, speed of all targets together from which on they move, m/s and rad/s.
const TARGET_SPEED: f64 = 1e-3;

/// Way of a joint from state to state from which on the arm is elsewhere, rad or m: no arm moves so far in a period.
const ARM_JUMP: f64 = 0.2;

/// What a controller remembers so that its arm comes to rest.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RestState {
    /// W.
    pub spent: f64,
    /// k, how often W has reached l.
    pub exhausted: u32,
    /// Time since which requests fade, s; `None`: they do not.
    pub fading_since_s: Option<f64>,
    /// How each joint turns, n.
    pub joints: Vec<JointTurns>,
    /// What each task has gained; `None`: the task follows no position.
    pub tasks: Vec<Option<TaskGain>>,
}

/// How a joint turns.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointTurns {
    /// ℓ and c, rad/s or m/s.
    pub velocity: [f64; 2],
    /// Whether the command falls since the last turning point.
    pub falls: bool,
    /// x_0, x_1 and x_2, rad or m; `None`: the joint has not moved.
    pub position: Option<[f64; 3]>,
    /// m.
    pub repeats: u32,
}

/// What a task has gained.
#[derive(Debug, PartialEq)]
pub struct TaskGain {
    /// e*, m and rad together.
    pub least: f64,
    /// The target.
    pub target: TargetValue,
}

/// The way of a target, and what its task gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::controller) enum Gained {
    /// The target is another one.
    NewTarget,
    /// g and d.
    Earned { gain: f64, way: f64 },
}

impl RestState {
    /// Returns the state of joints (n) that have not moved.
    pub(in crate::controller) fn new(n: usize, tasks: usize) -> Self {
        Self { joints: vec![JointTurns::default(); n], tasks: vec![None; tasks], ..Self::default() }
    }

    /// Returns whether the numbers are finite, and fit n joints and tasks.
    pub(in crate::controller) fn is_valid(&self, n: usize, tasks: usize) -> bool {
        let of_joints =
            self.joints.iter().flat_map(|joint| joint.velocity.into_iter().chain(joint.position.into_iter().flatten()));
        let of_tasks = self.tasks.iter().flatten();
        self.joints.len() == n
            && self.tasks.len() == tasks
            && (0.0..=BUDGET + BEYOND).contains(&self.spent)
            && self.fading_since_s.is_none_or(f64::is_finite)
            && of_joints.into_iter().all(f64::is_finite)
            && of_tasks.into_iter().all(|gain| gain.least >= 0.0 && gain.least.is_finite() && gain.target.is_valid())
    }

    /// Returns s, the share of all requests that remains.
    pub(in crate::controller) fn share(&self) -> f64 {
        ((BUDGET - self.spent) / FADING).clamp(0.0, 1.0)
    }

    /// Starts anew.
    pub(in crate::controller) fn restart(&mut self) {
        (self.spent, self.exhausted, self.fading_since_s) = (0.0, 0, None);
        self.joints.fill(JointTurns::default());
    }

    /// Updates to the command for a state at `time_s`, and what the tasks earned. `joints`: commands (n) and positions at rest (n);
    /// `period`: T, s.
    pub(in crate::controller) fn update(&mut self, time_s: f64, joints: (&[f64], &[f64]), earned: f64, period: f64) {
        let joints = self.joints.iter_mut().zip(joints.0.iter().zip(joints.1));
        let paid: f64 =
            joints.map(|(joint, (u, position))| joint.velocity_price(*u) + joint.position_price(*position)).sum();
        let (first, most) = FORGETTING;
        let forgetting = first * f64::from(1_u32 << self.exhausted.min(most));
        let spent = self.spent + paid - GAIN * earned - period * self.spent / forgetting;
        if spent >= BUDGET && self.spent < BUDGET {
            self.exhausted = (self.exhausted + 1).min(most);
        }
        self.spent = spent.clamp(0.0, BUDGET + BEYOND);
        self.fading_since_s = (self.share() < 1.0).then(|| self.fading_since_s.unwrap_or(time_s));
    }
}

/// Returns whether targets that went `way` (m and rad) in a period (T, s) move.
pub(in crate::controller) fn are_moving(way: f64, period: f64) -> bool {
    way > TARGET_SPEED * period
}

/// Returns whether an arm that has moved so far since the state before is elsewhere.
pub(in crate::controller) fn has_jumped(moved: impl IntoIterator<Item = f64>) -> bool {
    moved.into_iter().any(|way| way.abs() > ARM_JUMP)
}

impl JointTurns {
    fn velocity_price(&mut self, u: f64) -> f64 {
        let [last, extreme] = self.velocity;
        if if self.falls { u <= extreme } else { u >= extreme } {
            self.velocity[1] = u;
            return 0.0;
        }
        if (u - extreme).abs() <= EPSILON {
            return 0.0;
        }
        (self.velocity, self.falls) = ([extreme, u], !self.falls);
        TURN * ((extreme - last).abs() - EPSILON).max(0.0)
    }

    fn position_price(&mut self, position: f64) -> f64 {
        let [before, last, extreme] = self.position.get_or_insert([position; 3]);
        if if extreme < last { position <= *extreme } else { position >= *extreme } {
            *extreme = position;
            return 0.0;
        }
        if (position - *extreme).abs() <= HYSTERESIS {
            return 0.0;
        }
        let (way, off) = ((*extreme - *last).abs(), (*extreme - *before).abs());
        (*before, *last, *extreme) = (*last, *extreme, position);
        // The first turn has no way.
        if way == 0.0 {
            return 0.0;
        }
        let again = (1.0 - 2.0 * off / way).max(0.0);
        let (growth, most) = GROWTH;
        self.repeats = if again > SAME_TURN { (self.repeats + 1).min(most + 1) } else { 0 };
        let (largest, half) = SWING;
        let growth = (1..self.repeats).fold(1.0, |growth_so_far, _| growth_so_far * growth);
        largest * growth * again * way / (way + half)
    }
}

impl Clone for TaskGain {
    fn clone(&self) -> Self {
        Self { least: self.least, target: self.target.clone() }
    }

    // Without allocating.
    fn clone_from(&mut self, source: &Self) {
        self.least = source.least;
        self.target.copy_from(&source.target);
    }
}

/// Larger distances count as this one, m and rad together: a memory has no larger numbers.
const FARTHEST: f64 = 1e9;

impl TaskGain {
    /// Updates the gain of a task to a distance from its target, m and rad together.
    pub(in crate::controller) fn update(gain: &mut Option<Self>, distance: f64, target: &TargetValue) -> Gained {
        let distance = distance.min(FARTHEST);
        let way = gain.as_ref().map_or(f64::INFINITY, |gain| target.distance(&gain.target));
        match gain {
            Some(gain) if way <= TARGET_JUMP => {
                let gained = (gain.least + way - distance).max(0.0);
                gain.least = (gain.least + way).min(distance);
                gain.target.copy_from(target);
                Gained::Earned { gain: gained + way, way }
            }
            _ => {
                *gain = Some(Self { least: distance, target: target.clone() });
                Gained::NewTarget
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::TaskVector;

    const PERIOD: f64 = 0.01;

    /// Returns s after each period of a joint whose position is a function of the period.
    fn shares(path: impl Fn(f64) -> f64, periods: u32) -> Vec<f64> {
        let mut state = RestState::new(1, 0);
        let step = |k: u32| {
            let [before, now] = [k, k + 1].map(|k| path(f64::from(k) * PERIOD));
            state.update(f64::from(k) * PERIOD, (&[(now - before) / PERIOD], &[before]), 0.0, PERIOD);
            state.share()
        };
        (0..periods).map(step).collect()
    }

    #[test]
    fn a_way_to_a_target_and_back_is_free_of_fading() {
        let there_and_back = shares(|t| (0.5 * t).min(4.0 - 0.5 * t).max(0.0), 1000);
        assert!(there_and_back.iter().all(|share| *share == 1.0));
    }

    #[test]
    fn swings_and_chatter_fade_out_and_small_noise_does_not() {
        let swing = |size: f64, seconds: f64| move |t: f64| size * (std::f64::consts::TAU * t / seconds).sin();
        for (size, seconds) in [(0.5, 4.0), (0.05, 1.0), (0.02, 0.3)] {
            let found = shares(swing(size, seconds), 4000);
            assert!(found.contains(&0.0), "{size} rad every {seconds} s: {:?}", found.last());
        }
        // ±1 rad/s, a period each.
        let chatter = shares(|t| 0.005 * (t / PERIOD).round().rem_euclid(2.0), 400);
        assert!(chatter.contains(&0.0), "{:?}", chatter.last());
        let noise = shares(|t| 1e-4 * (t / PERIOD).round().rem_euclid(2.0), 4000);
        assert!(noise.iter().all(|share| *share == 1.0));
    }

    #[test]
    fn progress_pays_for_turning_and_a_new_target_is_told() {
        let value = |x: f64| TargetValue::Rows(TaskVector::from_slice(&[x]));
        let mut gain = None;
        assert_eq!(TaskGain::update(&mut gain, 1.0, &value(0.0)), Gained::NewTarget);
        assert_eq!(TaskGain::update(&mut gain, 0.75, &value(0.0)), Gained::Earned { gain: 0.25, way: 0.0 });
        assert_eq!(TaskGain::update(&mut gain, 0.875, &value(0.0)), Gained::Earned { gain: 0.0, way: 0.0 });
        // The target moves away: its way is earned, and the task may be as far behind.
        assert_eq!(
            TaskGain::update(&mut gain, 0.765_625, &value(0.015_625)),
            Gained::Earned { gain: 0.015_625, way: 0.015_625 }
        );
        assert_eq!(TaskGain::update(&mut gain, 0.75, &value(1.0)), Gained::NewTarget);
    }

    #[test]
    fn exhausted_joints_rest_longer_each_time() {
        let mut state = RestState::new(1, 0);
        let mut rests = Vec::new();
        let mut awake_at = 0.0;
        for k in 0..40_000_u32 {
            let (time, share) = (0.1 * f64::from(k), state.share());
            let u = share * if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            let exhausted = state.exhausted;
            state.update(time, (&[u], &[0.0]), 0.0, 0.1);
            if state.exhausted > exhausted {
                rests.push(time - awake_at);
                awake_at = time;
            }
        }
        assert!(rests.len() < 8 && rests.windows(2).skip(1).all(|pair| pair[1] > 1.5 * pair[0]), "{rests:?}");
    }
}
