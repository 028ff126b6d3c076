//! `revprio push` and `revprio wipe`

use revprio_api::ClientError;
use revprio_api::presets::{PressOptions, WipeOptions, push, wipe};
use revprio_api::wire::{Axis, ControllerTask, Frame};
use revprio_core::law::ContactSettings;
use revprio_core::surface::SurfaceSettings;
use revprio_local::json::read;
use serde_json::json;

use super::error::CliError;
use super::one_of::one_of;
use super::output::{print_remark, print_text};
use super::range::Range;
use super::service_choice::{CalledService, server_address};
use super::target::Target;

/// Beginnings of the places in the body, and the options that they come from.
const OPTIONS: [(&str, &str); 9] = [
    ("/robot", "--robot, or --server for the robots of a service"),
    ("/period_s", "--period-s"),
    ("/drive/lag_s", "--lag-s"),
    ("/drive/delay_periods", "--delay-periods"),
    ("/tasks/0/law/target_force", "--newtons"),
    ("/tasks/0/law/approach_speed", "--approach-speed"),
    ("/tasks/0/law/stiffest", "--stiffest"),
    ("/tasks/0/law/max_force", "--max-force"),
    ("/tasks/0/law/surface", "--max-tilt-rad"),
];

/// Way of `wipe`.
const STROKE: Range = Range { option: "--stroke-m", unit: "m", lowest: 1e-4, highest: 10.0 };

/// Speed of `wipe`.
const SPEED: Range = Range { option: "--speed", unit: "m/s", lowest: 1e-5, highest: 2.0 };

/// Tilt of the surface of `wipe`.
const TILT: Range = Range { option: "--max-tilt-rad", unit: "rad", lowest: 1e-3, highest: SurfaceSettings::MOST_TILT };

/// Force and arm of both commands.
#[derive(Debug, clap::Args)]
struct Press {
    /// Axis along which the tool presses
    #[arg(long, value_parser = one_of(&Axis::ALL))]
    axis: Axis,
    /// Target force on the environment, N, or N·m for an axis of rotation, up to 2000; its sign is the direction in which the tool
    /// presses
    #[arg(long)]
    newtons: f64,
    /// Name of a built-in robot, or of a robot of the service at --server
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
    /// Speed of the approach, m/s or rad/s, up to 2; if left out, the largest that keeps 1.2 times the force
    #[arg(long)]
    approach_speed: Option<f64>,
    /// Stiffness of the stiffest contact, N/m or N·m/rad, up to 1e8; if left out, 1e6 N/m
    #[arg(long)]
    stiffest: Option<f64>,
    /// Force at which the tool leaves, N or N·m, up to 10000; if left out, none
    #[arg(long)]
    max_force: Option<f64>,
    /// Service that checks the controller, for example http://127.0.0.1:8080; if left out, the command checks it
    #[arg(long, value_parser = server_address)]
    server: Option<String>,
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

    /// Refuses numbers that no arm has.
    fn check_sizes(&self) -> Result<(), CliError> {
        let is_angular = matches!(self.axis, Axis::Rx | Axis::Ry | Axis::Rz);
        let range = |option, units: [&'static str; 2], lowest, highest| Range {
            option,
            unit: units[usize::from(is_angular)],
            lowest,
            highest,
        };
        let softest = ContactSettings::of(is_angular).softest;
        let given = [
            (self.approach_speed, range("--approach-speed", ["m/s", "rad/s"], 1e-5, 2.0)),
            (self.stiffest, range("--stiffest", ["N/m", "N·m/rad"], softest, 1e8)),
            (self.max_force, range("--max-force", ["N", "N·m"], 1e-3, 1e4)),
        ];
        range("--newtons", ["N", "N·m"], 1e-3, 2000.0).check_magnitude(self.newtons)?;
        check_finite("--period-s", self.period_s)?;
        check_finite("--lag-s", self.lag_s)?;
        given.iter().try_for_each(|(value, range)| value.map_or(Ok(()), |value| range.check(value)))
    }

