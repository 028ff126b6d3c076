//! A checked configuration.

use super::config_error::ConfigError;
use super::controller_config::ControllerConfig;

/// A checked configuration. A [`Stepper`](crate::controller::Stepper) computes its commands.
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    config: ControllerConfig,
}

impl Controller {
    /// Checks the configuration.
    pub fn new(config: ControllerConfig) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self { config })
    }

    /// Returns the configuration.
    pub fn config(&self) -> &ControllerConfig {
        &self.config
    }
}
