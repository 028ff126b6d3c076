//! `revprio robots`: the robots that the program knows, and what it reads from a robot file.

use revprio_local::warnings;
use revprio_robot::{Joint, RobotModel, VelocityEnvelope, built_in};

use super::error::CliError;
use super::known::known_robot;
use super::output::print_text;
use super::robot::RobotArgument;
use super::text::{WIDTH, columns, wrapped};
use crate::service::{Robots, shapes_answer};

#[derive(Debug, clap::Args)]
pub struct Options {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// List the built-in robots (default)
    List,
    /// Show joints, limits and reach of a built-in robot
    Show {
        /// Name of a built-in robot
        #[arg(value_parser = known_robot())]
        robot: String,
    },
    /// Read a robot file as `serve --robot` does; show what was found, and what the file does not say
    Check {
        #[arg(value_name = RobotArgument::SYNTAX, long_help = RobotArgument::HELP, value_hint = clap::ValueHint::FilePath)]
        robot: RobotArgument,
    },
    /// Print capsules that contain the <collision> elements of a robot file and their meshes, as JSON for an overrides file or POST
    /// /v1/robots
    Fit {
        #[arg(value_name = RobotArgument::SYNTAX, long_help = RobotArgument::HELP, value_hint = clap::ValueHint::FilePath)]
        robot: RobotArgument,
    },
}

pub fn run(options: &Options) -> Result<(), CliError> {
    let text = match options.command.as_ref().unwrap_or(&Command::List) {
        Command::List => list(),
        Command::Show { robot } => {
            built_in().iter().find(|known| known.name() == robot).map(|robot| shown(robot)).unwrap_or_default()
        }
        Command::Check { robot } => {
            let robot = robot.read()?;
            // `serve` refuses a name that is not valid or that of a built-in robot.
            Robots::built_in().with(robot.clone())?;
            shown(&robot) + "\n" + &remarks(&robot) + &shapes(&robot)
        }
        Command::Fit { robot } => {
            let robot = robot.with_fitted_shapes().read()?;
            if let Some(text) = uncovered(&robot) {
                eprintln!("{text}");
            }
            let shape_list = shapes_answer(&robot).map(|shapes| shapes.shape_list).unwrap_or_default();
            format!("{:#}\n", serde_json::json!({ "shape_list": shape_list }))
        }
    };
    Ok(print_text(text)?)
}

fn list() -> String {
    let row = |robot: &RobotModel| {
        vec![
            robot.name().to_owned(),
            robot.joint_count().to_string(),
            format!("{:.2}", robot.reach()),
            known_limits(robot).join(", "),
        ]
    };
    let heading = ["robot", "joints", "reach (m)", "limits"].map(str::to_owned).to_vec();
    let rows: Vec<_> = std::iter::once(heading).chain(built_in().iter().map(|robot| row(robot))).collect();
    columns(&rows, |i| i == 1 || i == 2)
}

/// Returns the kinds of limits that some joint has.
fn known_limits(robot: &RobotModel) -> Vec<&'static str> {
    let has = |limit: fn(&Joint) -> f64| robot.joints().iter().any(|joint| limit(joint).is_finite());
    let kinds = [
        ("position", has(|joint| joint.limits.upper)),
        ("speed", has(|joint| joint.limits.velocity)),
        ("acceleration", has(|joint| joint.limits.acceleration)),
        ("jerk", has(|joint| joint.limits.jerk)),
        ("speed near the ends", has(|joint| joint.limits.envelope.deceleration)),
    ];
    kinds.into_iter().filter_map(|(kind, known)| known.then_some(kind)).collect()
}

/// Returns name, description, joints and reach of a robot.
fn shown(robot: &RobotModel) -> String {
    let heading = ["joint", "kind", "lower", "upper", "speed", "acceleration", "jerk"].map(str::to_owned).to_vec();
    let rows: Vec<_> = std::iter::once(heading).chain(robot.joints().iter().map(row)).collect();
    let description = wrapped(robot.description(), WIDTH).join("\n");
    format!(
        "{}: joints {}, reach {:.3} m\n{description}\n\n{}\nUnits: rad and rad/s for joints that turn, m and m/s for others. \
         –: no limit is known.\n{}",
        robot.name(),
        robot.joint_count(),
        robot.reach(),
        columns(&rows, |i| i > 1),
        envelopes(robot)
    )
}

