//! Surfaces along which a joint turns: it can neither approach nor leave them.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Rotation3, Translation3, Vector3};
use revprio_core::collision::{CollisionAvoidance, Obstacle, ObstacleShape};
use revprio_core::constraint::Constraint;
use revprio_core::controller::{Controller, ControllerConfig, Stepper};
use revprio_robot::collision::{LinkCapsule, Segment};
use revprio_robot::{Joint, RobotModel};

use super::super::arms::Random;
use super::super::drives::LaggingArm;
use super::{CAPSULES, HOME, NEAREST, SLOW, Setup, config, nearest, panda};

/// Returns a Panda on a mount with this rotation.
fn mounted(rotation: &Rotation3<f64>) -> Arc<RobotModel> {
    let panda = panda(false);
    let mut joints: Vec<Joint> = panda.joints().to_vec();
    joints[0].placement = IsometryMatrix3::from_parts(Translation3::identity(), *rotation) * joints[0].placement;
    let robot = RobotModel::new("panda", "", joints, *panda.tool()).unwrap();
    let capsules = CAPSULES[1..].iter().map(|&(place, from, to, radius)| LinkCapsule {
        link: robot.link(&robot.links()[place].name).unwrap(),
        core: Segment { from: from.into(), to: to.into() },
        radius,
    });
    let capsules: Vec<LinkCapsule> = capsules.collect();
    Arc::new(robot.clone().with_capsules(capsules, &[]).unwrap())
}

/// A table below the first link, parallel to the mount up to rounding or up to what a user rounds: no joint races along it.
#[test]
fn a_surface_along_which_a_joint_turns_moves_no_joint() {
    let mut random = Random(7);
    for (run, tilt) in [0.0, 0.0, 0.0, 0.0, 1e-7, 1e-5].into_iter().enumerate() {
        let angles = [0; 3].map(|_| 3.0 * random.signed());
        let rotation = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let robot = mounted(&rotation);
        let normal = rotation * Vector3::new(tilt, 0.0, 1.0).normalize();
        let plate =
            |offset: f64| vec![Obstacle::new("plate", ObstacleShape::HalfSpace { normal, offset }, false).unwrap()];
        let distance = nearest(&robot, &plate(0.0), &HOME);
        for (period, gap) in [(0.001, 1e-4), (0.004, 5e-4), (0.004, 1e-4), (0.004, -1e-3), (0.01, 1.2e-3)] {
            let avoidance = CollisionAvoidance {
                min_distance_m: NEAREST,
                own: false,
                obstacles: plate(distance - NEAREST - gap),
                ..CollisionAvoidance::default()
            };
            let setup = Setup { period, seed: 2, ..Setup::default() };
            let mut config =
                ControllerConfig { constraints: vec![Constraint::Distances(avoidance)], ..config(&robot, setup) };
            // The posture alone: the tool has its target elsewhere.
            config.tasks.remove(0);
            let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
            let (mut arm, mut memory, mut fastest) = (LaggingArm::at_rest(&HOME, SLOW, 0.0, 1), None, 0.0_f64);
            for i in 0..1000 {
                let command = stepper.step(&mut memory, &arm.measure(f64::from(i) * period)).unwrap();
                fastest = fastest.max(command.resolution.joint_velocity.amax());
                arm.follow(command.resolution.joint_velocity.as_slice(), period);
            }
            assert!(fastest < 1e-3, "{run}, T {period} s, gap {gap} m: {fastest} rad/s");
        }
    }
}
