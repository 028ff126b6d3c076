//! Who may call: a bearer token, and the origins of web pages.

use std::fmt;
use std::net::IpAddr;
use std::path::{Path, PathBuf};

use axum::http::{HeaderMap, header};
use subtle::ConstantTimeEq;

use super::config::ServiceConfig;
use super::error::ApiError;

/// A secret that requests show as `Authorization: Bearer …`.
#[derive(Clone)]
pub struct Token(String);

/// Why a token file is refused.
#[derive(Debug, thiserror::Error)]
pub enum TokenError {
    /// The file cannot be read.
    #[error("cannot read the token file {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Nothing stands in it.
    #[error("the token file {path} is empty; write a long random word into it, such as that of `openssl rand -hex 32`")]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// No request could show it.
    #[error("the token file {path} holds more than one word; a token is one word of visible ASCII characters")]
    Characters {
        /// The file.
        path: PathBuf,
    },
}

impl Token {
    /// Reads a file; white space around the token is no part of it.
    pub fn read(path: &Path) -> Result<Self, TokenError> {
        let path_buf = || path.to_owned();
        let text = std::fs::read_to_string(path).map_err(|source| TokenError::Read { path: path_buf(), source })?;
        warn_if_others_can_read(path);
        match text.trim() {
            "" => Err(TokenError::Empty { path: path_buf() }),
            token if token.bytes().all(|byte| byte.is_ascii_graphic()) => Ok(Self(token.to_owned())),
            _ => Err(TokenError::Characters { path: path_buf() }),
        }
    }

    /// What a client sends after `Bearer`.
    pub fn secret(&self) -> &str {
        &self.0
    }

    /// Whether the request shows it; the time taken tells nothing of where a wrong one differs.
    fn is_shown(&self, headers: &HeaderMap) -> bool {
        let shown = headers.get(header::AUTHORIZATION).and_then(|value| value.to_str().ok());
        shown.and_then(|text| text.split_once(' ')).is_some_and(|(scheme, shown)| {
            scheme.eq_ignore_ascii_case("bearer") && shown.trim().as_bytes().ct_eq(self.0.as_bytes()).into()
        })
    }
}

/// Never shows the secret.
impl fmt::Debug for Token {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("Token(…)")
    }
}

#[cfg(unix)]
fn warn_if_others_can_read(path: &Path) {
    use std::os::unix::fs::PermissionsExt;
    let mode = std::fs::metadata(path).map_or(0, |metadata| metadata.permissions().mode());
    if mode & 0o077 != 0 {
        tracing::warn!(file = %path.display(), "others than the owner may read the token file; `chmod 600` it");
    }
}

#[cfg(not(unix))]
fn warn_if_others_can_read(_: &Path) {}

/// Refuses requests that a foreign web page makes.
pub fn check_origin(config: &ServiceConfig, headers: &HeaderMap) -> Result<(), ApiError> {
    if let Some(origin) = headers.get(header::ORIGIN) {
        let origin = origin.to_str().unwrap_or_default();
        if !(config.allowed_origins.iter().any(|allowed| allowed == origin) || is_own(config, origin, headers)) {
            return Err(ApiError::foreign_origin(origin));
        }
    }
    Ok(())
}

/// Refuses requests without the token, if there is one.
pub fn check_token(config: &ServiceConfig, headers: &HeaderMap) -> Result<(), ApiError> {
    match &config.token {
        Some(token) if !token.is_shown(headers) => Err(ApiError::unauthorized()),
        _ => Ok(()),
    }
}

/// Whether the page came from this service.
///
/// A page of another site can have its host's name resolve to this machine ("DNS rebinding") and then looks like one of
/// ours. Where no token protects the service, its own pages are therefore those of an address or of `localhost`.
fn is_own(config: &ServiceConfig, origin: &str, headers: &HeaderMap) -> bool {
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    let authority = origin.split_once("://").map_or("", |(_, authority)| authority);
    !host.is_empty() && authority.eq_ignore_ascii_case(host) && (config.token.is_some() || is_fixed(host))
}

/// Whether what a host and port name is out of a name server's hands.
fn is_fixed(host_and_port: &str) -> bool {
    let (host, port) = host_and_port.rsplit_once(':').unwrap_or((host_and_port, ""));
    let host = if port.bytes().all(|byte| byte.is_ascii_digit()) { host } else { host_and_port };
    let host = host.trim_start_matches('[').trim_end_matches(']');
    host.eq_ignore_ascii_case("localhost") || host.parse::<IpAddr>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_a_name_server_decides_on_are_not_fixed() {
        for fixed in ["localhost", "LOCALHOST:8080", "127.0.0.1", "127.0.0.1:80", "[::1]:8080", "[::1]", "192.168.0.7"]
        {
            assert!(is_fixed(fixed), "{fixed}");
        }
        for named in ["a", "a:80", "localhost.evil.example", "127.0.0.1.evil.example:8080", "", ":80", "1.2.3"] {
            assert!(!is_fixed(named), "{named}");
        }
    }
}
