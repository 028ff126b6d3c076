//! The measured wrenches of a state.

use revprio_api::wire;
use revprio_core::controller::{Controller, TipWrench};
use revprio_core::rows::TaskRows;

use super::checks::{Inside, Result, check};
use super::numbers::check_numbers;
use crate::error::{ApiError, escape_pointer};

/// Reads the wrench at the tool; zero if it is not given and no law needs it.
pub fn tool(state: &wire::State, controller: &Controller) -> Result<[f64; 6]> {
    check_names(state, controller)?;
    let name = &controller.config().robot.tips()[0].name;
    let (given, pointer) = match (&state.wrench, state.wrenches.get(name)) {
        (Some(_), Some(_)) => {
            let reason = format!("`wrench` is that of the tip `{name}` too; give one of them");
            return Err(ApiError::invalid(place(name), reason));
        }
        (Some(given), None) => (given, "/wrench".to_owned()),
        (None, Some(given)) => (given, place(name)),
        (None, None) => return needed_by(controller, 0).map_or(Ok([0.0; 6]), |needs| missing("/wrench", &needs)),
    };
    six(given).inside(&pointer)
}

/// Reads the wrenches at the tips other than the tool.
pub fn other_tips(state: &wire::State, controller: &Controller) -> Result<Vec<TipWrench>> {
    let tips = controller.config().robot.tips();
    let mut wrenches = Vec::new();
    for (index, tip) in tips.iter().enumerate().skip(1) {
        match (state.wrenches.get(&tip.name), needed_by(controller, index)) {
            (Some(given), _) => {
                let wrench = six(given).inside(&place(&tip.name))?;
                wrenches.push(TipWrench { tip: index, wrench });
            }
            (None, Some(needs)) => return missing(&place(&tip.name), &needs),
            (None, None) => {}
        }
    }
    Ok(wrenches)
}

/// Refuses a wrench of no tip.
fn check_names(state: &wire::State, controller: &Controller) -> Result<()> {
    let tips = controller.config().robot.tips();
    for name in state.wrenches.keys() {
        let names = || tips.iter().map(|tip| tip.name.as_str()).collect::<Vec<_>>().join("`, `");
        let is_known = tips.iter().any(|tip| tip.name == *name);
        check(is_known, &place(name), format_args!("the robot has no such tip; it has `{}`", names()))?;
    }
    Ok(())
}

fn place(tip: &str) -> String {
    format!("/wrenches/{}", escape_pointer(tip))
}

/// Returns what needs the wrench at a tip: the first task whose law reads it, or a sensor that is stated.
fn needed_by(controller: &Controller, tip: usize) -> Option<String> {
    let config = controller.config();
    let reads = |rows: &TaskRows| matches!(rows, TaskRows::Tool(rows) if rows.frame.tip(&config.robot) == Some(tip));
    let task = config.tasks.iter().find(|task| task.law.reads_wrench() && reads(&task.rows));
    let is_stated = config.wrench_sensors.iter().any(|sensor| sensor.tip == tip);
    let sensor = is_stated.then(|| "the wrench sensor of the controller".to_owned());
    task.map(|task| format!("the law of task `{}`", task.name)).or(sensor)
}

fn missing<T>(pointer: &str, needs: &str) -> Result<T> {
    Err(ApiError::invalid(pointer, format!("{needs} needs the wrench")))
}

/// Returns force and torque as six numbers. Pointers begin at the wrench.
pub fn six(wrench: &wire::Wrench) -> Result<[f64; 6]> {
    let wire::Wrench { force: [fx, fy, fz], torque: [tx, ty, tz] } = *wrench;
    check_numbers(&wrench.force, "/force")?;
    check_numbers(&wrench.torque, "/torque")?;
    Ok([fx, fy, fz, tx, ty, tz])
}
