//! Linear rows that tell the solver how its command changes distances along the stop.
//!
//! Let u_b be the command of full braking, and let the arm hold u_b for τ and then stop; at some places of that way, let y be
//! how far the common normal of a pair separates two ends of its shapes, less d_min and a margin ε, and y_0 the distance now, less the same.
//! A command u instead of u_b moves joint j there by m_j (u_j − u_bj) to first order: m_j is what a pulse of height 1 and length
//! τ + |u_bj|/A_j moves behind the drive until then. With g the gradient of the separation, the rows are
//!
//! > Σ_j g_j m_j (u_j − u_bj) ≥ (1 − κ) min(y, y_0) − y, κ = min(1, γ θ), θ = τ + ½ max_j |u_bj|/A_j.
//!
//! At rest this is g·u ≥ −γ y_0: the distance shrinks at most like e^(−γ t). At speed it says that the stop ends free. A stop that leads away
//! from an obstacle (y > y_0) may end where the arm is now: if it had to lead away as far, an arm could not come to rest.
//!
//! The places are at fixed times, each 1.5 times the one before, at the end of the last period and at rest. So a place appears where
//! another one is, and the rows do not jump when a stop becomes longer.
//!
//! The rows have ends and a common normal in place of nearest points, because those jump where shapes are parallel. A row that no command
//! of the box violates is left out, which changes no answer. A row that asks for more than the box can do asks for what it can, so that
//! it does not outweigh others.
//!
//! A row asks for motion only where motion helps. With the share e of what the levers of the pair could change which g lets the box change,
//! a row that asks for more than u_b does asks for min(1, (e/e_0)²) of that in addition. Otherwise a joint that turns along a surface would race
//! to gain nothing: rounding of g, or of a normal that a user states, is no way to leave.

use std::sync::Arc;

use revprio_problem::{Inequality, VelocityBox};
use revprio_robot::collision::{CollisionModel, PlacedBody};
use revprio_robot::kinematics::Configuration;

use super::clearance::Scene;
use super::pair::Pair;
use super::stop::StopPath;
use crate::limits::{Drive, braking_deceleration};

/// Maximum number of places.
const PLACES: usize = 10;

/// Ratio of the times of two successive places.
const SPREAD: f64 = 1.5;

/// ε for periods up to 1 ms, m. Longer periods have more, in proportion.
const MARGIN: f64 = 2e-4;

/// e_0, share of its levers with which an arm can leave a surface. A surface tilted by 0.06° to the way of its nearest point gives it.
const EFFECTIVE: f64 = 1e-3;

/// Levels of the rows among the constraints. What stands comes first: an arm does not flee into a wall. What moves comes next, before all
/// constraints that state no level.
const STANDING: u8 = 0;
const MOVING: u8 = 1;

/// Name of a row that no pair needs.
pub const NAME: &str = "collision";

/// A place of the stop.
#[derive(Debug)]
struct Place {
    configuration: Configuration,
    body: PlacedBody,
    /// m_j, n, s.
    moved: Vec<f64>,
    /// How far each joint moves until here at most, n, rad or m.
    ways: Vec<f64>,
    time: f64,
}

/// The nominal stop and the box.
#[derive(Debug, Clone, Copy)]
pub struct Nominal<'a> {
    /// The way of the arm that holds u_b and then stops.
    pub path: &'a StopPath,
    /// u_b, n.
    pub command: &'a [f64],
    /// τ, s.
    pub held_s: f64,
    pub limits: &'a VelocityBox,
    pub drive: Drive,
    /// T, s.
    pub period: f64,
    /// γ, 1/s.
    pub rate: f64,
    /// Whether the joints keep their jerk limits.
    pub keeps_jerk: bool,
}

impl Nominal<'_> {
    /// Returns the number of places and their nodes on the path.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most SPREAD^PLACES (1 + 10 ms/T)")]
    fn nodes(&self) -> (usize, [usize; PLACES]) {
        let (mut count, mut nodes) = (0, [0; PLACES]);
        let mut push = |node: usize| {
            nodes[count] = node;
            count += 1;
        };
        let mut after_dead_time = self.held_s / self.period;
        for _ in 0..PLACES - 2 {
            let node = self.drive.delay_periods + after_dead_time.round() as usize;
            if node >= self.path.last_period() {
                break;
            }
            push(node);
            after_dead_time *= SPREAD;
        }
        if self.drive.lag_s > 0.0 {
            push(self.path.last_period());
        }
        push(self.path.nodes() - 1);
        (count, nodes)
    }
}

