//! An arm behind lag and dead time that wipes a surface with friction, tilted or curved.

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::{Rotation3, Vector3};
use revprio_core::controller::{Controller, ControllerConfig, Measurement, Memory, Stepper, TaskConfig};
use revprio_core::law::{ContactLaw, ContactPhase, ContactReport, ContactSettings, Law, Point, PositionLaw, Profile};
use revprio_core::limits::Drive;
use revprio_core::resolution::Method;
use revprio_core::rows::{TaskRows, ToolRows};
use revprio_core::streaming::Streaming;
use revprio_core::surface::{NormalReport, SurfaceSettings};
use revprio_robot::kinematics::{Axis, AxisSelection, Configuration, Frame, TaskFrame};
use revprio_robot::{RobotModel, built_in};

/// T, s.
pub const PERIOD: f64 = 0.002;
pub const DRIVE: Drive = Drive { lag_s: 0.01, delay_periods: 1 };
/// F_d, N.
pub const FORCE: f64 = 20.0;
/// Speed of the wipe, m/s.
pub const SPEED: f64 = 0.05;
/// A posture of Sawyer far from limits and singularities.
const NOMINAL: [f64; 7] = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];

/// Velocity below which friction grows with the velocity, m/s: the force of a simulated tool that stands does not jump.
const STICKS: f64 = 1e-3;

/// A surface that the tool touches at the start, and its place there.
#[derive(Debug, Clone, Copy)]
pub struct Surface {
    /// Tilt about the x axis and about the y axis of the base at the start, rad.
    pub tilt: [f64; 2],
    /// Radius of a ball whose top it is, m; negative: of a bowl; infinite: a plane.
    pub radius: f64,
    /// μ.
    pub friction: f64,
    /// K, N/m.
    pub stiffness: f64,
    /// Distance of the tool at the start, m.
    pub distance: f64,
    /// Where it ends along x of the base, m from the start.
    pub end: f64,
}

impl Surface {
    /// A plane with tilts (rad) and μ, of 3e4 N/m.
    pub fn plane(tilt: [f64; 2], friction: f64) -> Self {
        Self { tilt, radius: f64::INFINITY, friction, stiffness: 3e4, distance: 0.003, end: f64::INFINITY }
    }

    /// Returns the normal out of the surface at the start.
    fn up(&self) -> Vector3<f64> {
        Rotation3::from_euler_angles(self.tilt[0], self.tilt[1], 0.0) * Vector3::z()
    }

    /// Returns the depth of a place (m from the start of the tool) and the normal out of the surface there.
    pub fn depth(&self, at: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let up = self.up();
        if at.x > self.end {
            return (0.0, up);
        }
        if self.radius.is_infinite() {
            return (-self.distance - at.dot(&up), up);
        }
        let from_centre = at + up * (self.distance + self.radius);
        let outward = from_centre.normalize();
        (self.radius.signum() * (self.radius.abs() - from_centre.norm()), self.radius.signum() * outward)
    }
}

/// What one period shows.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    pub time: f64,
    /// N, force along the true normal, N.
    pub normal_force: f64,
    /// Angle between the estimated and the true normal, rad.
    pub angle: f64,
    pub report: Option<NormalReport>,
    pub contact: ContactReport,
    /// The tool from its start, m.
    pub at: Vector3<f64>,
}

/// An arm on a surface.
pub struct World {
    robot: Arc<RobotModel>,
    pub surface: Surface,
    q: Vec<f64>,
    velocity: Vec<f64>,
    sent: VecDeque<Vec<f64>>,
    start: Vector3<f64>,
    stepper: Stepper,
    pub memory: Option<Memory>,
    random: u64,
    /// Rms of the noise of the force, N, and largest error of a measured joint, rad.
    pub noise: [f64; 2],
    pub time: f64,
    /// Whether states arrive.
    pub is_connected: bool,
}

/// How the tool moves along the surface, at [`SPEED`] on average.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stroke {
    /// At once.
    Abrupt,
    /// After a second at 5 mm/s.
    SlowStart,
    /// The same, and then to and fro.
    ThereAndBack,
}

/// How a task wipes.
#[derive(Debug, Clone, Copy)]
pub struct Wipe {
    pub surface: Option<SurfaceSettings>,
    pub method: Method,
    /// Unit vector of the stroke along the stated axes of the frame, without z.
    pub along: [f64; 2],
    pub stroke: Stroke,
    /// The stated axes.
    pub frame: Frame,
    /// Force at which the tool leaves, N.
    pub max_force: f64,
    /// Whether a task moves along x, and another one along y.
    pub in_two_tasks: bool,
}

impl Wipe {
    pub const ALONG_X: Self = Self {
        surface: Some(SurfaceSettings { max_tilt: std::f64::consts::FRAC_PI_4 }),
        method: Method::StrictReversePriority,
        along: [1.0, 0.0],
        stroke: Stroke::SlowStart,
        frame: Frame::Base,
        max_force: f64::INFINITY,
        in_two_tasks: false,
    };
}

/// Time at which the wipe begins, s.
pub const BEGIN: f64 = 3.0;

