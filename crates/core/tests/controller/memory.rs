//! The memory of a controller: it is complete and reproducible, and other memories are refused.

use revprio_core::controller::{Controller, ControllerConfig, Limits, Measurement, MemoryError, StepError};
use revprio_core::limits::LimitKind;
use revprio_core::resolution::{Bound, BoundId, Solver};
use revprio_robot::JointLimits;
use revprio_robot::kinematics::Axis;

use super::arms::{
    Loop, NOMINAL, Random, config, controller, force, gantry, impedance, measurement, sawyer, step, task,
};

fn limited_controller() -> Controller {
    let rest = [Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
    let tasks = vec![task(&[Axis::X], force(&[Axis::X], &[30.0])), task(&rest, impedance(&rest, 500.0))];
    let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
    controller(ControllerConfig { limits, ..config(&sawyer(), tasks) })
}

/// Returns random wrenches that drive the arm into its limits and away from them.
fn pushes() -> Vec<[f64; 6]> {
    let mut random = Random(5);
    (0..2000).map(|_| [0.0; 6].map(|_: f64| 500.0 * random.signed())).collect()
}

/// Returns a text that contains every bit of a value: `Debug` writes floats exactly, including −0.
fn bytes(answer: &impl std::fmt::Debug) -> String {
    format!("{answer:?}")
}

#[test]
fn the_same_input_gives_the_same_bits() {
    let answers = || {
        let (controller, mut arm) = (limited_controller(), Loop::at_rest(&NOMINAL));
        pushes().into_iter().map(|push| bytes(&(arm.step(&controller, push), &arm.memory))).collect::<Vec<_>>()
    };
    assert_eq!(answers(), answers());
}

#[test]
fn a_reused_stepper_gives_the_same_bits_as_a_new_one() {
    for solver in [Solver::ClosedForm, Solver::Auto, Solver::Qp] {
        let own = controller(ControllerConfig { solver, ..limited_controller().config().clone() });
        let (mut arm, mut memory) = (Loop::at_rest(&NOMINAL), None);
        let mut stepper = crate::solvers::stepper(own.clone());
        for push in pushes().into_iter().take(300) {
            let measured = arm.measurement(own.config().period_s, push);
            let again = bytes(stepper.step(&mut memory, &measured).unwrap());
            assert_eq!(again, bytes(&arm.step(&own, push)));
            assert_eq!(bytes(&memory), bytes(&arm.memory));
        }
    }
}

#[test]
fn another_replica_continues_from_the_memory_to_the_last_bit() {
    let (controller, mut arm) = (limited_controller(), Loop::at_rest(&NOMINAL));
    let pushes = pushes();
    let (first, second) = pushes.split_at(1000);
    for &push in first {
        arm.step(&controller, push);
    }
    let (replica, mut continued) = (limited_controller(), arm.clone());
    for &push in second {
        assert_eq!(bytes(&arm.step(&controller, push)), bytes(&continued.step(&replica, push)));
    }
}

fn refusal(controller: &Controller, arm: &Loop) -> MemoryError {
    let mut memory = arm.memory.clone();
    let refused = step(controller, &mut memory, &measurement(&vec![1.0; controller.config().robot.joint_count()]));
    assert_eq!(memory, arm.memory, "an error must leave the memory unchanged");
    match refused {
        Err(StepError::Memory(error)) => error,
        other => panic!("not refused: {other:?}"),
    }
}

#[test]
fn the_memory_of_another_controller_is_refused() {
    let (own, mut arm) = (limited_controller(), Loop::at_rest(&NOMINAL));
    arm.step(&own, [0.0; 6]);
    let other_tasks = controller(config(&sawyer(), vec![task(&Axis::ALL, force(&Axis::ALL, &[0.0; 6]))]));
    assert_eq!(refusal(&other_tasks, &arm), MemoryError::TaskVelocities);
    let other_arm = controller(ControllerConfig { robot: gantry(JointLimits::NONE), ..own.config().clone() });
    assert_eq!(refusal(&other_arm, &arm), MemoryError::LastCommand);
}

#[test]
fn a_damaged_memory_is_refused() {
    let (own, mut arm) = (limited_controller(), Loop::at_rest(&NOMINAL));
    arm.step(&own, [0.0; 6]);
    let damaged = |damage: &dyn Fn(&mut revprio_core::controller::Memory)| {
        let mut arm = arm.clone();
        damage(arm.memory.as_mut().unwrap());
        refusal(&own, &arm)
    };
    let set = |ids: &[BoundId]| vec![ids.iter().copied().map(Bound::upper).collect()];
    let [joint, beyond] = [BoundId::Joint(1), BoundId::Task { index: 1, row: 5 }];
    assert_eq!(damaged(&|memory| memory.active_set = set(&[beyond])), MemoryError::ActiveSet);
    assert_eq!(damaged(&|memory| memory.active_set = set(&[joint, joint])), MemoryError::ActiveSet);
    assert_eq!(damaged(&|memory| drop(memory.task_velocities.pop())), MemoryError::TaskVelocities);
    // Infinity, not NaN: the test compares memories, and NaN is not equal to itself.
    assert_eq!(damaged(&|memory| memory.task_velocities[0][0] = f64::INFINITY), MemoryError::TaskVelocities);
    assert_eq!(damaged(&|memory| memory.last_command[3] = f64::INFINITY), MemoryError::LastCommand);
}

#[test]
fn invalid_measurements_are_refused_and_leave_the_memory_unchanged() {
    let (own, mut arm) = (limited_controller(), Loop::at_rest(&NOMINAL));
    arm.step(&own, [0.0; 6]);
    let before = arm.memory.clone();
    let mut refused = |measured: Measurement| {
        let error = step(&own, &mut arm.memory, &measured).unwrap_err();
        assert_eq!(arm.memory, before);
        error
    };
    let good = measurement(&NOMINAL);
    let speeds = |v: Vec<f64>| Measurement { joint_velocity: Some(v), ..good.clone() };
    assert_eq!(refused(speeds(vec![0.0; 6])), StepError::JointVelocity { expected: 7 });
    assert_eq!(refused(speeds(vec![f64::NAN; 7])), StepError::JointVelocity { expected: 7 });
    assert_eq!(refused(Measurement { time_s: f64::NAN, ..good.clone() }), StepError::NotFinite);
    assert_eq!(refused(Measurement { wrench: [f64::INFINITY; 6], ..good.clone() }), StepError::NotFinite);
    assert!(matches!(refused(measurement(&[f64::NAN; 7])), StepError::Configuration(_)));
    assert!(matches!(refused(measurement(&[0.0; 3])), StepError::Configuration(_)));
}
