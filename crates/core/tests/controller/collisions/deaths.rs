//! Services that fall silent while the arm is near obstacles.

use revprio_core::controller::{Controller, Stepper};
use revprio_core::limits::braking_deceleration;
use revprio_robot::Joint;

use super::super::arms::Random;
use super::super::drives::LaggingArm;
use super::{HOME, NEAREST, Setup, config, nearest, obstacles, targets};

/// What the deaths of a service in one motion show.
#[derive(Debug)]
struct Deaths {
    count: u32,
    /// In periods whose command is valid for that period only.
    short: u32,
    /// Smallest distance less d_min, m.
    margin: f64,
}

/// The service falls silent at any time. The watchdog of the arm holds the last command while it is valid, then it brakes.
fn deaths(with_jerk: bool, seed: u64) -> Deaths {
    let setup = Setup { with_jerk, ..Setup::default() };
    let (robot, obstacles) = (setup.arm.robot(with_jerk), obstacles(false));
    let controller = Controller::new(config(&robot, setup)).unwrap();
    let mut stepper = Stepper::new(controller.clone()).unwrap();
    let mut arm = LaggingArm::at_rest(&HOME, setup.drive, 0.0, 1);
    let (mut random, mut memory) = (Random(seed), None);
    let mut found = Deaths { count: 0, short: 0, margin: f64::INFINITY };
    for i in 0..4000_u32 {
        let time_s = f64::from(i) * setup.period;
        let mut measured = arm.measure(time_s);
        if i % 400 == 0 {
            measured.targets = targets(&robot, &controller.config().tasks, time_s, &mut random);
        }
        let command = stepper.step(&mut memory, &measured).unwrap();
        let velocity = command.resolution.joint_velocity.as_slice().to_vec();
        let moves = velocity.iter().any(|u| u.abs() > 0.3);
        let valid_s = command.hold.valid_for_ms(100) as f64 / 1e3;
        assert!(valid_s >= setup.period, "period {i}: valid for {valid_s} s");
        let is_short = valid_s == setup.period;
        if is_short || (i % 7 == 0 && moves) {
            found.count += 1;
            found.short += u32::from(is_short);
            let mut alone = arm.clone();
            for k in 0..600 {
                let late = (f64::from(k + 1) * setup.period - valid_s).max(0.0);
                let ramp = |(u, joint): (&f64, &Joint)| {
                    (u.abs() - braking_deceleration(&joint.limits) * late).max(0.0).copysign(*u)
                };
                let sent: Vec<f64> = velocity.iter().zip(robot.joints()).map(ramp).collect();
                alone.follow(&sent, setup.period);
                found.margin = found.margin.min(nearest(&robot, &obstacles, &alone.q) - NEAREST);
            }
        }
        arm.follow(&velocity, setup.period);
    }
    found
}

#[test]
fn an_arm_whose_service_dies_keeps_clear() {
    for (with_jerk, seed) in [(false, 3), (true, 3), (true, 4)] {
        let found = deaths(with_jerk, seed);
        assert!(found.count > 100 && found.short > 5 && found.margin >= -1e-6, "jerk limits {with_jerk}: {found:?}");
    }
}

#[test]
#[ignore = "asserts nothing; 80 motions take minutes; prints what docs/collisions.md says about a service that dies"]
fn table_of_deaths() {
    let seeds = std::env::var("SEEDS").map_or(4, |text| text.parse().unwrap());
    for with_jerk in [false, true] {
        let mut all = Deaths { count: 0, short: 0, margin: f64::INFINITY };
        for found in (1..=seeds).map(|seed| deaths(with_jerk, seed)) {
            all = Deaths {
                count: all.count + found.count,
                short: all.short + found.short,
                margin: all.margin.min(found.margin),
            };
        }
        println!("jerk limits {with_jerk}: {all:?}");
    }
}
