//! Calls to the service, in a session or stateless.

use revprio_api::ClientError;
use revprio_api::wire;

use super::callee::Callee;
use super::stateless::{Cycle, Stateless};

/// Who keeps the controller's memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CallMode {
    /// The service, in a session.
    #[default]
    Session,
    /// The caller, which sends it with every request.
    Stateless,
}

/// The way in which a run calls the service.
pub enum Caller<'a> {
    Session { service: Callee<'a>, id: String },
    Stateless(Box<Stateless<'a>>),
}

impl<'a> Caller<'a> {
    /// Opens a session, if the mode needs one.
    pub fn open(controller: &wire::Controller, service: Callee<'a>, mode: CallMode) -> Result<Self, ClientError> {
        match mode {
            CallMode::Session => {
                let id = service.create_controller(controller)?.id;
                Ok(Self::Session { service, id })
            }
            CallMode::Stateless => Ok(Self::Stateless(Box::new(Stateless::new(service, controller.clone())))),
        }
    }

    /// Sets the controller from the next period on. A session keeps the controller with which it was opened.
    pub fn change(&mut self, controller: wire::Controller) {
        if let Self::Stateless(caller) = self {
            caller.change(controller);
        }
    }

    /// Returns the input of the last call; `None` in a session.
    pub fn cycle(&self) -> Option<Cycle<'_>> {
        match self {
            Self::Session { .. } => None,
            Self::Stateless(caller) => Some(caller.cycle()),
        }
    }

    /// Requests the command of a period.
    pub fn call(&mut self, state: wire::State) -> Result<wire::StepAnswer, ClientError> {
        match self {
            Self::Session { service, id } => service.step_controller(id, &state),
            Self::Stateless(caller) => caller.call(state),
        }
    }

    /// Discards the memory of the last answer, which did not arrive in its period. A session ignores this.
    pub fn discard_answer(&mut self) {
        if let Self::Stateless(caller) = self {
            caller.discard_answer();
        }
    }
}

impl Drop for Caller<'_> {
    /// Ends the session, also after an error. If this fails, the service ends the idle session itself.
    fn drop(&mut self) {
        if let Self::Session { service, id } = self {
            let _ = service.delete_controller(id);
        }
    }
}
