//! The calls of a control loop, whoever answers them.

use crate::client::{Client, ClientError};
use crate::wire;

/// A service that computes commands: over HTTP ([`Client`]) or in the same process.
pub trait Service {
    /// Opens a session. `POST /v1/controllers`
    fn create_controller(&self, controller: &wire::Controller) -> Result<wire::CreatedController, ClientError>;

    /// Steps a session. `POST /v1/controllers/{id}/step`
    fn step_controller(&self, id: &str, state: &wire::State) -> Result<wire::StepAnswer, ClientError>;

    /// Ends a session. `DELETE /v1/controllers/{id}`
    fn delete_controller(&self, id: &str) -> Result<(), ClientError>;

    /// Steps a controller whose memory travels with the request. `POST /v1/step`
    fn step(&self, request: &wire::StepRequest) -> Result<wire::StepAnswer, ClientError>;
}

impl Service for Client {
    fn create_controller(&self, controller: &wire::Controller) -> Result<wire::CreatedController, ClientError> {
        self.post("/v1/controllers", controller)
    }

    fn step_controller(&self, id: &str, state: &wire::State) -> Result<wire::StepAnswer, ClientError> {
        self.post(&format!("/v1/controllers/{id}/step"), state)
    }

    fn delete_controller(&self, id: &str) -> Result<(), ClientError> {
        self.delete(&format!("/v1/controllers/{id}"))
    }

    fn step(&self, request: &wire::StepRequest) -> Result<wire::StepAnswer, ClientError> {
        self.post("/v1/step", request)
    }
}
