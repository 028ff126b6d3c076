//! Limits, holds and virtual walls compared with the formulas of `docs/limits.md`, computed here in another way.

use nalgebra::Vector3;
use proptest::prelude::*;
use revprio_core::constraint::{Ahead, Constraint, Inequality, JointBraking, PlanePoint, VirtualPlane};
use revprio_core::limits::{Drive, Hold, JointMotion, LimitKind, braking_deceleration, reaction_time, robot_box};
use revprio_core::linalg::Vector;
use revprio_robot::kinematics::{Configuration, LinkPoint};
use revprio_robot::{JointLimits, RobotModel};

const PERIOD: f64 = 0.004;
const ERROR: f64 = 1e-9;

fn sawyer() -> &'static RobotModel {
    revprio_robot::built_in().iter().find(|robot| robot.name() == "sawyer_dh").unwrap()
}

fn middle(robot: &RobotModel) -> Vec<f64> {
    robot.joints().iter().map(|joint| f64::midpoint(joint.limits.lower, joint.limits.upper)).collect()
}

/// Returns the largest v ≤ V with v τ + v²/2a ≤ d, by bisection; d ≥ 0.
fn stopping_speed(limits: &JointLimits, distance: f64) -> f64 {
    speed_after(limits, reaction_time(PERIOD), distance)
}

/// Returns the largest v ≤ V of which the commands v, v − a T, … end within d; they move a joint by v T/2 + v²/2a.
fn full_braking_speed(limits: &JointLimits, distance: f64) -> f64 {
    speed_after(limits, 0.5 * PERIOD, distance.max(0.0))
}

fn speed_after(limits: &JointLimits, reaction: f64, distance: f64) -> f64 {
    let a = braking_deceleration(limits);
    let (mut slow, mut fast) = (0.0, limits.velocity);
    for _ in 0..100 {
        let v = f64::midpoint(slow, fast);
        if v * reaction + v * v / (2.0 * a) <= distance { slow = v } else { fast = v }
    }
    slow
}