/// The memory of the rows.
#[derive(Debug)]
pub struct Rows {
    places: Vec<Place>,
    /// Lengths of the pulses, n, s.
    pulses: Vec<f64>,
    /// Largest |u_j − u_bj| in the box, n.
    widths: Vec<f64>,
    gradient: Vec<f64>,
    /// Name of a row that no pair needs.
    unused: Arc<str>,
    /// How much the box can violate each written row at most, relative to its length.
    tightness: Vec<f64>,
}

/// A row and the pair that it belongs to.
struct Row<'a> {
    name: &'a Arc<str>,
    level: u8,
    /// a, n, and b of a·u ≤ b.
    coefficients: &'a [f64],
    bound: f64,
}

impl Rows {
    /// Allocates the memory; `configuration`: of the robot, at any posture.
    pub fn new(model: &CollisionModel, configuration: &Configuration, rows: usize) -> Self {
        let memory = vec![0.0; configuration.joint_position().len()];
        let place = || Place {
            configuration: configuration.clone(),
            body: PlacedBody::new(model, configuration),
            moved: memory.clone(),
            ways: memory.clone(),
            time: 0.0,
        };
        Self {
            places: (0..PLACES).map(|_| place()).collect(),
            pulses: memory.clone(),
            widths: memory.clone(),
            gradient: memory,
            unused: NAME.into(),
            tightness: Vec::with_capacity(rows),
        }
    }

    /// Overwrites the rows; those that are not needed always hold. Returns how many could matter.
    pub fn write(&mut self, scene: Scene, nominal: Nominal, distances: &[f64], rows: &mut [Inequality]) -> usize {
        self.tightness.clear();
        for row in rows.iter_mut() {
            row.rename(&self.unused);
            row.overwrite(|coefficients| {
                coefficients.fill(0.0);
                f64::INFINITY
            });
        }
        let theta = self.measure(nominal, scene);
        let count = self.place(scene, nominal);
        let share = (nominal.rate * theta).min(1.0);
        let margin = scene.min_distance + MARGIN * (nominal.period / 1e-3).max(1.0);
        let mut found = 0;
        for (pair, &distance) in scene.pairs.iter().zip(distances) {
            for k in 0..count {
                let place = &self.places[k];
                let way = pair.way(&place.ways, place.time, scene.world);
                if share * (distance - way - margin) < self.reach(pair, &place.moved) {
                    found += self.write_at(scene, nominal, (pair, k, share, margin), distance, rows);
                }
            }
        }
        found
    }

    /// Updates pulses and widths; returns θ.
    fn measure(&mut self, nominal: Nominal, scene: Scene) -> f64 {
        let mut longest: f64 = 0.0;
        for (joint, description) in scene.robot.joints().iter().enumerate() {
            let (limits, u_b) = (&description.limits, nominal.command[joint]);
            let deceleration = braking_deceleration(limits);
            let rise = if nominal.keeps_jerk && limits.jerk.is_finite() { deceleration / limits.jerk } else { 0.0 };
            let stop = u_b.abs() / deceleration;
            longest = longest.max(stop);
            self.pulses[joint] = nominal.held_s + stop + rise;
            let [lower, upper] = [nominal.limits.lower()[joint], nominal.limits.upper()[joint]];
            self.widths[joint] = (upper - u_b).max(u_b - lower).max(0.0);
        }
        nominal.held_s + 0.5 * longest
    }

