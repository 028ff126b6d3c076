//! The virtual arm on a line to resting targets that have jumped.

use std::ops::RangeInclusive;

use super::joint_law::Capability;
use super::scene::Scene;
use super::target_posture::{NEAR, Place};
use super::{LookAhead, arrival, capability, joint, line_speed};
use crate::controller::state::{LINE_INTERVALS, Line, TIMES_AHEAD, VirtualArm};
use crate::linalg::{all_finite, dot};

/// Distance (m and rad together) and speed (per s) from which on a resting target has jumped.
const JUMP: (f64, f64) = (0.005, 1.0);

/// Steps to a place of the line. The motion in the null space must have ended there.
const STEPS_TO_PLACE: RangeInclusive<usize> = 3..=5;

/// Steps to the place of the next period.
const STEPS: RangeInclusive<usize> = 1..=4;

/// Places of a line that are computed in one period.
const PLACES: usize = 2;

/// A line is slow if it takes longer than this many times the way of the joints from its start to its end, and this time more, s.
const SLOW: (f64, f64) = (3.0, 0.5);

/// Share of the acceleration limit with which joints return to the line.
const CORRECTION: f64 = 0.3;

/// Distance of a joint from the virtual one up to which a line begins, and from which on it is given up, rad or m.
const OFF: (f64, f64) = (0.02, 0.15);

/// Distance from the targets at which a line ends, m and rad together.
const END: f64 = 1e-4;

impl LookAhead {
    /// Begins a line when resting targets have jumped, and ends one that is given up when the arm has arrived.
    pub(super) fn update_line(&mut self, scene: Scene) {
        let Self { arm: VirtualArm { postures, line, .. }, posture, .. } = self;
        let (least, speed) = JUMP;
        let far = least + speed * scene.config.period_s;
        let target = Place::target(TIMES_AHEAD[0]);
        let is_given_up = line.as_ref().is_some_and(|line| line.is_given_up);
        if is_given_up {
            postures[0].copy_from_slice(scene.position());
        }
        let error = match &*line {
            Some(line) if is_given_up => posture.measure(scene, place_on(&line.offset, 0.0), &line.postures[0]),
            Some(line) => posture.measure(scene, place_on(&line.offset, line.progress), &postures[0]),
            None => posture.measure(scene, target, &postures[0]),
        };
        let rests = posture.same_targets(scene, [TIMES_AHEAD[0], TIMES_AHEAD[TIMES_AHEAD.len() - 1]]);
        let has_changed = error > far;
        if is_given_up && (has_changed || !rests || posture.measure(scene, target, &postures[0]) < far) {
            *line = None;
        }
        if rests && has_changed {
            write_stop(&mut postures[0], scene);
            posture.measure(scene, target, &postures[0]);
            line.get_or_insert_default().start(&postures[0], posture.measured());
        }
    }

    /// Moves the virtual arm on along its line, and computes the velocities of the joints that follow it; returns whether there is a
    /// line that they follow.
    pub(super) fn follow_line(&mut self, scene: Scene) -> bool {
        self.extend_line(scene);
        let Self { arm, posture, can, velocity, .. } = self;
        let VirtualArm { postures, line: Some(line), .. } = arm else { return false };
        let (begins, lost) = OFF;
        let distances = scene.position().iter().zip(&postures[0]).map(|(p, q)| (p - q).abs());
        let off = distances.fold(0.0, f64::max);
        let waits = line.progress == 0.0 && off > begins;
        line.is_given_up |= line.progress > 0.0 && off > lost;
        if line.is_given_up {
            return false;
        }
        let before = line.progress;
        let ends = !waits && line_speed::advance(line, can, scene.config.period_s);
        let (now, later) = postures.split_at_mut(1);
        let (now, next) = (&mut now[0], &mut later[0]);
        for (j, (next, now)) in next.iter_mut().zip(&*now).enumerate() {
            *next = now + line_speed::position_at(line, line.progress, j) - line_speed::position_at(line, before, j);
        }
        posture.approach(scene, place_on(&line.offset, line.progress), next, STEPS, None);
        for (j, velocity) in velocity.iter_mut().enumerate() {
            let joint = joint(scene, j);
            let rate = (next[j] - now[j]) / joint.period;
            let room = if waits { joint.can.acceleration } else { CORRECTION * joint.can.acceleration };
            *velocity = joint.tracking(now[j], rate, room);
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
            line.is_given_up |= !(last <= NEAR);
            if !all_finite(&next) {
                line.is_given_up = true;
                break;
            }
            line.postures.push(next);
        }
        line_speed::update_speeds(line, can);
        line.is_given_up |= line.postures.len() > LINE_INTERVALS && is_slow(line, can);
    }
}

/// Overwrites a posture (n) with the nearest one at which the joints can stop.
fn write_stop(posture: &mut [f64], scene: Scene) {
    for (j, (q, p)) in posture.iter_mut().zip(scene.position()).enumerate() {
        let joint = joint(scene, j);
        let limits = &scene.config.robot.joints()[j].limits;
        let way = joint.last_command * joint.last_command.abs() / (2.0 * joint.can.acceleration);
        *q = if scene.config.keeps_positions() { (p + way).clamp(limits.lower, limits.upper) } else { p + way };
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
