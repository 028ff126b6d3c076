//! Looking ahead: a virtual arm that has reached its targets, and joints that follow it within V and A.
//!
//! Two questions are separate here: at which posture all tasks reach their targets at each time ahead ([`target_posture`]), and how
//! each joint gets there ([`joint_law`]). The velocities of the joints are only wishes. The resolution with its limits has the last word.

mod arrival;
mod joint_law;
mod line_speed;
mod newton;
mod plan;
mod scene;
mod target_posture;

use std::ops::RangeInclusive;

use self::joint_law::{Capability, Joint};
use self::plan::Plan;
pub(super) use self::scene::Scene;
use self::target_posture::{NEAR, Place, TargetPosture};
use crate::controller::config::ControllerConfig;
use crate::controller::state::{FIRST_LATER, LINE_INTERVALS, Line, TIMES_AHEAD, VirtualArm, has_jumped};
use crate::law::MotionPath;
use crate::linalg::{Vector, dot};

/// Distance of the virtual arm from its targets that tells that they have jumped, m and rad together: they move less in a period.
const FAR: f64 = 0.1;

/// Steps per time and period, for the first time and for later ones.
const STEPS: [RangeInclusive<usize>; 2] = [1..=8, 1..=4];

/// The same for a place of a line, where the motion in the null space must have ended.
const STEPS_TO_PLACE: RangeInclusive<usize> = 3..=5;

/// Number of the later postures that are computed in a period.
const TURNS: usize = 2;

/// Without a jump of the targets, the virtual arm jumps if a joint moves by more than this many periods at full speed, and a little
/// more, rad or m.
const JUMP: (f64, f64) = (2.0, 1e-3);

/// Largest mean speed of a virtual joint that is planned for, in speed limits: it may be faster for a while.
const REACH: f64 = 2.0;

/// Distance (m and rad together) and speed (per s) from which on a resting target has jumped, and the tool moves on a line.
const LINE: (f64, f64) = (0.005, 1.0);

/// Places of a line that are computed in one period.
const PLACES: usize = 2;

/// Share of the acceleration limit with which joints return to the line.
const CORRECTION: f64 = 0.3;

/// Distance from the targets at which a line ends, m and rad together.
const END: f64 = 1e-4;

/// Shares of its acceleration limit that a predicted motion needs of a joint, up to which the joints follow the virtual arm alone, and
/// from which on not at all. Joints that each lag in their own way would turn the tool far from its orientation.
const TRUST: (f64, f64) = (0.6, 1.0);

/// A line is slow if it takes longer than this many times the way of the joints from its start to its end, and this time more, s.
const SLOW: (f64, f64) = (3.0, 0.5);

/// The virtual arm and the memory in which it is computed.
#[derive(Debug)]
pub(in crate::controller) struct LookAhead {
    arm: VirtualArm,
    posture: TargetPosture,
    plan: Plan,
    can: Vec<Capability>,
    velocity: Vector,
}

impl LookAhead {
    /// Allocates the virtual arm of a checked configuration; `None`: no law looks ahead.
    pub fn new(config: &ControllerConfig) -> Option<Self> {
        config.path()?;
        let n = config.robot.joint_count();
        Some(Self {
            arm: VirtualArm::at(&vec![0.0; n]),
            posture: TargetPosture::new(config)?,
            plan: Plan::new(),
            can: Vec::with_capacity(n),
            velocity: Vector::zeros(n),
        })
    }

    /// Returns the virtual arm of this period.
    pub fn virtual_arm(&self) -> &VirtualArm {
        &self.arm
    }

    /// Moves the virtual arm on to this period, and returns the velocities of the joints that follow it (n), and their share: the rest is
    /// for the laws without foresight. `None`: the virtual arm jumps.
    pub fn update(&mut self, scene: Scene) -> Option<(&Vector, f64)> {
        self.recall(scene);
        if scene.config.path() == Some(MotionPath::Straight) {
            self.update_line(scene);
            if self.arm.line.is_some() {
                return self.follow_line(scene).then_some((&self.velocity, 1.0));
            }
        }
        self.arm.advance(scene.config.period_s);
        let Self { arm, posture, velocity, .. } = self;
        velocity.as_mut_slice().copy_from_slice(&arm.postures[0]);
        let [first, last] =
            posture.approach(scene, Place::target(TIMES_AHEAD[0]), &mut arm.postures[0], STEPS[0].clone(), None);
        let has_new_target = first > FAR && last < NEAR;
        if !has_new_target && jumps(velocity.as_slice(), &arm.postures[0], scene) {
            arm.stand_from(1);
            return None;
        }
        let mut share = 1.0;
        if (1..TIMES_AHEAD.len()).all(|k| posture.same_targets(scene, [TIMES_AHEAD[0], TIMES_AHEAD[k]])) {
            arm.stand_from(1);
            self.arrive(scene);
        } else if scene.knows_targets() {
            let turns = self.arm.next..self.arm.next + TURNS;
            self.look_ahead(scene, |k| k < FIRST_LATER || has_new_target || turns.contains(&k));
            self.arm.next = if turns.end < TIMES_AHEAD.len() { turns.end } else { FIRST_LATER };
            self.follow(scene, Joint::following);
        } else {
            self.look_ahead(scene, |k| k < FIRST_LATER);
            self.arm.stand_from(FIRST_LATER);
            self.follow(scene, Joint::predicting);
            share = self.trust(scene);
        }
        Some((&self.velocity, share))
    }