    /// Moves the places along the way; returns their number.
    fn place(&mut self, scene: Scene, nominal: Nominal) -> usize {
        let path = nominal.path;
        let (count, nodes) = nominal.nodes();
        let last = path.nodes() - 1;
        let dead_time = nominal.drive.delay_periods as f64 * nominal.period;
        for (k, (place, node)) in self.places.iter_mut().zip(nodes).take(count).enumerate() {
            if place.configuration.update(scene.robot, path.position(node)).is_err() {
                return k;
            }
            place.body.update(scene.model, &place.configuration);
            path.write_ways((0, node), &mut place.ways);
            place.time = path.time(node);
            let since = if node == last { f64::INFINITY } else { place.time - dead_time };
            for (moved, pulse) in place.moved.iter_mut().zip(&self.pulses) {
                *moved = pulse_response(since, *pulse, nominal.drive.lag_s);
            }
        }
        count
    }

    /// Returns a bound of how much the commands of the box can change the distance of a pair, m; `moved`: n, s.
    fn reach(&self, pair: &Pair, moved: &[f64]) -> f64 {
        pair.levers.lever.iter().zip(moved).zip(&self.widths).map(|((lever, moved), width)| lever * moved * width).sum()
    }

    /// Writes the rows of a pair at a place; returns how many could matter. `distance`: of the pair now, m.
    fn write_at(
        &mut self,
        scene: Scene,
        nominal: Nominal,
        (pair, k, share, margin): (&Pair, usize, f64, f64),
        distance: f64,
        rows: &mut [Inequality],
    ) -> usize {
        let place = &self.places[k];
        let at = pair.separation(&place.body, scene.world, place.time);
        let spare = |y: f64| y - (1.0 - share) * y.min(distance - margin);
        let reach = self.reach(pair, &place.moved);
        if spare(at.distance - margin) >= reach {
            return 0;
        }
        let mut found = 0;
        for (points, separated) in pair.ends(&place.body, scene.world, place.time, &at.normal) {
            place.configuration.write_distance_gradient(points, &at.normal, &mut self.gradient);
            let mut bound = spare(separated - margin) / nominal.held_s;
            let (mut least, mut most, mut braking) = (0.0, 0.0, 0.0);
            for (joint, entry) in self.gradient.iter_mut().enumerate() {
                *entry *= -place.moved[joint] / nominal.held_s;
                braking += *entry * nominal.command[joint];
                let ends = [nominal.limits.lower()[joint], nominal.limits.upper()[joint]].map(|end| *entry * end);
                (least, most) = (least + ends[0].min(ends[1]), most + ends[0].max(ends[1]));
            }
            bound += braking;
            if most <= bound || !(most - least > f64::MIN_POSITIVE) {
                continue;
            }
            found += 1;
            let level = if pair.obstacle_speed(scene.world) > 0.0 { MOVING } else { STANDING };
            let effect = nominal.held_s * (most - least) / (2.0 * reach);
            let asked = (bound.max(least) - braking) * (effect / EFFECTIVE).powi(2).min(1.0);
            let bound = if bound < braking { braking + asked } else { bound }.max(least);
            let row = Row { name: &pair.name, level, coefficients: &self.gradient, bound };
            let tightness = (most - row.bound) / (most - least);
            keep(&mut self.tightness, rows, &row, tightness);
        }
        found
    }
}

/// Writes a row into a free place, or into that of the row which matters least.
fn keep(tightness: &mut Vec<f64>, rows: &mut [Inequality], row: &Row, tight: f64) {
    let place = if tightness.len() < rows.len() {
        tightness.push(tight);
        tightness.len() - 1
    } else {
        let Some((place, least)) = tightness.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)) else { return };
        if *least >= tight {
            return;
        }
        tightness[place] = tight;
        place
    };
    rows[place].rename(row.name);
    rows[place].set_level(row.level);
    rows[place].overwrite(|coefficients| {
        coefficients.copy_from_slice(row.coefficients);
        row.bound
    });
}

/// Returns how far a velocity of 1 for a time `pulse` moves a joint until `since` its start behind a lag, s; all times in s.
fn pulse_response(since: f64, pulse: f64, lag: f64) -> f64 {
    let response = |time: f64| match time {
        _ if time <= 0.0 => 0.0,
        _ if lag > 0.0 => time - lag * (1.0 - (-time / lag).exp()),
        _ => time,
    };
    if since == f64::INFINITY { pulse } else { response(since) - response(since - pulse) }
}