/// The velocities allowed towards both limits: away from the nearer one where the joint is beyond it, as far as a `change`
/// of the last command allows it.
fn range(limits: &JointLimits, (below, above): (f64, f64), last: f64, change: f64) -> (f64, f64) {
    let towards = |distance: f64, last: f64| match distance {
        _ if distance >= 0.0 => stopping_speed(limits, distance),
        _ => -stopping_speed(limits, -distance).min((change - last).max(0.0)),
    };
    let (lower, upper) = (-towards(below, -last), towards(above, last));
    match (below < 0.0, above < 0.0) {
        (_, true) => (lower, upper.max(lower)),
        (true, _) => (lower.min(upper), upper),
        _ => (lower, upper),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Inside the range, and beyond it as the joint is or as it comes to rest, even beyond the other limit.
    #[test]
    fn the_box_is_that_of_the_documentation(
        place in -0.02..1.02_f64, to_rest in -1.0..1.0_f64, farthest in prop::sample::select(vec![0.0, 0.1, 10.0]),
        last in -1.0..1.0_f64,
    ) {
        let robot = sawyer();
        let limits = &robot.joints()[1].limits;
        let mut position = middle(robot);
        position[1] = limits.lower + place * (limits.upper - limits.lower);
        let to_rest = farthest * to_rest;
        let (mut distance_to_rest, mut last_command) = (vec![0.0; 7], vec![0.0; 7]);
        (distance_to_rest[1], last_command[1]) = (to_rest, last * limits.velocity);
        let last = last_command[1];
        let motion = JointMotion { position: &position, distance_to_rest: &distance_to_rest, last_command: &last_command, last_acceleration: &[] };
        let limited = robot_box(robot, LimitKind::PositionVelocityAcceleration, motion, PERIOD);
        let now = (position[1] - limits.lower, limits.upper - position[1]);
        let at_rest = (now.0 + to_rest.min(0.0), now.1 - to_rest.max(0.0));
        let change = limits.acceleration * PERIOD;
        let (resting, at_once) = (range(limits, at_rest, last, change), range(limits, now, last, change));
        // 0.5 mrad of noise, or of what lost states took.
        let bound = |distance: f64, last: f64| -range(limits, (distance + 5e-4, f64::INFINITY), last, change).0;
        let brakes_fully = |braked: f64, distance: f64| {
            braked <= bound(distance, -braked - change).max(full_braking_speed(limits, distance + 5e-4))
        };
        let lower = resting.0.min(if brakes_fully(-last - change, at_rest.0) { last + change } else { (last + change).max(at_once.0) });
        let upper = resting.1.max(if brakes_fully(last - change, at_rest.1) { last - change } else { (last - change).min(at_once.1) });
        let expected = ((last - change).clamp(lower, upper), (last + change).clamp(lower, upper));
        let found = (limited.velocity_box.lower()[1], limited.velocity_box.upper()[1]);
        prop_assert!((found.0 - expected.0).abs() < ERROR && (found.1 - expected.1).abs() < ERROR, "{found:?} {expected:?}");
        let contradiction = (last - change - upper).max(lower - last - change);
        if contradiction.abs() > 1e-6 {
            prop_assert_eq!(limited.conflicts.contains(&1), contradiction > 0.0);
        }
        let limited = robot_box(robot, LimitKind::PositionVelocity, motion, PERIOD);
        let expected = range(limits, at_rest, last, f64::INFINITY);
        let found = (limited.velocity_box.lower()[1], limited.velocity_box.upper()[1]);
        prop_assert!((found.0 - expected.0).abs() < ERROR && (found.1 - expected.1).abs() < ERROR, "{found:?} {expected:?}");
    }

    #[test]
    fn a_command_can_be_held_until_braking_must_start(
        place in 0.0..1.0_f64, to_rest in -0.1..0.1_f64, command in -1.0..1.0_f64, last in -1.0..1.0_f64,
    ) {
        let robot = sawyer();
        let limits = &robot.joints()[1].limits;
        let mut position = middle(robot);
        position[1] = limits.lower + place * (limits.upper - limits.lower);
        let (mut distance_to_rest, mut last_command, mut commands) = (vec![0.0; 7], vec![0.0; 7], vec![0.0; 7]);
        (distance_to_rest[1], last_command[1], commands[1]) = (to_rest, last * limits.velocity, command * limits.velocity);
        let motion = JointMotion { position: &position, distance_to_rest: &distance_to_rest, last_command: &last_command, last_acceleration: &[] };
        let mut hold = Hold::default();
        hold.update(robot, LimitKind::PositionVelocity, motion, &[0.0; 7], &commands, PERIOD);
        let (v, towards) = (commands[1].abs(), commands[1].signum());
        let limit = if towards > 0.0 { limits.upper } else { limits.lower };
        let distance = towards * (limit - position[1]) - (towards * to_rest).max(0.0);
        let braking = v * v / (2.0 * braking_deceleration(limits));
        let late = (towards * last_command[1] - v).max(0.0) * (reaction_time(PERIOD) - PERIOD);
        let noise = 5e-4;
        let [exact, forgiving] = [0.0, noise].map(|noise| (distance + noise - late - braking) / v);
        let time = exact.max(forgiving.min(reaction_time(PERIOD) - PERIOD)).max(0.0);
        // 1 µm of tolerance for measured positions.
        prop_assert!(v == 0.0 || (hold.time_s - time).abs() < 1e-6 / v + 1e-9, "{} {time}", hold.time_s);
        if (braking - distance - noise).abs() > 1e-6 {
            prop_assert_eq!(hold.too_fast.contains(&1), braking > distance + noise);
        }
    }

    /// n·ẋ ≤ min(γ D, s(D)) − max(0, (g(m) − g)·q̇⁻), where D is the smaller distance of those now and at rest.
    #[test]
    fn a_wall_holds_back_its_point_at_rest(
        joints in prop::array::uniform7(-1.0..1.0_f64),
        to_rest in prop::array::uniform7(-0.1..0.1_f64),
        last_command in prop::array::uniform7(-1.0..1.0_f64),
        place in 0..3_usize,
    ) {
        let robot = sawyer();
        let q: Vec<f64> = middle(robot).iter().zip(joints).map(|(middle, change)| middle + change).collect();
        let configuration = Configuration::new(robot, &q).unwrap();
        let hand = LinkPoint::new(robot.link("j6").unwrap(), Vector3::new(0.1, -0.05, 0.2));
        let point = [PlanePoint::Tool, PlanePoint::Joint(4), PlanePoint::Link(hand)][place];
        let wall = VirtualPlane::new("wall", [3.0, 0.0, 4.0], 0.7, point, 8.0).unwrap();
        let at = |configuration: &Configuration| point.position(configuration);
        let height = |configuration: &Configuration| 0.6 * at(configuration).x + 0.8 * at(configuration).z;
        let deceleration = [4.0, 3.0, f64::INFINITY, 5.0, 6.0, 7.0, 8.0];
        let braking = JointBraking { deceleration: &deceleration, reaction_s: 0.02 };
        let half_way: Vec<f64> = last_command.iter().map(|speed| 0.5 * PERIOD * speed).collect();
        let moved = |by: &[f64]| Configuration::new(robot, &q.iter().zip(by).map(|(q, by)| q + by).collect::<Vec<_>>()).unwrap();
        let to_middle: Vec<f64> = to_rest.iter().zip(&half_way).map(|(rest, half)| rest + half).collect();
        let (rest, middle) = (moved(&to_rest), moved(&to_middle));
        let ahead = Ahead { rest: &rest, half_way: &middle, last_command: &last_command };
        let inequality = wall.at(&configuration, Some(ahead), Some(braking));
        let step = 1e-6;
        let gradient_at = |q: &[f64]| Vector::from_iterator(7, (0..7).map(|joint| {
            let moved = |by: f64| {
                let mut q = q.to_vec();
                q[joint] += by;
                height(&Configuration::new(robot, &q).unwrap())
            };
            (moved(step) - moved(-step)) / (2.0 * step)
        }));
        let gradient = gradient_at(rest.joint_position());
        prop_assert!((inequality.coefficients() - &gradient).amax() < 1e-8);
        let turning = (gradient_at(middle.joint_position()) - &gradient).dot(&Vector::from_row_slice(&last_command)).max(0.0);
        let distance = 0.7 - height(&configuration).max(height(&rest));
        let bare = wall.at(&configuration, Some(ahead), None).bound() + turning;
        prop_assert!((bare - 8.0 * distance).abs() < 1e-6, "{bare} {distance}");
        let now = wall.at(&configuration, None, None).bound();
        prop_assert!((now - 8.0 * (0.7 - height(&configuration))).abs() < 1e-12, "{now}");
        let (by_rate, distance) = (bare, bare / 8.0);
        // Half of what the shortest change of the joint velocities gives.
        let reach = gradient.iter().zip(deceleration).map(|(slope, a)| a / slope.abs()).fold(f64::INFINITY, f64::min);
        let deceleration = 0.5 * gradient.norm_squared() * reach;
        let speed = (inequality.bound() + turning).abs();
        let stop = speed * 0.02 + speed * speed / (2.0 * deceleration);
        prop_assert!(speed <= by_rate.abs() + 1e-12 && (inequality.bound() + turning) * distance >= -1e-12);
        prop_assert!((speed - by_rate.abs()).abs() < 1e-9 || (stop / distance.abs() - 1.0).abs() < 1e-6, "{speed}");
        prop_assert_eq!(inequality.name(), "wall");
    }
}

#[test]
fn a_joint_that_a_wall_cannot_be_reached_with_gives_an_inequality_that_always_holds() {
    let robot = sawyer();
    let configuration = Configuration::new(robot, &middle(robot)).unwrap();
    let wall = VirtualPlane::new("wall", [0.0, 0.0, 1.0], 0.0, PlanePoint::Joint(0), 8.0).unwrap();
    let inequality = wall.at(&configuration, None, None);
    assert_eq!((inequality.coefficients().amax(), inequality.bound()), (0.0, f64::INFINITY));
}

#[test]
fn a_constraint_says_what_it_is() {
    let fixed = Constraint::Fixed(Inequality::new("sum", vec![1.0; 7], 0.5).unwrap());
    let plane = |point| Constraint::Plane(VirtualPlane::new("wall", [0.0, 0.0, 1.0], 0.3, point, 8.0).unwrap());
    assert_eq!((fixed.name(), plane(PlanePoint::Tool).name()), ("sum", "wall"));
    assert_eq!([fixed.depends_on_posture(), plane(PlanePoint::Tool).depends_on_posture()], [false, true]);
    assert_eq!((fixed.row_count(), plane(PlanePoint::Tool).row_count()), (1, 1));
    let configuration = Configuration::new(sawyer(), &middle(sawyer())).unwrap();
    let rows = |constraint: &Constraint, configuration| constraint.rows_at(configuration).len();
    assert_eq!((rows(&fixed, None), rows(&plane(PlanePoint::Tool), None)), (1, 0));
    assert_eq!((rows(&fixed, Some(&configuration)), rows(&plane(PlanePoint::Tool), Some(&configuration))), (1, 1));
    let planar = revprio_robot::built_in().iter().find(|robot| robot.name() == "planar_3r").unwrap();
    assert_eq!((fixed.fits(sawyer()), fixed.fits(planar)), (true, false));
    let fits = |point, robot| plane(point).fits(robot);
    let link = |name: &str| PlanePoint::Link(LinkPoint::origin(sawyer().link(name).unwrap()));
    assert_eq!([6, 7].map(|joint| fits(PlanePoint::Joint(joint), sawyer())), [true, false]);
    assert_eq!([link("j1"), link("j6")].map(|point| fits(point, planar)), [true, false]);
    assert!(fits(PlanePoint::Tool, planar));
    let Constraint::Plane(wall) = plane(PlanePoint::Joint(3)) else { unreachable!("a plane") };
    assert_eq!((wall.point(), wall.rate()), (PlanePoint::Joint(3), 8.0));
}

#[test]
fn a_kind_names_its_limits_and_a_drive_its_time_to_rest() {
    let includes = |kind: LimitKind| [kind.includes_velocity(), kind.includes_position(), kind.includes_acceleration()];
    assert_eq!(includes(LimitKind::None), [false; 3]);
    assert_eq!(includes(LimitKind::Velocity), [true, false, false]);
    assert_eq!(includes(LimitKind::PositionVelocity), [true, true, false]);
    assert_eq!(includes(LimitKind::PositionVelocityAcceleration), [true; 3]);
    assert!((Drive { lag_s: 0.03, delay_periods: 2 }.time_to_rest(0.004) - 0.038).abs() < 1e-15);
    assert_eq!(Drive::IDEAL.time_to_rest(0.004), 0.0);
}
