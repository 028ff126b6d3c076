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
    /// Service to ask, such as http://127.0.0.1:8080; one of its own if left out
    #[arg(long, conflicts_with = "robot")]
    server: Option<String>,
    /// The arm of the recording, if it is one of your own
    #[arg(long, value_name = RobotArgument::SYNTAX, long_help = RobotArgument::HELP)]
    robot: Option<RobotArgument>,
    /// Largest difference of a number that counts as none
    #[arg(long, default_value_t = 0.0)]
    tolerance: f64,
    /// Let the controller's memory travel with every request instead of keeping a session
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
    let tell = |what: &str, difference: &Option<Difference>| match difference {
        None => Ok(()),
        Some(Difference { period, time_s, column, recorded, answered }) => writeln!(
            stdout(),
            "{what}: {column} in period {period} (t = {time_s} s): recorded {}, answered {}",
            shown(recorded),
            shown(answered)
        ),
    };
    tell("first difference", first)?;
    tell("worst difference", worst)?;
    Ok(())
}

fn shown(value: &Value) -> String {
    if *value == Value::Missing { "nothing".to_owned() } else { cell_text(value.clone()) }
}