pub fn task(name: &str, axes: &[Axis], frame: Frame, law: Law, displacement: Option<Profile>) -> TaskConfig {
    let rows = ToolRows {
        frame: TaskFrame { frame, ..TaskFrame::default() },
        target_displacement: displacement,
        ..ToolRows::new(AxisSelection::new(axes).unwrap())
    };
    TaskConfig {
        name: name.to_owned(),
        rows: TaskRows::Tool(rows),
        law,
        scaled: false,
        streaming: Streaming::default(),
    }
}

/// Returns a law that presses downwards.
pub fn pressing(surface: Option<SurfaceSettings>, max_force: f64) -> ContactLaw {
    let settings = ContactSettings { approach_speed: Some(0.01), max_force, ..ContactSettings::default() };
    let law = ContactLaw::new(Profile::constant(vec![-FORCE]).unwrap(), vec![settings]).unwrap();
    match surface {
        Some(surface) => law.with_surface(surface).unwrap(),
        None => law,
    }
}

/// Returns the motion of some axes, as parts of the stroke, from [`BEGIN`] on.
fn stroke(stroke: Stroke, parts: &[f64]) -> Profile {
    let at = |way: f64| parts.iter().map(|part| part * SPEED * way).collect::<Vec<_>>();
    let points = |ways: &[[f64; 2]]| {
        let point = |[time, way]: &[f64; 2]| Point { time_s: *time, value: at(*way) };
        Profile::waypoints(&ways.iter().map(point).collect::<Vec<_>>()).unwrap()
    };
    let b = BEGIN;
    match stroke {
        Stroke::Abrupt => Profile::ramp(at(0.0), at(4.0), b, 4.0).unwrap(),
        Stroke::SlowStart => {
            let begin = [[0.0, 0.0], [b, 0.0], [b + 1.0, 0.1], [b + 1.5, 0.3]];
            let ways = (1..7).map(|i| [b + 1.5 + 0.5 * f64::from(i), 0.3 + 0.5 * f64::from(i)]);
            points(&begin.into_iter().chain(ways).collect::<Vec<_>>())
        }
        Stroke::ThereAndBack => {
            let begin = [[0.0, 0.0], [b, 0.0], [b + 1.0, 0.1]];
            let ways = (1..9_u8).map(|i| [b + 1.0 + 0.5 * f64::from(i), [0.0, 0.5, 1.0, 0.5][usize::from(i) % 4]]);
            points(&begin.into_iter().chain(ways).collect::<Vec<_>>())
        }
    }
}

/// Returns a controller that presses along z, moves along x and y, and holds the orientation.
pub fn controller(robot: &Arc<RobotModel>, wipe: Wipe) -> Controller {
    let [x, y] = wipe.along;
    let moving = |name: &str, axes: &[Axis], parts: &[f64]| {
        let hold = Law::Position(PositionLaw::new(vec![5.0; axes.len()]).unwrap());
        task(name, axes, wipe.frame, hold, Some(stroke(wipe.stroke, parts)))
    };
    let press = Law::Contact(pressing(wipe.surface, wipe.max_force));
    let mut tasks = vec![task("press", &[Axis::Z], wipe.frame, press, None)];
    if wipe.in_two_tasks {
        tasks.push(moving("move", &[Axis::X], &[x]));
        tasks.push(moving("hold", &[Axis::Y, Axis::Rx, Axis::Ry, Axis::Rz], &[y, 0.0, 0.0, 0.0]));
    } else {
        tasks.push(moving("move", &[Axis::X, Axis::Y, Axis::Rx, Axis::Ry, Axis::Rz], &[x, y, 0.0, 0.0, 0.0]));
    }
    Controller::new(ControllerConfig {
        drive: DRIVE,
        method: wipe.method,
        ..ControllerConfig::new(Arc::clone(robot), PERIOD, tasks)
    })
    .unwrap()
}

impl World {
    pub fn new(surface: Surface, wipe: Wipe) -> Self {
        let robot = Arc::clone(&built_in()[0]);
        let start = Configuration::new(&robot, &NOMINAL).unwrap().tool_pose().translation.vector;
        let stepper = Stepper::new(controller(&robot, wipe)).unwrap();
        Self {
            surface,
            q: NOMINAL.to_vec(),
            velocity: vec![0.0; 7],
            sent: std::iter::repeat_n(vec![0.0; 7], DRIVE.delay_periods).collect(),
            start,
            stepper,
            memory: None,
            random: 0x9e37_79b9_7f4a_7c15,
            noise: [0.2, 0.0],
            time: 0.0,
            robot,
            is_connected: true,
        }
    }

