//! The bearer token that protects the service.

use std::fmt;
use std::path::{Path, PathBuf};

use axum::http::{HeaderMap, header};
use subtle::ConstantTimeEq;

/// A secret that requests send as `Authorization: Bearer …`.
#[derive(Clone)]
pub struct Token(String);

/// The reason why a token file is refused.
#[derive(Debug, thiserror::Error)]
pub enum TokenError {
    /// The file cannot be read.
    #[error("cannot read the token file {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file holds no token.
    #[error(
        "the token file {path} is empty; write a long random word into it, such as the output of `openssl rand -hex 32`"
    )]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The token cannot be sent in a header.
    #[error("the token file {path} holds more than one word; a token is one word of visible ASCII characters")]
    Characters {
        /// The file.
        path: PathBuf,
    },
}

impl Token {
    /// Reads a token from a file. White space around the token is ignored.
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

    /// The word that a client sends after `Bearer`.
    pub fn secret(&self) -> &str {
        &self.0
    }

    /// Returns whether the request contains the token. The time of the comparison does not depend on where a wrong token
    /// differs.
    pub(super) fn is_in(&self, headers: &HeaderMap) -> bool {
        let value = headers.get(header::AUTHORIZATION).and_then(|value| value.to_str().ok());
        value.and_then(|text| text.split_once(' ')).is_some_and(|(scheme, token)| {
            scheme.eq_ignore_ascii_case("bearer") && token.trim().as_bytes().ct_eq(self.0.as_bytes()).into()
        })
    }
}

/// Hides the secret.
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
        tracing::warn!(file = %path.display(), "users other than the owner may read the token file; run `chmod 600` on it");
    }
}

#[cfg(not(unix))]
fn warn_if_others_can_read(_: &Path) {}
