//! Which pairs of shapes must keep clear of each other.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::placed::PlacedBody;
use crate::kinematics::Configuration;
use crate::shape::{CollisionModel, LeftOutPair, PairReason, StatedPair, WatchedPair};
use crate::{DisabledPair, LinkId, RobotModel};

/// Number of postures in which a pair must touch to be left out.
const SAMPLES: usize = 2000;

/// Half of the range of a joint without limits in the sample, rad or m.
const UNLIMITED: f64 = std::f64::consts::PI;

/// Returns capsules without pairs with those pairs that are watched, and those that are left out.
pub(super) fn choose_pairs(
    robot: &RobotModel,
    model: CollisionModel,
    (stated, disabled): (&[StatedPair], &[DisabledPair]),
) -> CollisionModel {
    let disabled: HashMap<[&str; 2], &str> =
        disabled.iter().map(|pair| (sorted([&pair.links[0], &pair.links[1]]), pair.reason.as_str())).collect();
    let names = model.names();
    let of_text =
        |i: usize, j: usize| disabled.get(&sorted([&names[i], &names[j]])).map(|reason| stated_by_text(reason));
    // Many pairs share a name.
    let shared: Vec<Arc<str>> = names.iter().map(|name| Arc::from(name.as_str())).collect();
    let named = |i: usize, j: usize| [Arc::clone(&shared[i]), Arc::clone(&shared[j])];
    let stated: HashMap<[LinkId; 2], &str> =
        stated.iter().rev().map(|pair| (in_order(pair.links), pair.reason.as_str())).collect();
    let (mut pairs, mut left_out) = (Vec::new(), LeftOutPairs::default());
    let capsules = model.capsules();
    for (j, second) in capsules.iter().enumerate() {
        for (i, first) in capsules[..j].iter().enumerate() {
            let links = [first.link, second.link];
            if first.link == second.link {
                continue;
            }
            match of_text(i, j).or_else(|| reason(robot, &stated, links)) {
                Some(reason) => left_out.add(named(i, j), reason),
                None => pairs.push([i, j]),
            }
        }
    }
    let farthest = farthest(robot, &model, &pairs);
    for (pair, _) in pairs.iter().zip(&farthest).filter(|(_, farthest)| **farthest < 0.0) {
        left_out.add(named(pair[0], pair[1]), PairReason::AlwaysTouch);
    }
    let watched = pairs.iter().zip(&farthest).filter(|(_, farthest)| **farthest >= 0.0);
    let watched = watched.map(|(pair, farthest)| WatchedPair { capsules: *pair, farthest_m: *farthest }).collect();
    model.with_pairs(watched, left_out.pairs)
}

/// Returns two names in their order.
fn sorted([a, b]: [&str; 2]) -> [&str; 2] {
    if a <= b { [a, b] } else { [b, a] }
}

fn stated_by_text(reason: &str) -> PairReason {
    PairReason::Stated(if reason.is_empty() { "stated".to_owned() } else { reason.to_owned() })
}

/// Returns two links in their order.
fn in_order([a, b]: [LinkId; 2]) -> [LinkId; 2] {
    if a <= b { [a, b] } else { [b, a] }
}

/// Pairs that are left out, each once, in the order in which they came.
#[derive(Default)]
struct LeftOutPairs {
    pairs: Vec<LeftOutPair>,
    known: HashSet<LeftOutPair>,
}

impl LeftOutPairs {
    fn add(&mut self, links: [Arc<str>; 2], reason: PairReason) {
        let pair = LeftOutPair { links, reason };
        if self.known.insert(pair.clone()) {
            self.pairs.push(pair);
        }
    }
}

/// Returns why a pair of links is left out whatever the shapes are.
fn reason(robot: &RobotModel, stated: &HashMap<[LinkId; 2], &str>, links: [LinkId; 2]) -> Option<PairReason> {
    if let Some(reason) = stated.get(&in_order(links)) {
        return Some(PairReason::Stated((*reason).to_owned()));
    }
    let [first, second] = links.map(|link| robot.links()[link.index()].joint);
    let parent = |joint: Option<usize>| joint.map(|joint| robot.moving_joints()[joint].parent);
    let are_neighbours = first == second || parent(first) == Some(second) || parent(second) == Some(first);
    are_neighbours.then_some(PairReason::Neighbours)
}

/// Returns the largest distance of each pair in a fixed sample of postures, m; infinite if no posture of the sample is finite.
fn farthest(robot: &RobotModel, model: &CollisionModel, pairs: &[[usize; 2]]) -> Vec<f64> {
    let mut farthest = vec![f64::NEG_INFINITY; pairs.len()];
    let Ok(mut configuration) = Configuration::new(robot, &vec![0.0; robot.joint_count()]) else { return farthest };
    let mut placed = PlacedBody::new(model, &configuration);
    let mut position = vec![0.0; robot.joint_count()];
    for sample in 0..SAMPLES {
        for (coordinate, joint) in robot.joints().iter().enumerate() {
            let (lower, upper) = sampled_range(joint.limits.lower, joint.limits.upper);
            position[coordinate] = lower + (upper - lower) * spread(sample, coordinate);
        }
        if configuration.update(robot, &position).is_err() {
            continue;
        }
        placed.update(model, &configuration);
        for (farthest, &[i, j]) in farthest.iter_mut().zip(pairs) {
            let radii = model.capsules()[i].radius + model.capsules()[j].radius;
            *farthest = farthest.max(placed.core(i).to_segment(placed.core(j)).distance - radii);
        }
    }
    farthest.into_iter().map(|distance| if distance.is_finite() { distance } else { f64::INFINITY }).collect()
}

/// Returns the range of a joint in the sample, rad or m.
fn sampled_range(lower: f64, upper: f64) -> (f64, f64) {
    match (lower.is_finite(), upper.is_finite()) {
        (true, true) if (upper - lower).is_finite() => (lower, upper),
        (true, false) => (lower, lower + 2.0 * UNLIMITED),
        (false, true) => (upper - 2.0 * UNLIMITED, upper),
        _ => (-UNLIMITED, UNLIMITED),
    }
}

/// Returns a number of 0 … 1: entry `coordinate` of point `sample` of an additive recurrence, which fills the cube evenly.
fn spread(sample: usize, coordinate: usize) -> f64 {
    // Square roots of numbers without square factors are independent over the rationals; those of primes are among them.
    const PRIMES: [f64; 12] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0];
    let turn = PRIMES[coordinate % PRIMES.len()].sqrt() * (1.0 + (coordinate / PRIMES.len()) as f64 * 0.618);
    (0.5 + (sample as f64 + 1.0) * turn).fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sample_covers_the_range_of_each_joint() {
        let (inf, turn) = (f64::INFINITY, 2.0 * UNLIMITED);
        assert_eq!(sampled_range(4.0, 6.0), (4.0, 6.0));
        assert_eq!(sampled_range(4.0, inf), (4.0, 4.0 + turn));
        assert_eq!(sampled_range(-inf, 6.0), (6.0 - turn, 6.0));
        assert_eq!(sampled_range(-inf, inf), (-UNLIMITED, UNLIMITED));
        let numbers: Vec<f64> = (0..1000).map(|sample| spread(sample, 3)).collect();
        assert!(numbers.iter().any(|x| *x < 0.01) && numbers.iter().any(|x| *x > 0.99));
    }
}
