//! How near pairs of shapes come on the way of a stop.
//!
//! The way is sampled at nodes some milliseconds apart. Let d_a and d_b be the distances of a pair at two nodes, n_a the common normal at
//! the first one, and let y_b(n_a) be how far that direction separates the shapes at the second one, in the frame of the last link that
//! carries both. Between the nodes
//!
//! > d ≥ min(d_a, y_b(n_a)) − s − c,
//!
//! where s bounds how far a point strays because joints do not move uniformly, Σ_j ρ_j s_j, and c how far it leaves the chord of a
//! uniform motion of the joints (see [`Levers`](revprio_robot::collision::Levers)): n_a separates the shapes at both ends by so much, a linear function is between
//! its values on the chord, and a direction never separates by more than the distance. The same holds with n_b. A pair
//! whose distance exceeds d_min by more than it can move in the rest of the way needs no samples.

use revprio_robot::RobotModel;
use revprio_robot::collision::{CollisionModel, PlacedBody};
use revprio_robot::kinematics::Configuration;

use super::pair::{Pair, World};
use super::stop::StopPath;

/// Distance, m, by which full braking must come nearer than the pair is now to count as unavoidable. It is more than what the bounds
/// between samples lose for an arm that moves slowly.
pub const UNAVOIDABLE: f64 = 1e-4;

/// Distance that counts as rounding, m.
const ROUNDING: f64 = 1e-12;

/// One pair on its way.
#[derive(Debug, Clone, Copy)]
struct Watched {
    pair: usize,
    /// How far all shapes may move in all, m, until this pair must be looked at again.
    due: f64,
    /// Smallest bound so far, m.
    least: f64,
    /// Smallest distance at the nodes behind the first one, m.
    sampled: f64,
}

/// How much nearer than d_min a pair comes, m: negative, or 0 if it does not.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deficit {
    /// A bound for the whole way.
    pub bound: f64,
    /// At the nodes behind the first one.
    pub sampled: f64,
}

impl Deficit {
    /// Returns whether a pair keeps d_min, or, if it is nearer now, comes no nearer; `now`: its distance less d_min, m, at most 0.
    pub fn comes_no_nearer(&self, now: f64) -> bool {
        self.bound >= 0.0 || now < 0.0 && self.sampled >= now - ROUNDING && self.bound >= now - UNAVOIDABLE
    }
}

impl Watched {
    /// Returns how much nearer than d_min the pair has come; `min_distance`: d_min, m.
    fn deficit(&self, min_distance: f64) -> Deficit {
        let [bound, sampled] = [self.least, self.sampled].map(|least| (least - min_distance).min(0.0));
        Deficit { bound, sampled }
    }
}

/// The memory of the check.
#[derive(Debug)]
pub struct ClearanceCheck {
    configuration: Configuration,
    /// The bodies at two nodes.
    bodies: [PlacedBody; 2],
    /// The node of the first body.
    placed: usize,
    watched: Vec<Watched>,
    /// Of each joint, the largest lever of all pairs, n.
    levers: Vec<f64>,
    ways: Vec<f64>,
    strays: Vec<f64>,
}

/// What does not change during a check.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    pub robot: &'a RobotModel,
    pub model: &'a CollisionModel,
    pub pairs: &'a [Pair],
    pub world: World<'a>,
    /// d_min, m.
    pub min_distance: f64,
}

impl ClearanceCheck {
    /// Allocates the memory for some pairs.
    pub fn new(model: &CollisionModel, configuration: Configuration, pairs: &[Pair]) -> Self {
        let n = configuration.joint_position().len();
        let body = PlacedBody::new(model, &configuration);
        let largest = |joint: usize| pairs.iter().map(|pair| pair.levers.lever[joint]).fold(0.0, f64::max);
        Self {
            configuration,
            bodies: [body.clone(), body],
            placed: 0,
            watched: Vec::with_capacity(pairs.len()),
            levers: (0..n).map(largest).collect(),
            ways: vec![0.0; n],
            strays: vec![0.0; n],
        }
    }

    /// Overwrites the entry of each pair with how much nearer than d_min it comes on a path.
    ///
    /// `now`: the body at the start of the path; `distances`: the distance of each pair there, m.
    pub fn check(
        &mut self,
        scene: Scene,
        path: &StopPath,
        (now, distances): (&PlacedBody, &[f64]),
        deficits: &mut [Deficit],
    ) {
        deficits.fill(Deficit::default());
        self.walk(scene, (path, path.stride()), (now, distances), |_| false);
        for watched in &self.watched {
            deficits[watched.pair] = watched.deficit(scene.min_distance);
        }
    }

