//! Which streamed targets fit a controller.

use super::controller_config::ControllerConfig;
use crate::streaming::{ChunkError, StreamedChunk, StreamedTarget, TargetError};

impl StreamedTarget {
    /// Checks that the target fits its task and the time of the measurement, s.
    pub fn check(&self, config: &ControllerConfig, time_s: f64) -> Result<(), TargetError> {
        let task = config.tasks.get(self.task).ok_or(TargetError::Quantity)?;
        let quantity = self.value.quantity();
        if !task.accepts(quantity) || (self.velocity.is_some() && !quantity.is_position()) {
            return Err(TargetError::Quantity);
        }
        self.check_values(task.rows.len(), time_s)
    }
}

impl StreamedChunk {
    /// Checks that the chunk fits its task and the time of the measurement, s.
    pub fn check(&self, config: &ControllerConfig, time_s: f64) -> Result<(), ChunkError> {
        let first = self.actions.first().ok_or(ChunkError::Empty)?;
        let task = config.tasks.get(self.task).filter(|task| task.accepts(first.value.quantity()));
        let task = task.ok_or(ChunkError::Quantity { index: 0 })?;
        self.check_actions(task.rows.len(), time_s)?;
        self.check_channels(config.channels.len())
    }
}
