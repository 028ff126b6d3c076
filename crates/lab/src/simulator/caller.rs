//! The service as one run sees it.

use revprio_api::wire;
use revprio_api::{ClientError, Service};

use super::operator::Cycle;
use super::run::CallMode;
use super::stateless::Stateless;

/// The service, in a session or not.
pub enum Caller<'a> {
    Session { service: &'a dyn Service, id: String },
    Stateless(Box<Stateless<'a>>),
}

impl<'a> Caller<'a> {
    /// Opens a session, if there is to be one.
    pub fn open(controller: &wire::Controller, service: &'a dyn Service, mode: CallMode) -> Result<Self, ClientError> {
        match mode {
            CallMode::Session => Ok(Self::Session { service, id: service.create_controller(controller)?.id }),
            CallMode::Stateless => Ok(Self::Stateless(Box::new(Stateless::new(service, controller.clone())))),
        }
    }

    /// The controller from the next period on; a session keeps the one that it was opened with.
    pub fn change(&mut self, controller: wire::Controller) {
        if let Self::Stateless(caller) = self {
            caller.change(controller);
        }
    }

    /// What the last call asked, where no session keeps the memory.
    pub fn cycle(&self) -> Option<Cycle<'_>> {
        match self {
            Self::Session { .. } => None,
            Self::Stateless(caller) => Some(caller.cycle()),
        }
    }

    /// Asks for the command of a period.
    pub fn call(&mut self, state: wire::State) -> Result<wire::StepAnswer, ClientError> {
        match self {
            Self::Session { service, id } => service.step_controller(id, &state),
            Self::Stateless(caller) => caller.call(state),
        }
    }

    /// The last answer did not arrive when it should; a session does not know.
    pub fn lose(&mut self) {
        if let Self::Stateless(caller) = self {
            caller.lose();
        }
    }
}

impl Drop for Caller<'_> {
    /// Ends the session, after a failure too; if that fails, the service ends it by itself.
    fn drop(&mut self) {
        if let Self::Session { service, id } = self {
            let _ = service.delete_controller(id);
        }
    }
}