    /// Returns a number between −1 and 1.
    fn signed(&mut self) -> f64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 11) as f64 / 4_503_599_627_370_496.0 - 1.0
    }

    /// Returns a number with the mean 0 and the variance 1.
    fn normal(&mut self) -> f64 {
        // The sum of three uniform numbers.
        self.signed() + self.signed() + self.signed()
    }

    /// Runs for a time, s.
    pub fn run(&mut self, time: f64) -> Vec<Seen> {
        let end = self.time + time - 0.5 * PERIOD;
        let mut seen = Vec::new();
        while self.time < end {
            seen.extend(self.step());
        }
        seen
    }

    /// Returns whether a controller refuses to continue from a memory.
    pub fn refuses(&mut self, memory: Memory) -> bool {
        let measurement = self.measurement([0.0; 3]);
        self.stepper.step(&mut Some(memory), &measurement).is_err()
    }

    /// Returns the state of the arm with a force, N.
    fn measurement(&mut self, [fx, fy, fz]: [f64; 3]) -> Measurement {
        let joint_noise = self.noise[1];
        Measurement {
            channels: Vec::new(),
            chunks: Vec::new(),
            wrenches: Vec::new(),
            obstacles: Vec::new(),
            time_s: self.time,
            joint_position: (0..7).map(|joint| self.q[joint] + joint_noise * self.signed()).collect(),
            joint_velocity: None,
            wrench: [fx, fy, fz, 0.0, 0.0, 0.0],
            targets: Vec::new(),
        }
    }

    /// Runs one period; `None`: no state arrives.
    fn step(&mut self) -> Option<Seen> {
        let tool = Configuration::new(&self.robot, &self.q).unwrap();
        let at = tool.tool_pose().translation.vector - self.start;
        let [x, y, z, ..] = tool.twist(&self.velocity);
        let velocity = Vector3::new(x, y, z);
        let (depth, up) = self.surface.depth(&at);
        let normal_force = self.surface.stiffness * depth.max(0.0);
        let tangent = velocity - up * up.dot(&velocity);
        let friction = self.surface.friction * normal_force * tangent / tangent.norm().max(STICKS);
        let force = friction - normal_force * up;
        let noise = Vector3::new(self.normal(), self.normal(), self.normal()) * self.noise[0];
        let seen = self.is_connected.then(|| {
            let measurement = self.measurement((force + noise).into());
            let command = self.stepper.step(&mut self.memory, &measurement).unwrap();
            let contact = command.targets.iter().find_map(|target| target.contact.first().copied()).unwrap();
            let normal = contact.normal.map_or(-Vector3::z(), |report| report.normal);
            self.sent.push_back(command.resolution.joint_velocity.as_slice().to_vec());
            let angle = normal.angle(&-up);
            Seen { time: self.time, normal_force, angle, report: contact.normal, contact, at }
        });
        if seen.is_none() {
            self.sent.push_back(vec![0.0; 7]);
        }
        let acting = self.sent.pop_front().unwrap();
        let remaining = (-PERIOD / DRIVE.lag_s).exp();
        for ((q, v), u) in self.q.iter_mut().zip(&mut self.velocity).zip(acting) {
            *q += PERIOD * u + (*v - u) * DRIVE.lag_s * (1.0 - remaining);
            *v = u + (*v - u) * remaining;
        }
        self.time += PERIOD;
        seen
    }
}

/// Way of the wipe after which the figures begin, m.
const LEARNT: f64 = 0.01;

/// What the wipe of a run shows, after its first millimetres.
#[derive(Debug, Clone, Copy)]
pub struct Wiped {
    /// Largest |N/F_d − 1|.
    pub error: f64,
    /// Least and largest N/F_d − 1.
    pub errors: [f64; 2],
    /// Its rms.
    pub rms: f64,
    /// Largest angle of the normal in the last second, rad.
    pub angle: f64,
    /// Periods without contact.
    pub losses: usize,
    /// Largest N of the whole run, over F_d.
    pub peak: f64,
    /// The last friction.
    pub friction: f64,
}

impl Wiped {
    /// Reads a run.
    pub fn of(seen: &[Seen]) -> Self {
        Self::after(LEARNT, seen)
    }

    /// Reads a run from a way of the wipe on, m.
    pub fn after(way: f64, seen: &[Seen]) -> Self {
        let begin = seen.iter().find(|seen| seen.time > BEGIN).map_or_else(Vector3::zeros, |seen| seen.at);
        let first =
            seen.iter().position(|seen| seen.time > BEGIN && (seen.at - begin).norm() > way).unwrap_or(seen.len());
        let wiped = || seen[first..].iter();
        let signed = |seen: &Seen| seen.normal_force / FORCE - 1.0;
        let error = |seen: &Seen| signed(seen).abs();
        let count = wiped().count() as f64;
        Self {
            error: wiped().map(error).fold(0.0, f64::max),
            errors: [wiped().map(signed).fold(0.0, f64::min), wiped().map(signed).fold(0.0, f64::max)],
            rms: (wiped().map(|seen| error(seen).powi(2)).sum::<f64>() / count).sqrt(),
            angle: seen[seen.len() - 500..].iter().map(|seen| seen.angle).fold(0.0, f64::max),
            losses: wiped().filter(|seen| seen.contact.phase != ContactPhase::Contact).count(),
            peak: seen.iter().map(|seen| seen.normal_force / FORCE).fold(0.0, f64::max),
            friction: seen.last().and_then(|seen| seen.report?.friction).unwrap_or(f64::NAN),
        }
    }
}
