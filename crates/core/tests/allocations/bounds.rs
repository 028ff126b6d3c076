//! Limits, planes, inequalities and tasks with bounds, each of them active.

use std::sync::Arc;

use nalgebra::Vector3;
use revprio_core::collision::{CollisionAvoidance, Obstacle, ObstacleShape, ObstacleState};
use revprio_core::constraint::{Constraint, Inequality, PlanePoint, VirtualPlane};
use revprio_core::controller::{Command, ControllerConfig, Limits};
use revprio_core::limits::{Drive, LimitKind, VelocityBox};
use revprio_core::resolution::Method;
use revprio_robot::collision::{LinkCapsule, Segment};
use revprio_robot::kinematics::Configuration;

use crate::arm::{
    Arm, NOMINAL, assert_allocates_nothing, config, push_and_hold, push_upwards, sawyer, slow_upwards, with_jerk,
};
use crate::methods::METHODS;

/// Returns a ceiling above a point of the arm in its first posture; `distance`: m.
pub fn ceiling(point: PlanePoint, distance: f64) -> Constraint {
    let configuration = Configuration::new(&sawyer(), &NOMINAL).unwrap();
    let height = point.position(&configuration).z;
    Constraint::Plane(VirtualPlane::new("ceiling", [0.0, 0.0, 1.0], height + distance, point, 10.0).unwrap())
}

pub fn is_at_constraint(command: &Command) -> bool {
    command.resolution.active_constraints().next().is_some()
}

/// Returns a bound of the speed upwards of the first posture.
fn slow_sum_of_joints() -> Constraint {
    let configuration = Configuration::new(&sawyer(), &NOMINAL).unwrap();
    let upwards = configuration.jacobian().row(2).iter().copied().collect();
    Constraint::Fixed(Inequality::new("sum", upwards, 0.01).unwrap())
}

#[test]
fn planes_and_inequalities_allocate_nothing_with_every_method() {
    for method in METHODS {
        for constraint in [ceiling(PlanePoint::Tool, 0.02), slow_sum_of_joints()] {
            let config = push_upwards(Limits::Robot(LimitKind::PositionVelocity));
            let what = format!("{method:?}, {constraint:?}");
            let config = ControllerConfig { method, constraints: vec![constraint], ..config };
            assert_allocates_nothing(&what, config, 200, is_at_constraint);
        }
    }
}

#[test]
fn a_plane_for_a_joint_allocates_nothing() {
    let config = push_upwards(Limits::Robot(LimitKind::PositionVelocity));
    let config = ControllerConfig { constraints: vec![ceiling(PlanePoint::Joint(3), -0.01)], ..config };
    assert_allocates_nothing("elbow", config, 200, is_at_constraint);
}

#[test]
fn a_plane_behind_an_ideal_and_a_slow_drive_allocates_nothing() {
    for drive in [Drive::IDEAL, Drive::CONSERVATIVE] {
        let config = push_upwards(Limits::Robot(LimitKind::PositionVelocityAcceleration));
        let config = ControllerConfig { drive, constraints: vec![ceiling(PlanePoint::Tool, 0.02)], ..config };
        assert_allocates_nothing(&format!("{drive:?}"), config, 200, is_at_constraint);
    }
}

/// A ball at the tool below a ceiling, with an obstacle that moves.
#[test]
fn distances_allocate_nothing() {
    let bare = sawyer();
    let tool = Configuration::new(&bare, &NOMINAL).unwrap().tool_pose().translation.vector;
    let core = Segment::point(bare.tool().translation.vector);
    let capsule = LinkCapsule { link: bare.tips()[0].link, core, radius: 0.05 };
    let robot = Arc::new(bare.as_ref().clone().with_capsules(vec![capsule], &[]).unwrap());
    let above = ObstacleShape::HalfSpace { normal: -Vector3::z(), offset: -(tool.z + 0.08) };
    let side = tool + Vector3::new(0.0, 0.3, 0.0);
    let ball = ObstacleShape::Capsule { core: Segment::point(side), radius: 0.05 };
    let obstacles = vec![Obstacle::new("ceiling", above, false).unwrap(), Obstacle::new("ball", ball, true).unwrap()];
    let avoidance = CollisionAvoidance { obstacles, ..CollisionAvoidance::default() };
    for drive in [Drive::IDEAL, Drive::CONSERVATIVE] {
        let config = push_upwards(Limits::Robot(LimitKind::PositionVelocityAcceleration));
        let constraints = vec![Constraint::Distances(avoidance.clone())];
        let mut arm = Arm::new(ControllerConfig { robot: Arc::clone(&robot), drive, constraints, ..config });
        arm.measured.obstacles =
            vec![ObstacleState { name: "ball".into(), position: side, velocity: Vector3::zeros() }];
        arm.warm_up();
        let counts = arm.run(2000, is_at_constraint);
        assert!(counts.seen >= 200, "{drive:?}: {counts:?}");
        assert_eq!((counts.allocations, counts.qp), (0, 0), "{drive:?}: {counts:?}");
    }
}

/// The wall is named in some periods and not in others.
#[test]
fn a_plane_that_the_arm_leaves_and_reaches_again_allocates_nothing() {
    let x = Configuration::new(&sawyer(), &NOMINAL).unwrap().tool_pose().translation.x;
    let wall = VirtualPlane::new("wall", [1.0, 0.0, 0.0], x + 0.002, PlanePoint::Tool, 10.0).unwrap();
    let config = config(Limits::Robot(LimitKind::Velocity), push_and_hold());
    let mut arm = Arm::new(ControllerConfig { constraints: vec![Constraint::Plane(wall)], ..config });
    arm.warm_up();
    let counts = arm.run(2000, is_at_constraint);
    assert!((20..1900).contains(&counts.seen), "{counts:?}");
    assert_eq!(counts.allocations, 0, "{counts:?}");
}

/// Where all tasks are one level, bounds are no bounds but wishes, and may contradict the other tasks: see `exceptions.rs`.
#[test]
fn inequality_tasks_allocate_nothing_with_every_method_of_levels() {
    for method in METHODS {
        if matches!(method, Method::DampedLeastSquares | Method::Pseudoinverse) {
            continue;
        }
        let config = ControllerConfig { method, ..slow_upwards() };
        assert_allocates_nothing(&format!("{method:?}"), config, 200, |command| {
            command.resolution.active_rows(0).next().is_some()
        });
    }
}

#[test]
fn limits_of_every_kind_allocate_nothing_with_and_without_a_drive() {
    for kind in
        [LimitKind::None, LimitKind::Velocity, LimitKind::PositionVelocity, LimitKind::PositionVelocityAcceleration]
    {
        for drive in [Drive::IDEAL, Drive::CONSERVATIVE] {
            let config = ControllerConfig { drive, ..config(Limits::Robot(kind), push_and_hold()) };
            assert_allocates_nothing(&format!("{kind:?} {drive:?}"), config, 2000, |_| true);
        }
    }
    let slow = VelocityBox::new(&[-0.1; 7], &[0.1; 7]).unwrap();
    assert_allocates_nothing("box", config(Limits::Fixed(slow), push_and_hold()), 200, |command| {
        command.resolution.active_limits().next().is_some()
    });
}

/// Periods are solved once or twice.
#[test]
fn jerk_limits_allocate_nothing() {
    let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
    let config = ControllerConfig { robot: with_jerk(), ..config(limits, push_and_hold()) };
    assert_allocates_nothing("jerk", config, 200, |command| command.resolution.active_limits().next().is_some());
}
