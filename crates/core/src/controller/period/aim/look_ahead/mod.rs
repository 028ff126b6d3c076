//! Looking ahead: a virtual arm that has reached its targets, and joints that follow it within V and A.
//!
//! Two questions are separate here: at which posture all tasks reach their targets at each time ahead ([`target_posture`]), and how
//! each joint gets there ([`joint_law`]). The velocities of the joints are only wishes. The resolution with its limits has the last word.

mod arrival;
mod joint_law;
mod line_motion;
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
use crate::controller::state::{FIRST_LATER, Memory, TIMES_AHEAD, VirtualArm, has_jumped};
use crate::law::MotionPath;
use crate::linalg::Vector;
use crate::streaming::ActiveStream;

/// Distance of the virtual arm from its targets that tells that they have jumped, m and rad together: they move less in a period.
const FAR: f64 = 0.1;

/// Steps per time and period, for the first time and for later ones.
const STEPS: [RangeInclusive<usize>; 2] = [1..=8, 1..=4];

/// Number of the later postures that are computed in a period.
const TURNS: usize = 2;

/// Without a jump of the targets, the virtual arm jumps if a joint moves by more than this many periods at full speed, and a little
/// more, rad or m.
const JUMP: (f64, f64) = (2.0, 1e-3);

/// Largest mean speed of a virtual joint that is planned for, in speed limits: it may be faster for a while.
const REACH: f64 = 2.0;

/// Time constant with which the accelerations of streamed targets are smoothed, s.
const SMOOTHING: f64 = 0.08;

/// Shares of its acceleration limit that a predicted motion needs of a joint, up to which the joints follow the virtual arm alone, and
/// from which on not at all. Joints that each lag in their own way would turn the tool far from its orientation.
const TRUST: (f64, f64) = (0.6, 1.0);

/// The virtual arm and the memory in which it is computed.
#[derive(Debug)]
pub(in crate::controller) struct LookAhead {
    arm: VirtualArm,
    posture: TargetPosture,
    plan: Plan,
    can: Vec<Capability>,
    velocity: Vector,
    /// The smoothed accelerations of the streamed targets of this period.
    accelerations: Vec<Vec<f64>>,
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
            accelerations: Vec::new(),
        })
    }

    /// Returns the virtual arm of this period.
    pub fn virtual_arm(&self) -> &VirtualArm {
        &self.arm
    }

    /// Smooths the accelerations of the streamed targets: from one target to the next they are mostly noise. `period`: T, s.
    pub fn smooth(&mut self, streams: &mut [ActiveStream], previous: &Memory, period: f64) {
        let before = previous.virtual_arm.as_ref().map_or(&[][..], |arm| &arm.target_accelerations);
        self.accelerations.resize_with(streams.len(), Vec::new);
        let blend = period / (SMOOTHING + period);
        for (active, smoothed) in streams.iter_mut().zip(&mut self.accelerations) {
            let (rows, key) = (active.acceleration.len(), active.key());
            // A stream that has started since then may have moved this one to another place.
            let place = previous.target_streams.iter().position(|stream| (stream.task, stream.quantity) == key);
            smoothed.clear();
            match place.and_then(|place| before.get(place)).filter(|before| before.len() == rows) {
                Some(before) => smoothed.extend_from_slice(before),
                None => smoothed.resize(rows, 0.0),
            }
            for (smoothed, entry) in smoothed.iter_mut().zip(active.acceleration.iter_mut()) {
                *smoothed += blend * (*entry - *smoothed);
                *entry = *smoothed;
            }
        }
    }

    /// Puts the virtual arm where the real one comes to rest, for a period that does not follow it.
    pub fn stand(&mut self, scene: Scene) {
        self.arm.stand_at(scene.position());
        self.arm.target_accelerations.clone_from(&self.accelerations);
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
            self.follow(scene, |joint, ahead, _| joint.predicting(ahead));
            share = self.trust(scene);
        }
        Some((&self.velocity, share))
    }

    /// Continues from the virtual arm of the last period, or from the real one.
    fn recall(&mut self, scene: Scene) {
        match &scene.previous.virtual_arm {
            Some(known) if !has_jumped(scene.arm.moved.iter().copied()) => self.arm.copy_from(known),
            _ => self.arm.stand_at(scene.position()),
        }
        self.arm.target_accelerations.clone_from(&self.accelerations);
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