    /// Returns the end of the first interval in which a pair comes nearer than d_min and than it is now, s; `None`: none does. `stride`:
    /// number of periods of an interval.
    pub fn first_refused(
        &mut self,
        scene: Scene,
        (path, stride): (&StopPath, usize),
        (now, distances): (&PlacedBody, &[f64]),
    ) -> Option<f64> {
        let is_refused = |watched: &Watched| {
            let now = (distances[watched.pair] - scene.min_distance).min(0.0);
            !watched.deficit(scene.min_distance).comes_no_nearer(now)
        };
        let node = self.walk(scene, (path, stride), (now, distances), |watched| watched.iter().any(is_refused))?;
        Some(path.time(node))
    }

    /// Follows all pairs along a path, until `ends` says so for an interval; returns the node at the end of that interval.
    fn walk(
        &mut self,
        scene: Scene,
        (path, stride): (&StopPath, usize),
        (now, distances): (&PlacedBody, &[f64]),
        ends: impl Fn(&[Watched]) -> bool,
    ) -> Option<usize> {
        self.watch(scene, path, distances);
        self.bodies[0].copy_from(now);
        self.placed = 0;
        let speed = scene.world.largest_speed();
        let (mut node, end) = (0, path.nodes() - 1);
        let (mut travel, mut due) = (0.0, self.due());
        while node < end && due < f64::INFINITY {
            let next = if node < path.last_period() { (node + stride).min(path.last_period()) } else { node + 1 };
            path.write_ways((node, next), &mut self.ways);
            let way: f64 = self.levers.iter().zip(&self.ways).map(|(lever, way)| lever * way).sum();
            let after = travel + way + speed * (path.time(next) - path.time(node));
            if due <= after {
                self.look(scene, path, (node, next), (travel, after));
                if ends(&self.watched) {
                    return Some(next);
                }
                due = self.due();
            }
            (node, travel) = (next, after);
        }
        None
    }

    /// Lists the pairs that may come nearer than d_min.
    fn watch(&mut self, scene: Scene, path: &StopPath, distances: &[f64]) {
        self.watched.clear();
        let end = path.nodes() - 1;
        path.write_ways((0, end), &mut self.ways);
        let duration = path.time(end);
        for (index, (pair, &distance)) in scene.pairs.iter().zip(distances).enumerate() {
            let way = pair.levers.way(&self.ways) + duration * pair.obstacle_speed(scene.world);
            let due = distance - scene.min_distance;
            if due < way {
                self.watched.push(Watched { pair: index, due, least: distance, sampled: f64::INFINITY });
            }
        }
    }

    /// Returns how far all shapes may move in all until some pair must be looked at, m.
    fn due(&self) -> f64 {
        self.watched.iter().map(|watched| watched.due).fold(f64::INFINITY, f64::min)
    }

    /// Looks at the pairs that are due in an interval. `travel`: how far all shapes have moved before it and behind it, m.
    fn look(&mut self, scene: Scene, path: &StopPath, (from, to): (usize, usize), travel: (f64, f64)) {
        let Self { configuration, bodies: [before, after], placed, watched, ways, strays, .. } = self;
        let mut place = |node: usize, body: &mut PlacedBody| {
            // The positions of a path are finite: they are sums of finite ways.
            if configuration.update(scene.robot, path.position(node)).is_ok() {
                body.update(scene.model, configuration);
            }
        };
        if *placed != from {
            place(from, before);
        }
        place(to, after);
        path.write_strays((from, to), strays);
        let (start, end) = (path.time(from), path.time(to));
        for Watched { pair, due, least, sampled } in watched.iter_mut().filter(|watched| watched.due <= travel.1) {
            let pair = &scene.pairs[*pair];
            let at = pair.separation(before, scene.world, start);
            // Neither shape moves by more than this, so it is never nearer than by half of it.
            let way = pair.levers.way(ways) + (end - start) * pair.obstacle_speed(scene.world);
            if at.distance - way > scene.min_distance {
                *due = travel.0 + at.distance - scene.min_distance;
                continue;
            }
            let next = pair.separation(after, scene.world, end);
            let by_way = 0.5 * (at.distance + next.distance - way);
            if by_way < scene.min_distance {
                // While the lag settles, the joints slow down and an obstacle does not: they are not on their chords together.
                let settling = if from < path.last_period() { 0.0 } else { 0.5 * (end - start) };
                let apart = settling * pair.obstacle_speed(scene.world);
                let stray = pair.levers.way(strays) + pair.levers.bend(ways) + apart;
                let forward = pair.carried_normal(&at.normal, before, after);
                let backward = pair.carried_normal(&next.normal, after, before);
                let first = at.distance.min(pair.along(after, scene.world, end, &forward));
                let second = next.distance.min(pair.along(before, scene.world, start, &backward));
                *least = least.min(by_way.max(first.max(second) - stray));
            }
            *least = least.min(next.distance);
            *sampled = sampled.min(next.distance);
            *due = travel.1 + (next.distance - scene.min_distance).max(0.0);
        }
        std::mem::swap(before, after);
        *placed = to;
    }
}

#[cfg(test)]
mod tests;