    /// Prints the body of `POST /v1/controllers`, if the service accepts it.
    fn print(&self, tasks: &[ControllerTask]) -> Result<(), CliError> {
        let drive = json!({"lag_s": self.lag_s, "delay_periods": self.delay_periods});
        let body = json!({"robot": self.robot, "period_s": self.period_s, "drive": drive, "tasks": tasks});
        let body = format!("{body:#}\n");
        self.check(&body)?;
        Ok(print_text(body)?)
    }

    /// Creates the controller and prints its warnings. The session for this check is closed at once.
    fn check(&self, body: &str) -> Result<(), CliError> {
        let unread = |problem| ClientError::Refused { url: "the service".to_owned(), problem: Box::new(problem) };
        let controller = read(body.as_bytes()).map_err(|error| named(unread(error.into_wire())))?;
        let service = match &self.server {
            Some(url) => CalledService::Http(Target::open(Some(url))?),
            None => CalledService::in_process(None)?,
        };
        let created = service.calls().create_controller(&controller).map_err(named)?;
        service.calls().delete_controller(&created.id)?;
        for warning in created.warnings {
            print_remark(format_args!("warning: {warning}"));
        }
        Ok(())
    }
}

/// Refuses a number that JSON cannot represent. The service refuses other numbers itself.
fn check_finite(option: &str, value: f64) -> Result<(), CliError> {
    let refusal =
        || CliError::Option { option: option.to_owned(), detail: format!("give a finite number, not {value}") };
    value.is_finite().then_some(()).ok_or_else(refusal)
}

/// Names the option that a refused field comes from.
fn named(error: ClientError) -> CliError {
    let ClientError::Refused { problem, .. } = &error else { return error.into() };
    let place = problem.pointer.as_deref().unwrap_or_default();
    match OPTIONS.iter().find(|(begin, _)| place.starts_with(begin)) {
        Some((_, option)) => CliError::Option { option: (*option).to_owned(), detail: problem.detail.clone() },
        None => error.into(),
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
    /// Way from the start along this axis and back, m, up to 10; negative: the other direction
    #[arg(long, default_value_t = 0.1)]
    stroke_m: f64,
    /// Largest speed of the motion, m/s, up to 2
    #[arg(long, default_value_t = 0.05)]
    speed: f64,
    /// Time of the states at which the motion begins, s. Give it if the tasks replace others while the arm moves, or if the first state
    /// has another time than 0: the arm would else catch up with the motion, faster than --speed
    #[arg(long, default_value_t = 0.0)]
    start_time_s: f64,
    /// Largest tilt of a surface of unknown direction, whose normal the axes follow, rad, up to 1.4; if left out, they stay. The motion
    /// begins at --start-time-s: start the arm in touch
    #[arg(long)]
    max_tilt_rad: Option<f64>,
}

pub fn run_push(options: &PushOptions) -> Result<(), CliError> {
    let press = &options.press;
    press.check_sizes()?;
    press.print(&push(press.axis, press.newtons, &press.options())?)
}

pub fn run_wipe(options: &SweepOptions) -> Result<(), CliError> {
    let SweepOptions { press, along, stroke_m, speed, start_time_s, max_tilt_rad } = options;
    press.check_sizes()?;
    STROKE.check_magnitude(*stroke_m)?;
    SPEED.check(*speed)?;
    check_finite("--start-time-s", *start_time_s)?;
    max_tilt_rad.map_or(Ok(()), |tilt| TILT.check(tilt))?;
    let wiping = WipeOptions {
        press: press.options(),
        stroke_m: *stroke_m,
        speed: *speed,
        start_time_s: *start_time_s,
        frame: Frame::Base,
        max_tilt_rad: *max_tilt_rad,
    };
    press.print(&wipe(press.axis, press.newtons, *along, &wiping)?)
}
