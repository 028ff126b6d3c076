//! The service that a command calls.

use std::path::Path;

use revprio_api::Client;

use super::error::CliError;
use super::settings::SettingsError;
use crate::service::{AppState, Robots, RunningServer, ServeError, Token, router};

/// The service that a command calls: a given one, or its own service that runs as long as this value exists.
pub struct Target {
    pub client: Client,
    pub own: Option<RunningServer>,
}

impl Target {
    /// Opens a given service, with the token in the file `REVPRIO_TOKEN_FILE` if it is set, or starts an own service.
    pub fn open(url: Option<&str>) -> Result<Self, CliError> {
        if let Some(url) = url {
            let file = std::env::var_os("REVPRIO_TOKEN_FILE").filter(|file| !file.is_empty());
            let token = file.map(|file| Token::read(Path::new(&file))).transpose().map_err(SettingsError::from)?;
            let client = Client::new(url);
            let with_token = token.and_then(|token| client.clone().with_token(token.secret()));
            return Ok(Self { client: with_token.unwrap_or(client), own: None });
        }
        Ok(Self::own(Robots::built_in())?)
    }

    /// Starts an own service with these robots.
    pub fn own(robots: Robots) -> Result<Self, ServeError> {
        let own = RunningServer::start(router(AppState::new(robots)))?;
        Ok(Self { client: Client::new(&own.url()), own: Some(own) })
    }

    /// Returns the number of requests that the own service has answered, or that this client has sent to a given one.
    pub fn requests(&self) -> u64 {
        self.own.as_ref().map_or_else(|| self.client.requests(), RunningServer::answered)
    }
}
