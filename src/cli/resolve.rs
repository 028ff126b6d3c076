//! `revprio resolve`

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use revprio_api::Client;
use revprio_api::wire::{Contradiction, ContradictionMember, ResolveAnswer, ResolveRequest, Status, TaskOutcome};
use revprio_lab::number::{plain, significant};

use super::error::CliError;
use super::output::print_text;
use super::service_choice::server_address;
use super::target::Target;
use super::text::{columns, judged};

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Problem in JSON, as for POST /v1/resolve; `-` reads standard input
    file: PathBuf,
    /// Service to call, for example http://127.0.0.1:8080, with the token in the file `REVPRIO_TOKEN_FILE` if that is set; if
    /// left out, the command starts its own
    #[arg(long, value_parser = server_address)]
    server: Option<String>,
    /// Print the answer as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(options: &Options) -> Result<(), CliError> {
    let request = read(&options.file)?;
    let target = Target::open(options.server.as_deref())?;
    let answer = target.client.resolve(&request)?;
    if options.json {
        let json = serde_json::to_string_pretty(&answer);
        let json = json.map_err(|source| CliError::ParseProblem { path: options.file.clone(), source })?;
        print_text(json + "\n")?;
    } else {
        let joints = joint_names(&target.client, &request, answer.joint_velocity.len())?;
        print_text(describe(&answer, &joints))?;
    }
    Ok(())
}

fn read(path: &Path) -> Result<ResolveRequest, CliError> {
    let text =
        if path == Path::new("-") { std::io::read_to_string(std::io::stdin()) } else { std::fs::read_to_string(path) };
    let text = text.map_err(|source| CliError::ReadProblem { path: path.to_owned(), source })?;
    serde_json::from_str(&text).map_err(|source| CliError::ParseProblem { path: path.to_owned(), source })
}

/// Returns the joint names in the order of the answer, or numbers if the problem names no robot.
fn joint_names(client: &Client, request: &ResolveRequest, joints: usize) -> Result<Vec<String>, CliError> {
    let Some(name) = &request.robot else { return Ok((1..=joints).map(|joint| format!("j{joint}")).collect()) };
    let robots = client.robots()?.robots;
    let robot = robots.into_iter().find(|robot| robot.name == *name);
    Ok(robot.map(|robot| robot.joints.into_iter().map(|joint| joint.name).collect()).unwrap_or_default())
}

/// Returns remarks on a task.
fn remarks(task: &TaskOutcome) -> String {
    let dependent = if task.algorithmic { ", depends on lower tasks" } else { "" };
    let scale = task.scale.map(|scale| format!(", scaled by {}", plain(scale))).unwrap_or_default();
    format!("{dependent}, residual {}{scale}", significant(task.residual_norm, 4))
}

/// Describes demands that contradict each other.
fn describe_contradiction(contradiction: &Contradiction) -> String {
    let member = |member: &ContradictionMember| {
        let ContradictionMember { task, row, joint, inequality, side } = member;
        let name = match (task, row, joint, inequality) {
            (Some(task), Some(row), ..) => format!("row {row} of task `{task}`"),
            (_, _, Some(joint), _) => joint.clone(),
            (.., inequality) => format!("`{}`", inequality.as_deref().unwrap_or_default()),
        };
        format!("{name} {side}")
    };
    let subject = match &contradiction.task {
        Some(task) => format!("the bounds of task `{task}` cannot all be kept"),
        None => "the inequalities cannot all be kept".to_owned(),
    };
    let members: Vec<String> = contradiction.members.iter().map(member).collect();
    format!("{subject}; these contradict each other: {}", members.join(", "))
}

/// Formats the answer as text.
fn describe(answer: &ResolveAnswer, joints: &[String]) -> String {
    let numbers = |values: &[f64]| values.iter().map(|v| format!("{v:>12.6}")).collect::<Vec<_>>().concat();
    let velocity = |(name, velocity): (&String, &f64)| vec![name.clone(), format!("{velocity:.6}")];
    let head = vec!["joint".to_owned(), "velocity (rad/s, m/s)".to_owned()];
    let rows: Vec<_> = std::iter::once(head).chain(joints.iter().zip(&answer.joint_velocity).map(velocity)).collect();
    let mut text = columns(&rows, |i| i == 1);
    for task in &answer.tasks {
        let _ = writeln!(text, "\ntask `{}`, rank {}{}", task.name, task.rank, remarks(task));
        let _ = writeln!(text, "  requested     {}", numbers(&task.requested));
        let _ = writeln!(text, "  achieved      {}", numbers(&task.achieved));
        for active in &task.active_rows {
            let _ = writeln!(
                text,
                "  row {} at its {} bound, multiplier {}",
                active.row,
                active.side,
                significant(active.multiplier, 4)
            );
        }
    }
    if !(answer.active_limits.is_empty() && answer.active_inequalities.is_empty()) {
        let _ = writeln!(text, "\nactive limits");
    }
    for limit in &answer.active_limits {
        let (value, multiplier) = (plain(limit.value), significant(limit.multiplier, 4));
        let _ = writeln!(text, "  {} {} {value}, multiplier {multiplier}", limit.joint, limit.side);
    }
    for inequality in &answer.active_inequalities {
        let (bound, multiplier) = (plain(inequality.bound), significant(inequality.multiplier, 4));
        let _ = writeln!(text, "  `{}` {bound}, multiplier {multiplier}", inequality.name);
    }
    if !(answer.violated_limits.is_empty() && answer.violated_inequalities.is_empty()) {
        let _ = writeln!(text, "\nexceeded limits");
    }
    for limit in &answer.violated_limits {
        let _ = writeln!(text, "  {} {} {}: {}", limit.joint, limit.side, plain(limit.limit), plain(limit.value));
    }
    for inequality in &answer.violated_inequalities {
        let _ = writeln!(text, "  `{}` {}: {}", inequality.name, plain(inequality.bound), plain(inequality.value));
    }
    for contradiction in &answer.contradictions {
        let _ = writeln!(text, "\n{}", describe_contradiction(contradiction));
    }
    for joint in &answer.limit_conflict {
        let _ = writeln!(
            text,
            "\n{joint}: the acceleration limit conflicts with the position or velocity limit, which takes precedence"
        );
    }
    for (i, sentence) in answer.why.iter().enumerate() {
        let _ = writeln!(text, "{}{sentence}", if i == 0 { "\n" } else { "" });
    }
    for warning in &answer.warnings {
        let _ = writeln!(text, "\nwarning: {warning}");
    }
    let solver = &answer.solver;
    let residual = solver.kkt_residual.map_or_else(|| "none".to_owned(), |residual| significant(residual, 2));
    let is_optimal = solver.status == Status::Optimal;
    let uncertain = if solver.rank_uncertain { ", rank uncertain" } else { "" };
    let _ = writeln!(
        text,
        "\nsolved by {}, {}, KKT residual {residual}{uncertain}",
        solver.path,
        judged(solver.status, is_optimal)
    );
    let singularity = &answer.singularity;
    let _ = writeln!(
        text,
        "smallest singular value {}, manipulability {}, algorithmic singularity: {}",
        plain(singularity.smallest_singular_value),
        plain(singularity.manipulability),
        if singularity.algorithmic { "yes" } else { "no" }
    );
    if let Some(index) = answer.joint_limit_index {
        let _ = writeln!(
            text,
            "joint-limit index H {}: 0 with all joints in the middle, 0.5 with all at an end",
            plain(index)
        );
    }
    text
}
