//! A caller that keeps the controller's memory itself, and so can change the controller while the arm moves.

use revprio_api::wire;
use revprio_api::{ClientError, Service};

use super::operator::Cycle;

/// Simulated time in which one method gives way to another, s: some periods of an arm's motion, short for a force.
const FADING_S: f64 = 0.1;

/// Calls `POST /v1/step`.
pub struct Stateless<'a> {
    service: &'a dyn Service,
    /// The last one, with the memory for the next.
    request: wire::StepRequest,
    /// The memory that the last one was sent with.
    sent_memory: Option<wire::Memory>,
    /// J_k q̇ of each task in the last answer.
    achieved: Vec<Vec<f64>>,
    fading: Option<Fading>,
    /// Comes when the change before it is done.
    waiting: Option<wire::Controller>,
}

/// A controller that gives way.
struct Fading {
    request: wire::StepRequest,
    done: f64,
    periods: f64,
}

impl<'a> Stateless<'a> {
    /// Nothing is remembered yet.
    pub fn new(service: &'a dyn Service, controller: wire::Controller) -> Self {
        let nothing = wire::State {
            sequence: 0,
            time_s: 0.0,
            joint_position: Vec::new().into(),
            joint_velocity: None,
            wrench: None,
        };
        let request = wire::StepRequest { controller, state: nothing, memory: None };
        Self { service, request, sent_memory: None, achieved: Vec::new(), fading: None, waiting: None }
    }

    /// Asks for the command of a period.
    pub fn call(&mut self, state: wire::State) -> Result<wire::StepAnswer, ClientError> {
        if self.fading.as_ref().is_some_and(|fading| fading.done >= fading.periods) {
            self.fading = None;
            if let Some(waiting) = self.waiting.take() {
                self.change(waiting);
            }
        }
        let (mut answer, sent_memory) = ask(self.service, &mut self.request, state.clone())?;
        self.sent_memory = sent_memory;
        self.achieved.clear();
        self.achieved.extend(answer.tasks.iter().map(|task| task.achieved.clone()));
        if let Some(fading) = &mut self.fading {
            fading.mix_into(&mut answer, self.service, state)?;
            // Acceleration limits count from what the arm was really told.
            for request in [&mut self.request, &mut fading.request] {
                if let Some(memory) = &mut request.memory {
                    memory.last_command.clone_from(&answer.joint_velocity);
                }
            }
        }
        Ok(answer)
    }

    /// What the last call asked.
    pub fn cycle(&self) -> Cycle<'_> {
        let wire::StepRequest { controller, state, .. } = &self.request;
        Cycle { controller, state, memory: self.sent_memory.as_ref() }
    }

    /// The last answer did not arrive, and so neither did its memory.
    pub fn lose(&mut self) {
        self.request.memory = self.sent_memory.clone();
    }

    /// The controller from the next period on, with the same rows as the one before.
    ///
    /// Its integrators go on from the velocities that were achieved, not from those that were asked for in vain. Laws
    /// integrate accelerations and so do not jump; methods may differ, so for a while both are asked and mixed.
    pub fn change(&mut self, controller: wire::Controller) {
        if self.fading.is_some() {
            self.waiting = Some(controller);
            return;
        }
        let now = &self.request.controller;
        if (now.method, now.solver) != (controller.method, controller.solver) && self.request.memory.is_some() {
            let periods = (FADING_S / now.period_s).ceil();
            self.fading = Some(Fading { request: self.request.clone(), done: 0.0, periods });
            if let Some(memory) = &mut self.request.memory {
                memory.task_velocities.clone_from(&self.achieved);
                // A first guess for the solver, of another problem.
                memory.active_set.clear();
            }
        }
        self.request.controller = controller;
    }
}

impl Fading {
    /// Mixes the command of the controller that gives way into the other one's. What is inside the limits stays so: they
    /// are the same for both.
    fn mix_into(
        &mut self,
        answer: &mut wire::StepAnswer,
        service: &dyn Service,
        state: wire::State,
    ) -> Result<(), ClientError> {
        let (before, _) = ask(service, &mut self.request, state)?;
        self.done += 1.0;
        let share = self.done / self.periods;
        for (velocity, before) in answer.joint_velocity.iter_mut().zip(before.joint_velocity) {
            *velocity = before + share * (*velocity - before);
        }
        Ok(())
    }
}

/// The answer, and the memory that the question was sent with.
fn ask(
    service: &dyn Service,
    request: &mut wire::StepRequest,
    state: wire::State,
) -> Result<(wire::StepAnswer, Option<wire::Memory>), ClientError> {
    request.state = state;
    let mut answer = service.step(request)?;
    let sent = std::mem::replace(&mut request.memory, answer.memory.take());
    Ok((answer, sent))
}
