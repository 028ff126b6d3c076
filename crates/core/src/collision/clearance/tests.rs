use std::sync::Arc;

use nalgebra::Vector3;
use proptest::prelude::*;
use revprio_robot::built_in;
use revprio_robot::collision::Segment;

use super::*;
use crate::collision::avoidance::CollisionAvoidance;
use crate::collision::obstacle::{Obstacle, ObstacleShape};
use crate::collision::pair::{Other, pairs};
use crate::collision::stop::{Braking, Start, longest_stop};
use crate::limits::{Drive, DriveState};
use crate::linalg::Vector;

/// Parts of a period at which the true distance is looked at.
const PARTS: usize = 8;

/// Depth, m, from which on two shapes may lose more: their normal turns fast where their cores cross.
const DEEP: f64 = 0.05;

/// Number of periods in which a lag settles.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive and small")]
fn settling(lag: f64, period: f64) -> usize {
    (8.0 * lag / period).ceil() as usize
}

/// Returns the positions of the joints at parts of the periods of a stop behind its drive, n each, until they rest.
fn fine_way(start: Start, commands: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let (mut q, mut v) = (start.position.to_vec(), start.drive_state.velocity.clone());
    let (lag, period) = (start.drive.lag_s, start.period);
    let pending = start.drive_state.pending.iter().map(|u| u.as_slice().to_vec());
    let rest = std::iter::repeat_n(vec![0.0; q.len()], settling(lag, period));
    let mut way = vec![q.clone()];
    for acting in pending.chain(commands.iter().cloned()).chain(rest) {
        for part in 1..=PARTS {
            let time = period * part as f64 / PARTS as f64;
            let remaining = if lag > 0.0 { (-time / lag).exp() } else { 0.0 };
            let at =
                |joint: usize| q[joint] + time * acting[joint] + (v[joint] - acting[joint]) * lag * (1.0 - remaining);
            way.push((0..q.len()).map(at).collect());
        }
        let remaining = if lag > 0.0 { (-period / lag).exp() } else { 0.0 };
        q.clone_from(way.last().unwrap());
        for (v, u) in v.iter_mut().zip(&acting) {
            *v = u + (*v - u) * remaining;
        }
    }
    way
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// The bound is below the distance at every time; for an arm that moved uniformly and shapes that are not deep inside each other, no
    /// more than a millimetre below it.
    #[test]
    fn the_bound_holds_at_all_times(
        posture in prop::collection::vec(0.0..1.0_f64, 7),
        speeds in prop::collection::vec(-1.0..1.0_f64, 28),
        lag in prop_oneof![Just(0.0), 1e-3..0.05_f64],
        delay in 0_usize..4,
        period in prop_oneof![Just(0.001), Just(0.004), Just(0.008)],
        uniform in any::<bool>(),
        ball in prop::array::uniform3(-0.8..0.8_f64),
        ball_velocity in prop::array::uniform3(-0.3..0.3_f64),
    ) {
        let robot = built_in().iter().find(|robot| robot.name() == "panda").unwrap();
        let model: &Arc<_> = robot.collision().unwrap();
        let shape = ObstacleShape::Capsule { core: Segment::point(Vector3::from(ball)), radius: 0.1 };
        let avoidance = CollisionAvoidance {
            min_distance_m: 0.05,
            obstacles: vec![Obstacle::new("ball", shape, true).unwrap()],
            ..CollisionAvoidance::default()
        };
        let pairs = pairs(robot, model, &avoidance);
        let (shifts, velocities) = (vec![Vector3::zeros()], vec![Vector3::from(ball_velocity)]);
        let world = World { obstacles: &avoidance.obstacles, shifts: &shifts, velocities: &velocities };
        let scene = Scene { robot, model, pairs: &pairs, world, min_distance: avoidance.min_distance_m };

        let speed = |block: usize| -> Vec<f64> {
            robot.joints().iter().enumerate().map(|(j, joint)| joint.limits.velocity * speeds[7 * block + j]).collect()
        };
        let limits = robot.joints().iter().map(|joint| joint.limits);
        let position: Vec<f64> = limits.zip(&posture).map(|(l, x)| l.lower + (l.upper - l.lower) * x).collect();
        let drive_state = DriveState {
            velocity: Vector::from_vec(speed(if uniform { 3 } else { 0 })),
            pending: (0..delay).map(|k| Vector::from_vec(speed(if uniform { 3 } else { 1 + k % 2 }))).collect(),
        };
        let start = Start { position: &position, drive_state: &drive_state, drive: Drive { lag_s: lag, delay_periods: delay }, period };
        let command = speed(3);
        let mut path = StopPath::new(7, 2 * longest_stop(robot, period), period);
        path.follow(start, Braking { robot, command: &command, held: 1, acceleration: None });

        let configuration = Configuration::new(robot, &position).unwrap();
        let now = PlacedBody::new(model, &configuration);
        let distances: Vec<f64> = pairs.iter().map(|pair| pair.separation(&now, world, 0.0).distance).collect();
        let mut check = ClearanceCheck::new(model, configuration, &pairs);
        let mut deficits = vec![Deficit::default(); pairs.len()];
        check.check(scene, &path, (&now, &distances), &mut deficits);

        let mut least = vec![0.0_f64; pairs.len()];
        for (k, q) in fine_way(start, &path.sent_commands()).iter().enumerate() {
            let body = PlacedBody::new(model, &Configuration::new(robot, q).unwrap());
            let time = period * k as f64 / PARTS as f64;
            let is_watched = |pair: &Pair| matches!(pair.other, Other::Capsule(_)) || time <= path.time(path.nodes() - 1);
            for (pair, least) in pairs.iter().zip(&mut least).filter(|(pair, _)| is_watched(pair)) {
                *least = least.min(pair.separation(&body, world, time).distance - scene.min_distance);
            }
        }
        for ((pair, deficit), least) in pairs.iter().zip(&deficits).zip(least) {
            prop_assert!(deficit.bound <= least + 1e-9, "{}: {deficit:?}, but {least} m", pair.name);
            let settling = pair.obstacle_speed(world) * 2.0 * lag;
            let lost = least - deficit.bound;
            let allowed = 1e-3 * (period / 0.004).max(1.0).powi(2) + settling;
            let is_deep = least < -DEEP - scene.min_distance;
            prop_assert!(!uniform || is_deep || lost < allowed, "{}: {lost} m lost", pair.name);
        }
    }
}
