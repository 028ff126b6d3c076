//! From the reading of a wrist sensor to the wrench on the environment.

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Rotation3, Vector3};
use proptest::prelude::*;
use revprio_core::controller::{
    Command, ConfigError, Controller, ControllerConfig, Measurement, Memory, Stepper, TaskConfig, WrenchConvention,
    WrenchFrame,
};
use revprio_core::law::{ContactLaw, ContactSettings, ForceLaw, Gains, Law, Profile};
use revprio_core::limits::Drive;
use revprio_core::rows::{TaskRows, ToolRows};
use revprio_core::streaming::Streaming;
use revprio_core::wrench::{
    Load, Tare, TareError, TareReading, Wrench, WrenchSensor, WrenchSensorError, WrenchTerms, tare,
};
use revprio_robot::kinematics::{Axis, AxisSelection, Configuration};
use revprio_robot::{RobotModel, built_in};

const PERIOD: f64 = 1e-3;
const NOMINAL: [f64; 7] = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];

fn sawyer() -> Arc<RobotModel> {
    Arc::clone(&built_in()[0])
}

/// Returns a controller with the force law along z and one sensor.
fn config(sensor: WrenchSensor) -> ControllerConfig {
    let law = ForceLaw::new(Gains::new(1, &[15.0], &[150.0], &[0.0]).unwrap(), Profile::constant(vec![5.0]).unwrap());
    with_law(sensor, Law::Force(law.unwrap()))
}

fn with_law(sensor: WrenchSensor, law: Law) -> ControllerConfig {
    let rows = TaskRows::Tool(ToolRows::new(AxisSelection::new(&[Axis::Z]).unwrap()));
    let push = TaskConfig { name: "push".to_owned(), rows, law, scaled: false, streaming: Streaming::default() };
    ControllerConfig { wrench_sensors: vec![sensor], ..ControllerConfig::new(sawyer(), PERIOD, vec![push]) }
}

fn measurement(time_s: f64, joint_position: &[f64], wrench: [f64; 6]) -> Measurement {
    Measurement {
        time_s,
        joint_position: joint_position.to_vec(),
        joint_velocity: None,
        wrench,
        wrenches: Vec::new(),
        targets: Vec::new(),
        chunks: Vec::new(),
        channels: Vec::new(),
        obstacles: Vec::new(),
    }
}

/// A session of one controller.
struct Session {
    stepper: Stepper,
    memory: Option<Memory>,
    time_s: f64,
}

impl Session {
    fn new(config: ControllerConfig) -> Self {
        Self { stepper: Stepper::new(Controller::new(config).unwrap()).unwrap(), memory: None, time_s: 0.0 }
    }

    fn step(&mut self, joint_position: &[f64], reading: [f64; 6]) -> Command {
        self.time_s += PERIOD;
        self.stepper.step(&mut self.memory, &measurement(self.time_s, joint_position, reading)).unwrap().clone()
    }
}

/// Returns what a sensor reads, written without the code of the crate: F_e on the environment at the tip, base axes.
fn reading(
    sensor: &WrenchSensor,
    terms: WrenchTerms,
    q: &[f64],
    on_environment: &[f64; 6],
    a: Vector3<f64>,
) -> [f64; 6] {
    let configuration = Configuration::new(&sawyer(), q).unwrap();
    let tip = configuration.tool_pose();
    let (axes, origin) = ((tip * sensor.pose).rotation, (tip * sensor.pose).translation.vector);
    let [fx, fy, fz, tx, ty, tz] = on_environment.map(|entry| -entry);
    let (force, torque) = (Vector3::new(fx, fy, fz), Vector3::new(tx, ty, tz));
    // Of the environment on the tool, about the origin of the sensor.
    let torque = torque + (tip.translation.vector - origin).cross(&force);
    let weight = sensor.load.mass * (sensor.gravity - a);
    let arm = axes * sensor.load.center_of_mass;
    let sign = if terms.convention == WrenchConvention::OnTool { 1.0 } else { -1.0 };
    let back = axes.inverse();
    let force = sign * (back * (force + weight)) + sensor.bias.force;
    let torque = sign * (back * (torque + arm.cross(&weight))) + sensor.bias.torque;
    let turn = if terms.frame == WrenchFrame::Base { axes } else { Rotation3::identity() };
    let (force, torque) = (turn * force, turn * torque);
    [force.x, force.y, force.z, torque.x, torque.y, torque.z]
}

fn vector(range: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-range..range).prop_map(Vector3::from)
}

fn six(force: f64, torque: f64) -> impl Strategy<Value = Wrench> {
    (vector(force), vector(torque)).prop_map(|(force, torque)| Wrench { force, torque })
}