    /// Continues from the virtual arm of the last period, or from the real one.
    fn recall(&mut self, scene: Scene) {
        let measured = scene.arm.measured().configuration.joint_position();
        let before = scene.previous.answered.as_ref().map(|before| before.joint_position.as_slice());
        match &scene.previous.virtual_arm {
            Some(known) if before.is_none_or(|before| !has_jumped(measured, before)) => self.arm.copy_from(known),
            _ => self.arm.stand_at(scene.position()),
        }
    }

    /// Begins a line when resting targets have jumped, and ends one that is given up when the arm has arrived.
    fn update_line(&mut self, scene: Scene) {
        let Self { arm: VirtualArm { postures, line, .. }, posture, .. } = self;
        let (least, speed) = LINE;
        let far = least + speed * scene.config.period_s;
        let is_given_up = line.as_ref().is_some_and(|line| line.is_given_up);
        if is_given_up {
            postures[0].copy_from_slice(scene.position());
        }
        let error = match &*line {
            Some(line) if is_given_up => posture.measure(scene, place_on(&line.offset, 0.0), &line.postures[0]),
            Some(line) => posture.measure(scene, place_on(&line.offset, line.progress), &postures[0]),
            None => posture.measure(scene, Place::target(TIMES_AHEAD[0]), &postures[0]),
        };
        let rests = posture.same_targets(scene, [TIMES_AHEAD[0], TIMES_AHEAD[TIMES_AHEAD.len() - 1]]);
        let has_changed = error > far;
        if is_given_up
            && (has_changed || !rests || posture.measure(scene, Place::target(TIMES_AHEAD[0]), &postures[0]) < far)
        {
            *line = None;
        }
        if rests && has_changed {
            posture.measure(scene, Place::target(TIMES_AHEAD[0]), &postures[0]);
            line.get_or_insert_default().start(&postures[0], posture.measured());
        }
    }

    /// Moves the virtual arm on along its line, and computes the velocities of the joints that follow it; returns whether there is a line.
    fn follow_line(&mut self, scene: Scene) -> bool {
        self.extend_line(scene);
        let Self { arm, posture, can, velocity, .. } = self;
        let VirtualArm { postures, line: Some(line), .. } = arm else { return false };
        if line.is_given_up {
            return false;
        }
        let before = line.progress;
        let ends = line_speed::advance(line, can, scene.config.period_s);
        let (now, later) = postures.split_at_mut(1);
        let (now, next) = (&mut now[0], &mut later[0]);
        for (j, (next, now)) in next.iter_mut().zip(&*now).enumerate() {
            *next = now + line_speed::position_at(line, line.progress, j) - line_speed::position_at(line, before, j);
        }
        posture.approach(scene, place_on(&line.offset, line.progress), next, STEPS[1].clone(), None);
        for (j, velocity) in velocity.iter_mut().enumerate() {
            let joint = joint(scene, j);
            let rate = (next[j] - now[j]) / joint.period;
            *velocity = joint.tracking(now[j], rate, CORRECTION * joint.can.acceleration);
        }
        now.copy_from_slice(next);
        if ends || (1.0 - line.progress) * dot(&line.offset, &line.offset).sqrt() < END {
            arm.line = None;
        }
        arm.stand_from(1);
        true
    }

