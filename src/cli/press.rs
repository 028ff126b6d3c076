//! `revprio push` and `revprio wipe`

use revprio_api::presets::{PressOptions, WipeOptions, push, wipe};
use revprio_api::wire::{Axis, ControllerTask, Frame};
use serde_json::{Value, json};

use super::error::CliError;
use super::one_of::one_of;
use super::output::print_text;

/// Force and arm of both commands.
#[derive(Debug, clap::Args)]
struct Press {
    /// Axis along which the tool presses
    #[arg(long, value_parser = one_of(&Axis::ALL))]
    axis: Axis,
    /// Target force on the environment, N, or N·m for an axis of rotation; its sign is the direction in which the tool presses
    #[arg(long)]
    newtons: f64,
    /// Name of the robot
    #[arg(long)]
    robot: String,
    /// Axes that a further task holds, all others if left out
    #[arg(long, value_delimiter = ',', value_parser = one_of(&Axis::ALL))]
    hold: Option<Vec<Axis>>,
    /// Control period, s
    #[arg(long, default_value_t = 0.001)]
    period_s: f64,
    /// First-order lag of the arm's velocity loop, s
    #[arg(long, default_value_t = 0.03)]
    lag_s: f64,
    /// Delay of a command, whole periods
    #[arg(long, default_value_t = 2)]
    delay_periods: u32,
    /// Speed of the approach, m/s; if left out, the largest that keeps 1.2 times the force
    #[arg(long)]
    approach_speed: Option<f64>,
    /// Stiffness of the stiffest contact, N/m; if left out, 1e6
    #[arg(long)]
    stiffest: Option<f64>,
    /// Force at which the tool leaves, N; if left out, none
    #[arg(long)]
    max_force: Option<f64>,
}

impl Press {
    fn options(&self) -> PressOptions {
        PressOptions {
            hold: self.hold.clone(),
            period_s: self.period_s,
            lag_s: self.lag_s,
            delay_periods: self.delay_periods,
            approach_speed: self.approach_speed,
            stiffest: self.stiffest,
            max_force: self.max_force,
        }
    }

    /// Prints the body of `POST /v1/controllers`.
    fn print(&self, tasks: &[ControllerTask]) -> Result<(), CliError> {
        let drive = json!({"lag_s": self.lag_s, "delay_periods": self.delay_periods});
        let body: Value = json!({"robot": self.robot, "period_s": self.period_s, "drive": drive, "tasks": tasks});
        Ok(print_text(format_args!("{body:#}\n"))?)
    }
}

/// The tool presses on a surface whose stiffness nobody needs to know. Give your arm's lag and delay.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct PushOptions {
    #[command(flatten)]
    press: Press,
}

/// The tool presses along one axis of the base and moves along another one. Give your arm's lag and delay.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct SweepOptions {
    #[command(flatten)]
    press: Press,
    /// Axis of the motion
    #[arg(long, value_parser = one_of(&[Axis::X, Axis::Y, Axis::Z]))]
    along: Axis,
    /// Way from the start along this axis and back, m; negative: the other direction
    #[arg(long, default_value_t = 0.1)]
    stroke_m: f64,
    /// Largest speed of the motion, m/s
    #[arg(long, default_value_t = 0.05)]
    speed: f64,
    /// Largest tilt of a surface of unknown direction, whose normal the axes follow, rad, up to 1.4; if left out, they stay. The motion
    /// begins with the first state: start the arm in touch
    #[arg(long)]
    max_tilt_rad: Option<f64>,
}

pub fn run_push(options: &PushOptions) -> Result<(), CliError> {
    let press = &options.press;
    press.print(&push(press.axis, press.newtons, &press.options())?)
}

pub fn run_wipe(options: &SweepOptions) -> Result<(), CliError> {
    let SweepOptions { press, along, stroke_m, speed, max_tilt_rad } = options;
    let wiping = WipeOptions {
        press: press.options(),
        stroke_m: *stroke_m,
        speed: *speed,
        frame: Frame::Base,
        max_tilt_rad: *max_tilt_rad,
    };
    press.print(&wipe(press.axis, press.newtons, *along, &wiping)?)
}
