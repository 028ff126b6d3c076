//! Draws `docs/chunks.svg`: chunks of a slow policy, followed as chunks and by "the last target wins"; prints the numbers of both.
//!
//! Run with `cargo run --release -p revprio-core --example chunks_figure` in the folder of the repository.

use std::fmt::Write;
use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};
use revprio_core::controller::{Controller, ControllerConfig, Limits, Measurement, Stepper, TaskConfig};
use revprio_core::law::{Law, PositionLaw};
use revprio_core::limits::{Drive, LimitKind};
use revprio_core::robot::built_in;
use revprio_core::robot::kinematics::{Axis, AxisSelection, Configuration};
use revprio_core::rows::{TaskRows, ToolRows};
use revprio_core::streaming::{Action, Align, StreamedChunk, StreamedTarget, StreamedValue, Streaming};

/// Period, s; length of a run, s; start of the policy's answers.
const PERIOD: f64 = 0.008;
const LENGTH: f64 = 6.0;

/// The policy: 50 actions of 30 Hz, 0.5 s after it looked, each 0.6 s; every chunk is up to 30 mm off.
const ACTIONS: u32 = 50;
const INTERVAL: f64 = 1.0 / 30.0;
const LATENCY: f64 = 0.5;
const CYCLE: f64 = 0.6;
const OFFSETS: [f64; 10] = [0.0, 0.02, -0.015, 0.03, -0.02, 0.01, -0.03, 0.015, 0.0, -0.01];

const START: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
const BLUE: &str = "#0072b2";
const VERMILLION: &str = "#d55e00";

type Error = Box<dyn std::error::Error>;

/// A chunk on its way: when it arrives, and its actions (time, y).
struct Answer {
    arrives_s: f64,
    actions: Vec<(f64, f64)>,
}

/// How a run ends up: per period the time, the target y and the tool's y (m), and the command of joint 1 (rad/s).
struct Trace {
    name: &'static str,
    rows: Vec<[f64; 4]>,
    commands: Vec<Vec<f64>>,
}

/// Where the policy wants the tool, m from the start.
fn path(time: f64) -> f64 {
    0.12 * (1.5 * time).sin()
}

fn answers() -> Vec<Answer> {
    let of = |(look, offset): (f64, f64)| {
        let action = |k: u32| {
            let time = look + f64::from(k) * INTERVAL;
            (time, path(time) + offset)
        };
        Answer { arrives_s: look + LATENCY, actions: (0..ACTIONS).map(action).collect() }
    };
    OFFSETS.iter().enumerate().map(|(k, offset)| of((k as f64 * CYCLE, *offset))).collect()
}