    /// Computes further places of the line, and how fast the joints can move along it.
    fn extend_line(&mut self, scene: Scene) {
        let Self { arm, posture, can, velocity, .. } = self;
        let Some(line) = &mut arm.line else { return };
        can.clear();
        can.extend((0..velocity.len()).map(|j| capability(scene, j)));
        let first = line.postures.len();
        if first > LINE_INTERVALS || line.is_given_up {
            return;
        }
        for i in first..(first + PLACES).min(LINE_INTERVALS + 1) {
            let last = &line.postures[i - 1];
            let before = line.postures.get(i.wrapping_sub(2)).unwrap_or(last);
            let mut next: Vec<f64> = last.iter().zip(before).map(|(last, before)| 2.0 * last - before).collect();
            let place = place_on(&line.offset, i as f64 / LINE_INTERVALS as f64);
            let [_, last] = posture.approach(scene, place, &mut next, STEPS_TO_PLACE, None);
            line.is_given_up |= last > NEAR;
            line.postures.push(next);
        }
        line_speed::update_speeds(line, can);
        line.is_given_up |= line.postures.len() > LINE_INTERVALS && is_slow(line, can);
    }

    /// Moves the postures of some times ahead towards their targets.
    fn look_ahead(&mut self, scene: Scene, is_due: impl Fn(usize) -> bool) {
        let Self { arm, posture, .. } = self;
        for k in (1..TIMES_AHEAD.len()).filter(|k| is_due(*k)) {
            let (before, later) = arm.postures.split_at_mut(k);
            let restart = Some((FAR, before[k - 1].as_slice()));
            posture.approach(scene, Place::target(TIMES_AHEAD[k]), &mut later[0], STEPS[1].clone(), restart);
        }
    }

    /// Computes the velocities to a virtual arm that rests.
    fn arrive(&mut self, scene: Scene) {
        let (target, position) = (&self.arm.postures[0], scene.position());
        let time = |j: usize| arrival::time(target[j] - position[j], capability(scene, j));
        let slowest = (0..position.len()).map(time).fold(0.0, f64::max);
        for (j, velocity) in self.velocity.iter_mut().enumerate() {
            *velocity = joint(scene, j).arriving(target[j], arrival::share(time(j), slowest));
        }
    }

    /// Returns the share of the velocities that follow a predicted motion: less than 1 if a joint needs almost all of its acceleration.
    fn trust(&self, scene: Scene) -> f64 {
        let (all, none) = TRUST;
        let ahead = |j: usize| std::array::from_fn(|k| self.arm.postures[k][j]);
        let needed = |j: usize| joint_law::acceleration_now(&ahead(j)).abs() / capability(scene, j).acceleration;
        let most = (0..self.velocity.len()).map(needed).fold(0.0, f64::max);
        ((none - most) / (none - all)).clamp(0.0, 1.0)
    }

    /// Computes the velocities that follow a virtual arm that moves, by a law of each joint.
    fn follow(&mut self, scene: Scene, law: impl Fn(&Joint, &[f64; TIMES_AHEAD.len()], &Plan) -> f64) {
        let Self { arm, plan, velocity, .. } = self;
        for (j, velocity) in velocity.iter_mut().enumerate() {
            let (joint, first) = (joint(scene, j), arm.postures[0][j]);
            // A posture on another branch is no place to plan for.
            let ahead = std::array::from_fn(|k| {
                let reach = REACH * joint.can.speed * TIMES_AHEAD[k];
                arm.postures[k][j].clamp(first - reach, first + reach)
            });
            *velocity = law(&joint, &ahead, plan);
        }
    }
}

/// Returns whether a line that is known to its end is slow: a detour of the joints, as near a singular posture.
fn is_slow(line: &Line, can: &[Capability]) -> bool {
    let (factor, more) = SLOW;
    let [start, end] = [&line.postures[0], &line.postures[LINE_INTERVALS]];
    let way = |j: usize| arrival::time(end[j] - start[j], can[j]);
    line_speed::time(line) > factor * (0..can.len()).map(way).fold(0.0, f64::max) + more
}

/// Returns a place on the line to resting targets.
fn place_on(offset: &[f64], progress: f64) -> Place<'_> {
    Place { after: TIMES_AHEAD[0], offset, left: 1.0 - progress }
}

fn capability(scene: Scene, j: usize) -> Capability {
    let can = &scene.arm.capability;
    Capability { speed: can.speed[j], acceleration: can.deceleration[j], jerk: can.jerk[j] }
}

fn joint(scene: Scene, j: usize) -> Joint {
    let Scene { config, arm, .. } = scene;
    Joint {
        position: scene.position()[j],
        last_command: arm.last_command[j],
        can: capability(scene, j),
        period: config.period_s,
    }
}

/// Returns whether a virtual arm moves (from n, to n) in a way that joints cannot follow, as to another branch.
fn jumps(before: &[f64], now: &[f64], scene: Scene) -> bool {
    let (periods, least) = JUMP;
    let time = periods * scene.config.period_s;
    let mut ways = now.iter().zip(before).zip(&scene.arm.capability.speed);
    ways.any(|((now, before), speed)| (now - before).abs() > time * speed + least)
}