fn sensor() -> impl Strategy<Value = WrenchSensor> {
    let pose = (vector(0.3), vector(PI)).prop_map(|(place, turn)| IsometryMatrix3::new(place, turn));
    let load = (0.0..10.0, vector(0.3)).prop_map(|(mass, center_of_mass)| Load { mass, center_of_mass });
    (pose, six(20.0, 2.0), load, vector(12.0)).prop_map(|(pose, bias, load, gravity)| WrenchSensor {
        pose,
        bias,
        load,
        gravity,
        ..WrenchSensor::at_tip(0)
    })
}

fn terms() -> impl Strategy<Value = WrenchTerms> {
    let convention = prop_oneof![Just(WrenchConvention::OnTool), Just(WrenchConvention::OnEnvironment)];
    let frame = prop_oneof![Just(WrenchFrame::Base), Just(WrenchFrame::Tool)];
    (convention, frame).prop_map(|(convention, frame)| WrenchTerms { convention, frame })
}

fn in_terms(config: ControllerConfig, terms: WrenchTerms) -> ControllerConfig {
    ControllerConfig { wrench_convention: terms.convention, wrench_frame: terms.frame, ..config }
}

fn differs(a: &[f64; 6], b: &[f64; 6], tolerance: f64) -> bool {
    !a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance)
}

proptest! {
    #[test]
    fn the_true_contact_wrench_comes_out_in_every_posture(
        sensor in sensor(),
        terms in terms(),
        q in prop::array::uniform7(-2.5..2.5),
        contact in six(100.0, 10.0),
    ) {
        let contact = <[f64; 6]>::from(contact);
        let read = reading(&sensor, terms, &q, &contact, Vector3::zeros());
        let command = Session::new(in_terms(config(sensor), terms)).step(&q, read);
        prop_assert!(!differs(&command.wrenches[0], &contact, 1e-12 * 200.0), "{:?}, not {contact:?}", command.wrenches);
    }

    /// A sensor that corrects nothing changes no command.
    #[test]
    fn a_sensor_at_the_tip_without_corrections_is_no_sensor(
        terms in terms(),
        q in prop::array::uniform7(-2.5..2.5),
        contact in six(100.0, 10.0),
    ) {
        let sensor = WrenchSensor { gravity: Vector3::zeros(), ..WrenchSensor::at_tip(0) };
        let given = in_terms(config(sensor), terms);
        let plain = ControllerConfig { wrench_sensors: Vec::new(), ..given.clone() };
        let speeds = [given, plain].map(|config| Session::new(config).step(&q, contact.into()).resolution.joint_velocity);
        prop_assert!((&speeds[0] - &speeds[1]).amax() < 1e-12);
    }
}

#[test]
fn the_low_pass_is_exact_for_a_reading_that_stays() {
    let filter_time = 0.02;
    let mut session = Session::new(config(WrenchSensor { filter_time, ..WrenchSensor::at_tip(0) }));
    session.step(&NOMINAL, [0.0; 6]);
    for k in 1..=50 {
        let force = session.step(&NOMINAL, [10.0; 6]).wrenches[0];
        let expected = 10.0 * (1.0 - (-f64::from(k) * PERIOD / filter_time).exp());
        assert!(force.iter().all(|entry| (entry - expected).abs() < 1e-12), "{k}: {force:?}");
    }
    // Three periods pass without a state.
    let before = session.step(&NOMINAL, [0.0; 6]).wrenches[0][0];
    session.time_s += 3.0 * PERIOD;
    let after = session.step(&NOMINAL, [0.0; 6]).wrenches[0][0];
    assert!((after - before * (-4.0 * PERIOD / filter_time).exp()).abs() < 1e-12, "{before} {after}");
}

#[test]
fn forces_and_torques_within_the_deadband_are_zero() {
    let mut session = Session::new(config(WrenchSensor { deadband: [2.0, 0.1], ..WrenchSensor::at_tip(0) }));
    let small = session.step(&NOMINAL, [1.0, 1.0, 1.0, 0.05, 0.05, 0.05]).wrenches[0];
    assert_eq!(small, [0.0; 6]);
    let large = session.step(&NOMINAL, [1.0, 1.0, 2.0, 0.05, 0.05, 0.09]).wrenches[0];
    assert!(!differs(&large, &[1.0, 1.0, 2.0, 0.05, 0.05, 0.09], 1e-12), "{large:?}");
}

