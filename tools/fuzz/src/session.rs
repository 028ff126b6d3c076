//! The target `controller`: a session.

use std::collections::BTreeMap;

use revprio_api::wire::{Controller, CreatedController, State, StepAnswer, StepRequest};

use crate::answers::{command, problem, value};
use crate::budget::Work;
use crate::timed_service::{Format, TimedService, accepted};
use crate::{Defect, limits};

/// Maximum number of states that a session gets.
const MAX_STEPS: usize = 16;

/// Opens a session with the controller in the first line, sends the states in the others, and ends the session.
pub fn check(service: &TimedService, input: &[u8]) -> Result<(), Defect> {
    let mut lines = input.split(|byte| *byte == b'\n');
    let controller = lines.next().unwrap_or_default();
    let request = Format::Json.read::<Controller>(controller);
    let answer = service.post("/v1/controllers", controller, Work::default())?;
    let Some(created) = value::<CreatedController>(&answer, false)? else { return Ok(()) };
    let request = accepted(request)?;
    let step = StepRequest { controller: request, state: default_state(created.joints.len()), memory: None };
    let limits = limits::of_controller(&step.controller);
    let work = Work::of_step(&step);
    let path = format!("/v1/controllers/{}", created.id);
    let mut states: Vec<Vec<u8>> = lines.take(MAX_STEPS).map(<[u8]>::to_vec).collect();
    if states.is_empty() {
        states.push(serde_json::to_vec(&step.state).unwrap_or_default());
    }
    for state in states {
        let answer = service.post(&format!("{path}/step"), &state, work)?;
        if let Some(answer) = value::<StepAnswer>(&answer, work.exceeds_arm())? {
            command(&answer, limits.as_ref())?;
        }
    }
    let answer = service.untimed().delete(&path)?;
    if answer.status == 204 { Ok(()) } else { problem(&answer.body, Some(204), false) }
}

/// A state at the middle of the ranges of most arms.
fn default_state(joints: usize) -> State {
    State {
        channels: BTreeMap::new(),
        wrenches: BTreeMap::new(),
        obstacles: Vec::new(),
        sequence: 1,
        time_s: 0.0,
        joint_position: vec![0.3; joints].into(),
        joint_velocity: None,
        wrench: None,
        targets: BTreeMap::new(),
    }
}
