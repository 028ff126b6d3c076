//! A caller that keeps the memory of the controller itself, so that it can change the controller during a run.

use std::collections::BTreeMap;

use revprio_api::wire;
use revprio_api::{ClientError, Service};

use super::callee::Callee;

/// Simulated time over which the command is blended from one method to another, s. It is short compared with the motion of
/// a force-controlled tool.
const BLEND_S: f64 = 0.1;

/// Input of a stateless step.
#[derive(Debug, Clone, Copy)]
pub struct Cycle<'a> {
    /// The controller.
    pub controller: &'a wire::Controller,
    /// The measured state.
    pub state: &'a wire::State,
    /// The memory of the previous period.
    pub memory: Option<&'a wire::Memory>,
}

impl Cycle<'_> {
    /// Returns the step as a request.
    pub fn request(&self) -> wire::StepRequest {
        wire::StepRequest {
            controller: self.controller.clone(),
            state: self.state.clone(),
            memory: self.memory.cloned(),
        }
    }
}

/// Calls `POST /v1/step`.
pub struct Stateless<'a> {
    service: Callee<'a>,
    /// The last request, with the memory for the next one.
    request: wire::StepRequest,
    /// The memory with which the last request was sent.
    sent_memory: Option<wire::Memory>,
    /// Achieved velocity J_k q̇ of each task in the last answer.
    achieved: Vec<Vec<f64>>,
    blend: Option<Blend>,
    /// Controller that follows after the blend.
    pending: Option<wire::Controller>,
}

/// The previous controller during a blend.
struct Blend {
    request: wire::StepRequest,
    /// Completed periods of the blend.
    done: f64,
    /// Length of the blend, periods.
    periods: f64,
}

impl<'a> Stateless<'a> {
    /// Returns a caller without memory.
    pub fn new(service: Callee<'a>, controller: wire::Controller) -> Self {
        let nothing = wire::State {
            channels: BTreeMap::new(),
            wrenches: BTreeMap::new(),
            obstacles: Vec::new(),
            sequence: 0,
            time_s: 0.0,
            joint_position: Vec::new().into(),
            joint_velocity: None,
            wrench: None,
            targets: BTreeMap::new(),
        };
        let request = wire::StepRequest { controller, state: nothing, memory: None };
        Self { service, request, sent_memory: None, achieved: Vec::new(), blend: None, pending: None }
    }

    /// Requests the command of a period.
    pub fn call(&mut self, state: wire::State) -> Result<wire::StepAnswer, ClientError> {
        if self.blend.as_ref().is_some_and(|blend| blend.done >= blend.periods) {
            self.blend = None;
            if let Some(pending) = self.pending.take() {
                self.change(pending);
            }
        }
        let (mut answer, sent_memory) = send(&*self.service, &mut self.request, state.clone())?;
        self.sent_memory = sent_memory;
        self.achieved.clear();
        self.achieved.extend(answer.tasks.iter().map(|task| task.achieved.clone()));
        if let Some(blend) = &mut self.blend {
            blend.mix_into(&mut answer, &*self.service, state)?;
            // Acceleration limits refer to the command that the arm really received.
            for request in [&mut self.request, &mut blend.request] {
                if let Some(memory) = &mut request.memory {
                    memory.last_command.clone_from(&answer.joint_velocity);
                }
            }
        }
        Ok(answer)
    }

    /// Returns the input of the last call.
    pub fn cycle(&self) -> Cycle<'_> {
        let wire::StepRequest { controller, state, .. } = &self.request;
        Cycle { controller, state, memory: self.sent_memory.as_ref() }
    }

    /// Restores the memory before the last answer, which did not arrive.
    pub fn discard_answer(&mut self) {
        self.request.memory = self.sent_memory.clone();
    }

    /// Sets the controller from the next period on. It must have the same rows as the previous one.
    ///
    /// If only gains change, the integrators continue: laws integrate accelerations, so their velocities do not jump. If the
    /// method or the solver changes, the integrators start from the achieved velocities, and both controllers are called
    /// for a short time while their commands are blended.
    pub fn change(&mut self, controller: wire::Controller) {
        if self.blend.is_some() {
            self.pending = Some(controller);
            return;
        }
        let now = &self.request.controller;
        if (now.method, now.solver) != (controller.method, controller.solver) && self.request.memory.is_some() {
            let periods = (BLEND_S / now.period_s).ceil();
            self.blend = Some(Blend { request: self.request.clone(), done: 0.0, periods });
            if let Some(memory) = &mut self.request.memory {
                memory.task_velocities.clone_from(&self.achieved);
                // The initial guess belongs to another problem.
                memory.active_set.clear();
            }
        }
        self.request.controller = controller;
    }
}

impl Blend {
    /// Blends the command of the previous controller into the new one. Both have the same limits, so the result keeps them.
    fn mix_into(
        &mut self,
        answer: &mut wire::StepAnswer,
        service: &dyn Service,
        state: wire::State,
    ) -> Result<(), ClientError> {
        let (before, _) = send(service, &mut self.request, state)?;
        self.done += 1.0;
        let share = self.done / self.periods;
        for (velocity, before) in answer.joint_velocity.iter_mut().zip(before.joint_velocity) {
            *velocity = before + share * (*velocity - before);
        }
        Ok(())
    }
}

/// Sends a request. Returns the answer, and the memory with which the request was sent.
fn send(
    service: &dyn Service,
    request: &mut wire::StepRequest,
    state: wire::State,
) -> Result<(wire::StepAnswer, Option<wire::Memory>), ClientError> {
    request.state = state;
    let mut answer = service.step(request)?;
    let sent = std::mem::replace(&mut request.memory, answer.memory.take());
    Ok((answer, sent))
}
