//! The service as one run sees it.

use super::run::CallMode;
use crate::client::{Client, ClientError};
use crate::wire;

/// The service, in a session or not.
pub enum Caller<'a> {
    Session { client: &'a Client, id: String },
    Stateless { client: &'a Client, request: Box<wire::StepRequest> },
}

impl<'a> Caller<'a> {
    /// Opens a session, if there is to be one.
    pub fn open(controller: &wire::Controller, client: &'a Client, mode: CallMode) -> Result<Self, ClientError> {
        match mode {
            CallMode::Session => Ok(Self::Session { client, id: client.create_controller(controller)?.id }),
            CallMode::Stateless => {
                let nothing = wire::State {
                    sequence: 0,
                    time_s: 0.0,
                    joint_position: Vec::new().into(),
                    joint_velocity: None,
                    wrench: None,
                };
                let request = wire::StepRequest { controller: controller.clone(), state: nothing, memory: None };
                Ok(Self::Stateless { client, request: Box::new(request) })
            }
        }
    }

    /// Asks for one step.
    pub fn call(&mut self, state: wire::State) -> Result<wire::StepAnswer, ClientError> {
        match self {
            Self::Session { client, id } => client.step_controller(id, &state),
            Self::Stateless { client, request } => {
                request.state = state;
                client.step(request)
            }
        }
    }

    /// Keeps the memory of an answer that arrived, for the next call.
    pub fn keep_memory(&mut self, answer: &mut wire::StepAnswer) {
        if let Self::Stateless { request, .. } = self {
            request.memory = answer.memory.take();
        }
    }
}

impl Drop for Caller<'_> {
    /// Ends the session, after a failure too; if that fails, the service ends it by itself.
    fn drop(&mut self) {
        if let Self::Session { client, id } = self {
            let _ = client.delete_controller(id);
        }
    }
}
