//! `revprio replay`

use std::ops::ControlFlow;
use std::path::PathBuf;

use revprio_lab::simulator::CallMode;
use revprio_lab::simulator::recording::{Value, cell_text, read};
use revprio_lab::simulator::replay::{Difference, Replay, replay};

use super::error::CliError;
use super::finite::not_negative;
use super::output::print_text;
use super::progress_bar::progress_bar;
use super::robot::RobotArgument;
use super::service_choice::server_address;
use super::target::Target;
use crate::service::Robots;

#[derive(Debug, clap::Args)]
pub struct Options {
    /// A recording: .csv, .jsonl, .parquet or .mcap
    file: PathBuf,
    /// Service to call, for example http://127.0.0.1:8080, with the token in the file `REVPRIO_TOKEN_FILE` if that is set; if
    /// left out, the command starts its own
    #[arg(long, conflicts_with = "robot", value_parser = server_address)]
    server: Option<String>,
    /// Robot of the recording, if it is your own
    #[arg(long, value_name = RobotArgument::SYNTAX, long_help = RobotArgument::HELP)]
    robot: Option<RobotArgument>,
    /// Tolerance for differences of numbers
    #[arg(long, default_value_t = 0.0, value_parser = not_negative, allow_negative_numbers = true)]
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
    if result.compared == 0 {
        return Err(CliError::NothingRecorded { path: options.file.clone() });
    }
    if result.differing > 0 { Err(CliError::Differs { answers: result.differing }) } else { Ok(()) }
}

fn print(result: &Replay) -> Result<(), CliError> {
    let Replay { periods, compared, differing, first, worst } = result;
    print_text(format_args!("{periods} states sent, {compared} answers compared, {differing} differ\n"))?;
    for (what, difference) in [("first difference", first), ("worst difference", worst)] {
        let Some(Difference { period, time_s, column, recorded, answered }) = difference else { continue };
        let [recorded, answered] = [recorded, answered].map(shown);
        print_text(format_args!(
            "{what}: {column} in period {period} (t = {time_s} s): recorded {recorded}, answered {answered}\n"
        ))?;
    }
    Ok(())
}

fn shown(value: &Value) -> String {
    if *value == Value::Missing { "nothing".to_owned() } else { cell_text(value.clone()) }
}
