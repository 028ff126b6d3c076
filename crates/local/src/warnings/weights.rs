//! The warning that the position of a first task gives way to its orientation.

use revprio_core::controller::{Command, Controller};

/// Linear velocity that a task may request at rest, m/s. Less is a few millimetres at usual gains.
const AT_TARGET: f64 = 0.01;

/// Factor by which the requested linear velocity must outweigh the angular one, which counts L m/s per rad/s.
const OUTWEIGHS: f64 = 3.0;

/// Adds the warning, if the first task makes no progress: what it still requests then tells what it gave up.
pub fn warn(warnings: &mut Vec<String>, controller: &Controller, command: &Command) {
    let config = controller.config();
    if !command.stuck.iter().any(|stuck| stuck.task == 0) {
        return;
    }
    let (task, requested) = (&config.tasks[0], &command.targets[0].velocity);
    let part = |angular: bool| {
        let kind = |&row: &usize| task.rows.is_angular(row, &config.robot) == Some(angular);
        let rows: Vec<usize> = (0..task.rows.len()).filter(kind).collect();
        (!rows.is_empty()).then(|| rows.iter().map(|&row| requested[row].powi(2)).sum::<f64>().sqrt())
    };
    let (Some(linear), Some(angular)) = (part(false), part(true)) else { return };
    let length = config.characteristic_length_m;
    if linear > AT_TARGET && linear > OUTWEIGHS * length * angular {
        warnings.push(format!(
            "task `{}` keeps its orientation rather than its position: it makes no progress, and still requests {linear:.3} m/s \
             and {angular:.3} rad/s. If the position matters more, set a smaller `characteristic_length_m` than {length}, or \
             move the angular rows to a task below it",
            task.name
        ));
    }
}