/// Returns the speed limits of the joints near the ends of their ranges; empty if there are none.
fn envelopes(robot: &RobotModel) -> String {
    let envelope = |joint: &Joint| {
        let VelocityEnvelope { deceleration, offset } = joint.limits.envelope;
        joint.limits.envelope.is_finite().then(|| format!("{} {deceleration}, {offset}", joint.name))
    };
    let joints: Vec<String> = robot.joints().iter().filter_map(envelope).collect();
    if joints.is_empty() {
        return String::new();
    }
    let text = format!(
        "Speed limits near the ends of the range: at the distance d, the speed towards the end is at most √(2 D d) − o. D and o: {}.",
        joints.join("; ")
    );
    wrapped(&text, WIDTH).join("\n") + "\n"
}

fn row(joint: &Joint) -> Vec<String> {
    let number = |value: f64| if value.is_finite() { format!("{value:.4}") } else { "–".to_owned() };
    let limits = &joint.limits;
    let kind = if joint.kind.unit() == "m" { "prismatic" } else { "revolute" };
    let numbers = [limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk].map(number);
    [joint.name.clone(), kind.to_owned()].into_iter().chain(numbers).collect()
}

/// Returns sentences about what a robot file leaves out, and what that means.
fn remarks(robot: &RobotModel) -> String {
    let without = |limit: fn(&Joint) -> f64| {
        let joints = robot.joints().iter().filter(move |joint| !limit(joint).is_finite());
        joints.map(|joint| joint.name.as_str()).collect::<Vec<_>>().join(", ")
    };
    let found = [
        (without(|joint| joint.limits.upper), "no range: these joints turn without end"),
        (
            without(|joint| joint.limits.velocity),
            "no speed limit: commands of these joints are not bounded. State `velocity`",
        ),
        (
            without(|joint| joint.limits.acceleration),
            "no acceleration limit: the speed of these joints may jump, and they brake from full speed in 0.25 s. State \
             `acceleration` in the overrides file, from the data sheet",
        ),
    ];
    let absent = found.iter().filter(|(joints, _)| !joints.is_empty());
    let absent = absent.map(|(joints, text)| format!("{joints}: {text}."));
    let units = warnings::of_description(robot).into_iter().map(|text| format!("warning: {text}"));
    let lines: Vec<_> = units.chain(absent).map(|text| wrapped(&text, WIDTH).join("\n") + "\n").collect();
    if lines.is_empty() { "The file states all limits that a controller needs.\n".to_owned() } else { lines.concat() }
}

/// Returns lines about the tips and the shapes of a robot.
fn shapes(robot: &RobotModel) -> String {
    let mut lines = Vec::new();
    if robot.tips().len() > 1 {
        let tips: Vec<_> = robot.tips().iter().map(|tip| tip.name.as_str()).collect();
        lines.push(format!("Tips, first the tool: {}.", tips.join(", ")));
    }
    if let Some(shapes) = shapes_answer(robot) {
        let (capsules, watched, left_out) = (shapes.shape_list.len(), shapes.watched_pairs, shapes.left_out.len());
        lines.push(format!(
            "Shapes: {capsules} capsules, {watched} pairs of them are watched, {left_out} pairs of links are left out."
        ));
    }
    lines.extend(uncovered(robot));
    lines.iter().map(|line| wrapped(line, WIDTH).join("\n") + "\n").collect()
}

/// Returns a line about the links that no shape covers, if there are any.
fn uncovered(robot: &RobotModel) -> Option<String> {
    let links = robot.collision()?.uncovered();
    (!links.is_empty()).then(|| format!("No shape covers {}: nothing keeps them clear.", links.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_has_every_built_in_robot_and_its_limits() {
        let text = list();
        assert_eq!(text.lines().count(), 1 + built_in().len());
        let sawyer = text.lines().find(|line| line.starts_with("sawyer_dh")).unwrap();
        assert!(sawyer.contains(" 7 ") && sawyer.contains("position, speed, acceleration"), "{sawyer}");
    }

    #[test]
    fn a_robot_is_shown_with_all_joints_and_what_is_not_known() {
        for robot in built_in() {
            let text = shown(robot);
            assert!(robot.joints().iter().all(|joint| text.contains(&joint.name)), "{text}");
            assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
            let complete = robot.joints().iter().all(|joint| {
                joint.limits.acceleration.is_finite()
                    && joint.limits.velocity.is_finite()
                    && joint.limits.upper.is_finite()
            });
            assert_eq!(remarks(robot).contains("all limits"), complete);
            assert_eq!(text.contains("fr3_joint2 2.585, 0.2;"), robot.name() == "fr3", "{text}");
        }
    }
}
