//! `revprio replay`

use std::io::{Write as _, stdout};
use std::ops::ControlFlow;
use std::path::PathBuf;

use revprio_lab::simulator::CallMode;
use revprio_lab::simulator::recording::{Value, cell_text, read};
use revprio_lab::simulator::replay::{Difference, Replay, replay};

use super::robot::RobotArgument;
use super::{CliError, Target, progress_bar};
use crate::service::Robots;

#[derive(Debug, clap::Args)]
pub struct Options {
    /// A recording: .csv, .jsonl, .parquet or .mcap
    file: PathBuf,
    /// Service to call, for example http://127.0.0.1:8080; if left out, the command starts its own
    #[arg(long, conflicts_with = "robot")]
    server: Option<String>,
    /// Robot of the recording, if it is your own
    #[arg(long, value_name = RobotArgument::SYNTAX, long_help = RobotArgument::HELP)]
    robot: Option<RobotArgument>,
    /// Tolerance for differences of numbers
    #[arg(long, default_value_t = 0.0)]
    tolerance: f64,
    /// Send the controller's memory with every request instead of using a session
    #[arg(long)]
    stateless: bool,
}

pub fn run(options: &Options) -> Result<(), CliError> {
    let recording = read(&options.file)
        .map_err(|source| CliError::ReadRecording { path: options.file.clone(), source: Box::new(source) })?;
    let target = match &options.robot {
        Some(robot) => Target::own(Robots::none().with(robot.read()?)?)?,
        None => Target::open(options.server.as_deref())?,
    };
    let mode = if options.stateless { CallMode::Stateless } else { CallMode::Session };
    let bar = progress_bar(recording.samples.len() as u64, &recording.label());
    let result = replay(&recording, &target.client, mode, options.tolerance, |done| {
        bar.set_position(done);
        ControlFlow::Continue(())
    })?;
    bar.finish();
    print(&result)?;
    if result.differing > 0 { Err(CliError::Differs { answers: result.differing }) } else { Ok(()) }
}

fn print(result: &Replay) -> Result<(), CliError> {
    let Replay { periods, compared, differing, first, worst } = result;
    writeln!(stdout(), "{periods} states sent, {compared} answers compared, {differing} differ")?;
    let print_difference = |what: &str, difference: &Option<Difference>| match difference {
        None => Ok(()),
        Some(Difference { period, time_s, column, recorded, answered }) => writeln!(
            stdout(),
            "{what}: {column} in period {period} (t = {time_s} s): recorded {}, answered {}",
            shown(recorded),
            shown(answered)
        ),
    };
    print_difference("first difference", first)?;
    print_difference("worst difference", worst)?;
    Ok(())
}

fn shown(value: &Value) -> String {
    if *value == Value::Missing { "nothing".to_owned() } else { cell_text(value.clone()) }
}
