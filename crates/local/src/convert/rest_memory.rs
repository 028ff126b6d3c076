//! How the joints turn and what the tasks gained, in the memory of stateless steps.

use revprio_api::wire;
use revprio_core::controller::{ControllerConfig, JointTurns, RestState, TaskGain};

use super::checks::{Result, each, foreign};
use super::numbers::{check_numbers, number, time};
use super::target_memory::{value, value_answer};

/// Reads the state. The controller checks its ranges.
pub fn rest_state(rest: &wire::RestState, config: &ControllerConfig) -> Result<RestState> {
    let mut tasks = vec![None; config.tasks.len()];
    for (task, gain) in each::<_, _, Vec<_>>("/tasks", &rest.tasks, |_, gain| task_gain(gain, config))? {
        tasks[task] = Some(gain);
    }
    Ok(RestState {
        spent: number(rest.spent, "/spent")?,
        exhausted: rest.exhausted,
        fading_since_s: rest.fading_since_s.map(|since| time(since, "/fading_since_s")).transpose()?,
        joints: each("/joints", &rest.joints, |_, turns| joint_turns(turns))?,
        tasks,
    })
}

fn joint_turns(turns: &wire::JointTurns) -> Result<JointTurns> {
    let wire::JointTurns { velocity, falls, position, repeats } = *turns;
    check_numbers(&velocity, "/velocity")?;
    check_numbers(position.as_ref().map_or(&[], |position| position), "/position")?;
    Ok(JointTurns { velocity, falls, position, repeats })
}

fn task_gain(gain: &wire::TaskGain, config: &ControllerConfig) -> Result<(usize, TaskGain)> {
    let task = config.tasks.iter().position(|task| task.name == gain.task);
    let task = task.ok_or_else(|| foreign("/task", "not a task of this controller"))?;
    let target = value(gain.pose.as_ref(), gain.values.as_deref())?;
    Ok((task, TaskGain { least: number(gain.least, "/least")?, target }))
}

/// Returns the state as a part of an answer.
pub fn rest_state_answer(rest: &RestState, config: &ControllerConfig) -> wire::RestState {
    let joint = |turns: &JointTurns| {
        let JointTurns { velocity, falls, position, repeats } = *turns;
        wire::JointTurns { velocity, falls, position, repeats }
    };
    let task = |(k, gain): (usize, &Option<TaskGain>)| {
        let TaskGain { least, target } = gain.as_ref()?;
        let (pose, values) = value_answer(target);
        Some(wire::TaskGain { task: config.tasks[k].name.clone(), least: *least, pose, values })
    };
    wire::RestState {
        spent: rest.spent,
        exhausted: rest.exhausted,
        fading_since_s: rest.fading_since_s,
        joints: rest.joints.iter().map(joint).collect(),
        tasks: rest.tasks.iter().enumerate().filter_map(task).collect(),
    }
}
