//! How near pairs of shapes come on the way of a stop.
//!
//! The way is sampled at nodes some milliseconds apart. Let d_a and d_b be the distances of a pair at two nodes, n_a the common normal at
//! the first one, and let y_b(n_a) be how far that direction separates the shapes at the second one, in the frame of the last link that
//! carries both. Between the nodes
//!
//! > d ≥ min(d_a, y_b(n_a)) − s − c,
//!
//! where s bounds how far a point strays because joints do not move uniformly, Σ_j ρ_j s_j, and c how far it leaves the chord of a
//! uniform motion of the joints (see [`Levers`](revprio_robot::collision::Levers)), and by how much an obstacle leaves its chord while
//! the lag settles, ½ Δt × its speed: n_a separates the shapes at both ends by so much, a linear function is between
//! its values on the chord, and a direction never separates by more than the distance. The same holds with n_b. A pair
//! whose distance exceeds d_min by more than it can move in the rest of the way needs no samples.
//!
//! The bound holds for any two nodes. So the check looks at nodes that are far apart first, and at those between them where the bound is
//! too rough to keep d_min.

use revprio_robot::RobotModel;
use revprio_robot::collision::{CollisionModel, PlacedBody, Separation};
use revprio_robot::kinematics::Configuration;

use super::pair::{Pair, World};
use super::stop::StopPath;

/// Distance, m, by which full braking must come nearer than the pair is now to count as unavoidable. It is more than what the bounds
/// between samples lose for an arm that moves slowly.
pub const UNAVOIDABLE: f64 = 1e-4;

/// Distance that counts as rounding, m.
const ROUNDING: f64 = 1e-12;

/// How many intervals are looked at as one first.
const COARSE: usize = 4;

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
    /// The last node at which the distance is known, and the distance there, m.
    seen: usize,
    distance: f64,
    /// The separation there; `None`: unknown.
    separation: Option<Separation>,
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
    fn see(&mut self, node: usize, separation: Separation) {
        (self.seen, self.distance, self.separation) = (node, separation.distance, Some(separation));
    }

    /// Returns whether the pair keeps d_min for a way (m) of its shapes behind the node where it was seen, and puts the next look off
    /// until what is left is used up; `after`: how far all shapes have moved behind that way, m.
    fn stays_clear(&mut self, scene: Scene, way: f64, after: f64) -> bool {
        let rest = self.distance - way - scene.min_distance;
        if rest > 0.0 {
            self.due = after + rest;
        }
        rest > 0.0
    }

    /// Returns how much nearer than d_min the pair has come; `min_distance`: d_min, m.
    fn deficit(&self, min_distance: f64) -> Deficit {
        let [bound, sampled] = [self.least, self.sampled].map(|least| (least - min_distance).min(0.0));
        Deficit { bound, sampled }
    }
}

/// A body and the node at which it is.
#[derive(Debug)]
struct Placed {
    node: usize,
    body: PlacedBody,
}

impl Placed {
    /// Moves the body to a node of a path, if it is elsewhere.
    fn go_to(&mut self, node: usize, scene: Scene, path: &StopPath, configuration: &mut Configuration) {
        // The positions of a path are finite: they are sums of finite ways.
        if self.node != node && configuration.update(scene.robot, path.position(node)).is_ok() {
            self.body.update(scene.model, configuration);
        }
        self.node = node;
    }
}

/// The memory of the check.
#[derive(Debug)]
pub struct ClearanceCheck {
    configuration: Configuration,
    /// The bodies at two nodes.
    bodies: [Placed; 2],
    watched: Vec<Watched>,
    /// The same before the interval.
    before: Vec<Watched>,
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
        let placed = || Placed { node: 0, body: PlacedBody::new(model, &configuration) };
        let bodies = [placed(), placed()];
        let largest = |joint: usize| pairs.iter().map(|pair| pair.levers.lever[joint]).fold(0.0, f64::max);
        Self {
            bodies,
            configuration,
            watched: Vec::with_capacity(pairs.len()),
            before: Vec::with_capacity(pairs.len()),
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
        let [first, second] = &mut self.bodies;
        first.body.copy_from(now);
        (first.node, second.node) = (0, usize::MAX);
        let speed = scene.world.largest_speed();
        let (mut node, mut fine_until, end) = (0, 0, path.nodes() - 1);
        let (mut travel, mut due) = (0.0, self.due());
        while node < end && due < f64::INFINITY {
            let is_coarse = node >= fine_until;
            let next = path.next_node(node, if is_coarse { COARSE * stride } else { stride });
            path.write_ways((node, next), &mut self.ways);
            let way: f64 = self.levers.iter().zip(&self.ways).map(|(lever, way)| lever * way).sum();
            let after = travel + way + speed * (path.time(next) - path.time(node));
            if due <= after {
                if is_coarse {
                    self.before.clone_from(&self.watched);
                }
                self.look(scene, path, (node, next), after);
                if is_coarse && next > node + stride && self.comes_nearer_than(scene.min_distance) {
                    self.watched.clone_from(&self.before);
                    fine_until = next;
                    continue;
                }
                if self.bodies[1].node == next {
                    self.bodies.swap(0, 1);
                }
                if ends(&self.watched) {
                    return Some(next);
                }
                due = self.due();
            }
            (node, travel) = (next, after);
        }
        None
    }