/// The arm, and the settings of a task that follows its targets.
fn stepper(streaming: Streaming) -> Result<Stepper, Error> {
    let axes = [Axis::X, Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
    let hand = TaskConfig {
        name: "hand".to_owned(),
        rows: TaskRows::Tool(ToolRows::new(AxisSelection::new(&axes)?)),
        law: Law::Position(PositionLaw::new(vec![8.0; 6])?),
        scaled: false,
        streaming,
    };
    let robot = built_in().iter().find(|robot| robot.name() == "panda").ok_or("no panda")?;
    let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
    let config = ControllerConfig::new(Arc::clone(robot), PERIOD, vec![hand]);
    let config = ControllerConfig { limits, drive: Drive { lag_s: 0.03, delay_periods: 2 }, ..config };
    Ok(Stepper::new(Controller::new(config)?)?)
}

/// Runs the policy against an arm with a lag of 30 ms and a dead time of two periods.
fn run(name: &'static str, as_chunks: bool) -> Result<Trace, Error> {
    let free = Streaming {
        smoothing_s: 0.0,
        hold_after_s: 10.0,
        brake_after_s: 10.0,
        max_velocity: Some(vec![1e3; 6]),
        max_acceleration: Some(vec![1e6; 6]),
        ..Streaming::default()
    };
    let mut stepper = stepper(if as_chunks { Streaming::default() } else { free })?;
    let robot = Arc::clone(&stepper.controller().config().robot);
    let start = *Configuration::new(&robot, &START)?.tool_pose();
    let pose = |y: f64| StreamedValue::Pose {
        position: Some(start.translation.vector + Vector3::new(0.0, y, 0.0)),
        orientation: Some(UnitQuaternion::from_rotation_matrix(&start.rotation)),
    };
    let (answers, mut memory) = (answers(), None);
    let (mut q, mut velocity, mut delayed) = (START.to_vec(), vec![0.0; 7], vec![vec![0.0; 7]; 2]);
    let mut trace = Trace { name, rows: Vec::new(), commands: Vec::new() };
    let mut last_action = f64::NEG_INFINITY;
    for number in 0.. {
        let time_s = f64::from(number) * PERIOD;
        if time_s > LENGTH {
            break;
        }
        let newest = answers.iter().rfind(|answer| answer.arrives_s <= time_s);
        let (mut targets, mut chunks, mut wanted) = (Vec::new(), Vec::new(), f64::NAN);
        if let Some(answer) = newest {
            let due = answer.actions.iter().rfind(|(at, _)| *at <= time_s).ok_or("no action is due")?;
            wanted = due.1;
            if as_chunks && time_s - answer.arrives_s < PERIOD {
                let action = |(time_s, y): &(f64, f64)| Action { time_s: *time_s, value: pose(*y) };
                let actions = answer.actions.iter().map(action).collect();
                chunks.push(StreamedChunk { channels: Vec::new(), task: 0, actions, align: Align::Time });
            } else if !as_chunks && due.0 > last_action {
                last_action = due.0;
                let velocity = Some(vec![0.0; 6]);
                targets.push(StreamedTarget {
                    task: 0,
                    time_s: due.0,
                    value: pose(due.1),
                    velocity,
                    ahead: Vec::new(),
                });
            }
        }
        let measured = Measurement {
            channels: Vec::new(),
            time_s,
            joint_position: q.clone(),
            joint_velocity: None,
            wrench: [0.0; 6],
            wrenches: Vec::new(),
            targets,
            chunks,
            obstacles: Vec::new(),
        };
        let command = stepper.step(&mut memory, &measured)?.resolution.joint_velocity.as_slice().to_vec();
        let y = Configuration::new(&robot, &q)?.tool_pose().translation.y - start.translation.y;
        trace.rows.push([time_s, wanted, y, command[0]]);
        trace.commands.push(command.clone());
        delayed.push(command);
        let acting = delayed.remove(0);
        let blend = 1.0 - (-PERIOD / 0.03_f64).exp();
        for (j, u) in acting.iter().enumerate() {
            velocity[j] += blend * (u - velocity[j]);
            q[j] += PERIOD * velocity[j];
        }
    }
    Ok(trace)
}

impl Trace {
    /// Returns root mean square and largest value of a difference of the commands of all joints.
    fn differences(&self, order: usize) -> [f64; 2] {
        let of = |window: &[Vec<f64>], j: usize| match order {
            1 => (window[1][j] - window[0][j]) / PERIOD,
            _ => (window[2][j] - 2.0 * window[1][j] + window[0][j]) / (PERIOD * PERIOD),
        };
        let all = self.commands.windows(order + 1).flat_map(|window| (0..7).map(move |j| of(window, j)));
        let (mut sum, mut count, mut largest) = (0.0, 0.0, 0.0_f64);
        for value in all {
            (sum, count, largest) = (sum + value * value, count + 1.0, largest.max(value.abs()));
        }
        [(sum / count).sqrt(), largest]
    }

    /// Returns the root mean square distance of the tool from the path that the policy wants, m, from 1.5 s on.
    fn error(&self) -> f64 {
        let late: Vec<f64> =
            self.rows.iter().filter(|row| row[0] > 1.5).map(|row| (row[2] - path(row[0])).powi(2)).collect();
        (late.iter().sum::<f64>() / late.len() as f64).sqrt()
    }
}

/// Returns a polyline of points in a panel: corner and size in pixels, ranges of both axes.
fn polyline(panel: [f64; 4], range: [f64; 4], points: impl Iterator<Item = [f64; 2]>, style: &str) -> String {
    let ([left, top, width, height], [x0, x1, y0, y1]) = (panel, range);
    let at = |[x, y]: [f64; 2]| {
        let (x, y) = (left + width * (x - x0) / (x1 - x0), top + height * (y1 - y) / (y1 - y0));
        format!("{x:.1},{y:.1}")
    };
    let points: Vec<String> = points.filter(|[_, y]| y.is_finite()).map(at).collect();
    format!("<polyline points=\"{}\" fill=\"none\" {style}/>\n", points.join(" "))
}

/// Draws one run in a row of two panels: the tool, and the command of joint 1.
fn row(trace: &Trace, top: f64, colour: &str) -> Result<String, Error> {
    let mut svg = String::new();
    let panels =
        [([60.0, top, 380.0, 150.0], 0.2, "tool y, m"), ([520.0, top, 360.0, 150.0], 0.8, "command of joint 1, rad/s")];
    for (index, (panel, half, label)) in panels.into_iter().enumerate() {
        let [left, _, width, height] = panel;
        let range = [0.0, LENGTH, -half, half];
        writeln!(
            svg,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"#999\"/>"
        )?;
        writeln!(svg, "<text x=\"{left}\" y=\"{}\">{}: {label}</text>", top - 8.0, trace.name)?;
        for (value, text) in [(half, format!("{half}")), (-half, format!("−{half}"))] {
            let y = top + height * (half - value) / (2.0 * half) + 5.0;
            writeln!(svg, "<text x=\"{}\" y=\"{y}\" text-anchor=\"end\">{text}</text>", left - 6.0)?;
        }
        if index == 0 {
            let target = trace.rows.iter().map(|row| [row[0], row[1]]);
            svg += &polyline(panel, range, target, "stroke=\"#888\" stroke-width=\"1.2\"");
        }
        let line = trace.rows.iter().map(|row| [row[0], row[2 + index]]);
        svg += &polyline(panel, range, line, &format!("stroke=\"{colour}\" stroke-width=\"1.8\""));
        writeln!(svg, "<text x=\"{left}\" y=\"{}\">0 s</text>", top + height + 18.0)?;
        let end = left + width;
        writeln!(svg, "<text x=\"{end}\" y=\"{}\" text-anchor=\"end\">{LENGTH} s</text>", top + height + 18.0)?;
    }
    Ok(svg)
}

fn main() -> Result<(), Error> {
    let runs = [run("chunks", true)?, run("last target wins", false)?];
    println!("{:17} {:>9} {:>9} {:>9} {:>9} {:>7}", "", "RMS acc.", "max acc.", "RMS jerk", "max jerk", "error");
    println!("{:17} {:>9} {:>9} {:>9} {:>9} {:>7}", "", "rad/s²", "rad/s²", "rad/s³", "rad/s³", "mm");
    for trace in &runs {
        let ([a, a_max], [j, j_max]) = (trace.differences(1), trace.differences(2));
        let error = 1e3 * trace.error();
        println!("{:17} {a:>9.2} {a_max:>9.2} {j:>9.0} {j_max:>9.0} {error:>7.1}", trace.name);
    }
    let mut svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 900 440\" font-family=\"sans-serif\" font-size=\"14\">\n\
                   <title>Chunks of a policy, followed as chunks and by the last target</title>\n\
                   <rect width=\"900\" height=\"440\" fill=\"#fff\"/>\n"
        .to_owned();
    svg += &row(&runs[0], 40.0, BLUE)?;
    svg += &row(&runs[1], 250.0, VERMILLION)?;
    Ok(std::fs::write("docs/chunks.svg", svg + "</svg>\n")?)
}