/// The arm follows its commands behind the stated drive; the sensor feels the acceleration of a load of 2 kg.
#[test]
fn the_inertia_of_the_load_does_not_count_as_a_contact() {
    let load = Load { mass: 2.0, center_of_mass: Vector3::new(0.0, 0.05, 0.1) };
    let felt = |compensates_inertia: bool| {
        let sensor = WrenchSensor { load, compensates_inertia, ..WrenchSensor::at_tip(0) };
        let drive = Drive { lag_s: 0.01, delay_periods: 1 };
        let mut session = Session::new(ControllerConfig { drive, ..config(sensor) });
        let (mut q, mut velocity, mut pending) = (NOMINAL.to_vec(), vec![0.0; 7], vec![0.0; 7]);
        let mut center_velocity = Vector3::zeros();
        let mut most: f64 = 0.0;
        for _ in 0..300 {
            let configuration = Configuration::new(&sawyer(), &q).unwrap();
            let [vx, vy, vz, wx, wy, wz] = configuration.twist(&velocity);
            let center = configuration.tool_pose().rotation * load.center_of_mass;
            let now = Vector3::new(vx, vy, vz) + Vector3::new(wx, wy, wz).cross(&center);
            let acceleration = (now - center_velocity) / PERIOD;
            center_velocity = now;
            let terms = WrenchTerms::default();
            let command = session.step(&q, reading(&sensor, terms, &q, &[0.0; 6], acceleration));
            most = command.wrenches[0].iter().fold(most, |most, entry| most.max(entry.abs()));
            let remaining = (-PERIOD / drive.lag_s).exp();
            for joint in 0..7 {
                velocity[joint] = pending[joint] + (velocity[joint] - pending[joint]) * remaining;
                q[joint] += PERIOD * velocity[joint];
            }
            pending = command.resolution.joint_velocity.as_slice().to_vec();
        }
        most
    };
    let (with, without) = (felt(true), felt(false));
    assert!(with < 1e-9 && without > 0.3, "{with} {without}");
}

#[test]
fn the_contact_law_counts_the_lag_of_the_low_pass() {
    let speed = |filter_time: f64, sensor_lag: f64| {
        let settings = ContactSettings { sensor_lag, ..ContactSettings::LINEAR };
        let law = ContactLaw::new(Profile::constant(vec![-30.0]).unwrap(), vec![settings]).unwrap();
        let sensor = WrenchSensor { filter_time, ..WrenchSensor::at_tip(0) };
        let config = ControllerConfig { drive: Drive::IDEAL, ..with_law(sensor, Law::Contact(law)) };
        Session::new(config).step(&NOMINAL, [0.0; 6]).targets[0].contact[0].approach_speed
    };
    assert!((speed(0.01, 0.002) - speed(0.0, 0.012)).abs() < 1e-15);
    assert!(speed(0.01, 0.002) < 0.9 * speed(0.0, 0.002), "{} {}", speed(0.01, 0.002), speed(0.0, 0.002));
}

#[test]
fn numbers_that_are_none_are_refused() {
    let refused = |change: &dyn Fn(&mut WrenchSensor)| {
        let mut sensor = WrenchSensor::at_tip(0);
        change(&mut sensor);
        match Controller::new(config(sensor)) {
            Err(ConfigError::WrenchSensor { index: 0, source: WrenchSensorError::Range { field, .. } }) => field,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(refused(&|sensor| sensor.bias.torque.z = f64::NAN), "bias");
    assert_eq!(refused(&|sensor| sensor.load.mass = -1.0), "payload");
    assert_eq!(refused(&|sensor| sensor.load.center_of_mass.x = f64::INFINITY), "payload");
    assert_eq!(refused(&|sensor| sensor.gravity.x = f64::NAN), "gravity");
    assert_eq!(refused(&|sensor| sensor.filter_time = -1e-3), "filter_time_s");
    assert_eq!(refused(&|sensor| sensor.deadband[1] = f64::NAN), "deadband_nm");
    assert_eq!(refused(&|sensor| sensor.pose.translation.vector.x = f64::NAN), "pose");
    let twice =
        ControllerConfig { wrench_sensors: vec![WrenchSensor::at_tip(0); 2], ..config(WrenchSensor::at_tip(0)) };
    let misfit = |index| Err(ConfigError::WrenchSensor { index, source: WrenchSensorError::Tip });
    assert_eq!(Controller::new(twice).map(drop), misfit(1));
    assert_eq!(Controller::new(config(WrenchSensor::at_tip(7))).map(drop), misfit(0));
    let mut session = Session::new(config(WrenchSensor::at_tip(0)));
    for broken in [f64::NAN, f64::INFINITY] {
        assert!(session.stepper.step(&mut session.memory, &measurement(0.0, &NOMINAL, [broken; 6])).is_err());
    }
    // The sum overflows.
    let bias = Wrench { force: Vector3::repeat(-1e308), torque: Vector3::zeros() };
    let mut session = Session::new(config(WrenchSensor { bias, ..WrenchSensor::at_tip(0) }));
    assert!(session.stepper.step(&mut session.memory, &measurement(0.0, &NOMINAL, [1e308; 6])).is_err());
    assert!(session.memory.is_none());
}

/// A small generator of numbers with a normal distribution.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / 9_007_199_254_740_992.0
    }

    fn normal(&mut self) -> f64 {
        let (u, v) = (self.uniform() + 1e-300, self.uniform());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).sin()
    }
}

