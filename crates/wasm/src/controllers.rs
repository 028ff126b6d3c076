//! Sessions of the page.

use std::collections::BTreeMap;

use revprio_api::wire;
use revprio_local::{ApiError, LocalController, LocalService};

/// Maximum number of open sessions.
const MAX_OPEN: usize = 64;

/// Idle timeout in answers: a year, because sessions end with the page.
const NEVER_S: u64 = 365 * 24 * 3600;

/// The open sessions by their number.
#[derive(Default)]
pub struct Controllers {
    open: BTreeMap<u64, LocalController>,
    count: u64,
}

impl Controllers {
    /// Opens a session.
    pub fn open(&mut self, local: &LocalService, body: &[u8]) -> Result<wire::CreatedController, ApiError> {
        if self.open.len() >= MAX_OPEN {
            return Err(ApiError::too_many_sessions(MAX_OPEN));
        }
        let controller = local.controller(body)?;
        self.count += 1;
        let created = created(self.count.to_string(), &controller);
        self.open.insert(self.count, controller);
        Ok(created)
    }

    /// Replaces the controller of a session.
    pub fn replace(
        &mut self,
        local: &LocalService,
        id: &str,
        body: &[u8],
    ) -> Result<wire::CreatedController, ApiError> {
        let controller = self.get(id)?;
        local.replace(controller, body)?;
        Ok(created(id.to_owned(), controller))
    }

    /// Computes the answer to a state.
    pub fn step(&mut self, id: &str, state: &wire::State) -> Result<wire::StepAnswer, ApiError> {
        self.get(id)?.step(state).map(|step| step.answer())
    }

    /// Ends a session.
    pub fn close(&mut self, id: &str) -> Result<(), ApiError> {
        let open = id.parse().ok().and_then(|key: u64| self.open.remove(&key));
        open.map(drop).ok_or_else(|| ApiError::unknown_controller(id))
    }

    fn get(&mut self, id: &str) -> Result<&mut LocalController, ApiError> {
        let open = id.parse().ok().and_then(|key: u64| self.open.get_mut(&key));
        open.ok_or_else(|| ApiError::unknown_controller(id))
    }
}

fn created(id: String, controller: &LocalController) -> wire::CreatedController {
    wire::CreatedController {
        id,
        joints: controller.joints().map(str::to_owned).collect(),
        idle_timeout_s: NEVER_S,
        warnings: controller.warnings().to_vec(),
    }
}