    /// Returns whether the bound of a pair has become smaller in an interval, and is smaller than d_min (m).
    fn comes_nearer_than(&self, min_distance: f64) -> bool {
        self.watched.iter().zip(&self.before).any(|(after, before)| after.least < before.least.min(min_distance))
    }

    /// Lists the pairs that may come nearer than d_min.
    fn watch(&mut self, scene: Scene, path: &StopPath, distances: &[f64]) {
        self.watched.clear();
        let end = path.nodes() - 1;
        path.write_ways((0, end), &mut self.ways);
        let duration = path.time(end);
        for (index, (pair, &distance)) in scene.pairs.iter().zip(distances).enumerate() {
            let way = pair.way(&self.ways, duration, scene.world);
            let due = distance - scene.min_distance;
            if due < way {
                let (least, sampled) = (distance, f64::INFINITY);
                self.watched.push(Watched { pair: index, due, least, sampled, seen: 0, distance, separation: None });
            }
        }
    }

    /// Returns how far all shapes may move in all until some pair must be looked at, m.
    fn due(&self) -> f64 {
        self.watched.iter().map(|watched| watched.due).fold(f64::INFINITY, f64::min)
    }

    /// Looks at the pairs that are due in an interval. `after`: how far all shapes have moved behind it, m.
    fn look(&mut self, scene: Scene, path: &StopPath, (from, to): (usize, usize), after: f64) {
        let Self { configuration, bodies: [start, end], watched, ways, strays, .. } = self;
        path.write_strays((from, to), strays);
        let times = [path.time(from), path.time(to)];
        for watched in watched.iter_mut().filter(|watched| watched.due <= after) {
            let pair = &scene.pairs[watched.pair];
            if watched.seen < from {
                path.write_ways((watched.seen, to), ways);
                if watched.stays_clear(scene, pair.way(ways, times[1] - path.time(watched.seen), scene.world), after) {
                    continue;
                }
            }
            path.write_ways((from, to), ways);
            let at = watched.separation.filter(|_| watched.seen == from).unwrap_or_else(|| {
                start.go_to(from, scene, path, configuration);
                pair.separation(&start.body, scene.world, times[0])
            });
            watched.see(from, at);
            // Neither shape moves by more than this, so it is never nearer than by half of it.
            let way = pair.way(ways, times[1] - times[0], scene.world);
            if watched.stays_clear(scene, way, after) {
                continue;
            }
            end.go_to(to, scene, path, configuration);
            let next = pair.separation(&end.body, scene.world, times[1]);
            let by_way = 0.5 * (at.distance + next.distance - way);
            if by_way < scene.min_distance {
                start.go_to(from, scene, path, configuration);
                // While the lag settles, the joints slow down and an obstacle does not: they are not on their chords together.
                let settling = if from < path.last_period() { 0.0 } else { 0.5 * (times[1] - times[0]) };
                let apart = settling * pair.obstacle_speed(scene.world);
                let stray = pair.levers.way(strays) + pair.levers.bend(ways) + apart;
                let forward = pair.carried_normal(&at.normal, &start.body, &end.body);
                let backward = pair.carried_normal(&next.normal, &end.body, &start.body);
                let first = at.distance.min(pair.along(&end.body, scene.world, times[1], &forward));
                let second = next.distance.min(pair.along(&start.body, scene.world, times[0], &backward));
                watched.least = watched.least.min(by_way.max(first.max(second) - stray));
            }
            watched.least = watched.least.min(next.distance);
            watched.sampled = watched.sampled.min(next.distance);
            watched.due = after + (next.distance - scene.min_distance).max(0.0);
            watched.see(to, next);
        }
    }
}

#[cfg(test)]
mod tests;