/// The sensor of the issue: a bias of 3 N and 0.5 kg, of which the bias is not known.
fn untared() -> (WrenchSensor, WrenchSensor) {
    let load = Load { mass: 0.5, center_of_mass: Vector3::new(0.01, -0.02, 0.06) };
    let pose = IsometryMatrix3::new(Vector3::new(0.0, 0.0, -0.1), Vector3::new(0.0, 0.0, 0.8));
    let believed = WrenchSensor { load, pose, ..WrenchSensor::at_tip(0) };
    let bias = Wrench { force: Vector3::new(2.0, -1.0, 2.0), torque: Vector3::new(0.1, 0.05, -0.08) };
    (WrenchSensor { bias, ..believed }, believed)
}

fn noisy(clean: [f64; 6], noise: [f64; 2], random: &mut Random) -> [f64; 6] {
    std::array::from_fn(|i| clean[i] + noise[i / 3] * random.normal())
}

/// Readings at rest, with 0.2 N and 0.02 N·m of noise.
fn at_rest(sensor: &WrenchSensor, q: &[f64], count: usize, random: &mut Random) -> Vec<TareReading> {
    let clean = reading(sensor, WrenchTerms::default(), q, &[0.0; 6], Vector3::zeros());
    let read = |_| TareReading { joint_position: q.to_vec(), wrench: noisy(clean, [0.2, 0.02], random) };
    (0..count).map(read).collect()
}

#[test]
fn after_a_tare_the_wrench_is_right_in_every_posture() {
    let mut random = Random(88_172_645_463_325_252);
    let (truth, believed) = untared();
    let mut worst: f64 = 0.0;
    for _ in 0..100 {
        let mut posture = || (0..7).map(|_| 5.0 * random.uniform() - 2.5).collect::<Vec<_>>();
        let (tared_at, measured_at) = (posture(), posture());
        let readings = at_rest(&truth, &tared_at, 100, &mut random);
        let Tare { bias, noise } = tare(&believed, WrenchTerms::default(), &sawyer(), &readings).unwrap();
        assert!((0.1..0.3).contains(&noise[0]) && (0.01..0.03).contains(&noise[1]), "{noise:?}");
        let mut session = Session::new(config(WrenchSensor { bias, ..believed }));
        let clean = reading(&truth, WrenchTerms::default(), &measured_at, &[0.0; 6], Vector3::zeros());
        let left = session.step(&measured_at, clean).wrenches[0];
        worst = worst.max(Vector3::new(left[0], left[1], left[2]).norm());
    }
    println!("left after a tare: {worst:.3} N");
    // The goal of the project is 0.3 N; without the tare it is 3 N.
    assert!(worst < 0.1, "{worst}");
}

#[test]
fn a_tare_of_a_moving_arm_or_a_noisy_wrench_is_refused() {
    let mut random = Random(362_436_069);
    let (truth, believed) = untared();
    let read = |readings: &[TareReading]| tare(&believed, WrenchTerms::default(), &sawyer(), readings);
    let good = at_rest(&truth, &NOMINAL, 100, &mut random);
    assert!(read(&good).is_ok());
    assert_eq!(read(&good[..19]), Err(TareError::Few(19)));
    let mut moves = good.clone();
    for (k, reading) in moves.iter_mut().enumerate() {
        reading.joint_position[4] += 1e-4 * k as f64;
    }
    assert!(matches!(read(&moves), Err(TareError::Moves { joint: 4, .. })), "{:?}", read(&moves));
    let mut shaken = good.clone();
    for (k, reading) in shaken.iter_mut().enumerate() {
        reading.wrench[1] += if k % 2 == 0 { 2.0 } else { -2.0 };
    }
    assert!(matches!(read(&shaken), Err(TareError::Noisy { is_torque: false, .. })), "{:?}", read(&shaken));
    for broken in [f64::NAN, f64::INFINITY] {
        let mut no_number = good.clone();
        no_number[7].wrench[5] = broken;
        assert_eq!(read(&no_number), Err(TareError::NotFinite { reading: 7 }));
        let mut no_place = good.clone();
        no_place[3].joint_position[0] = broken;
        assert!(read(&no_place).is_err());
    }
    let mut short = good.clone();
    short[5].joint_position.pop();
    assert!(matches!(read(&short), Err(TareError::Configuration { reading: 5, .. })));
}
