//! Options for the service that runs call.

use std::sync::Arc;

use revprio_api::Service;
use revprio_robot::RobotModel;

use super::error::CliError;
use super::target::Target;
use crate::service::{InProcess, Robots};

/// The service that the user chose.
#[derive(Debug, Clone, Default, clap::Args)]
// Without a group, because it is flattened into options of the same name.
#[group(skip)]
pub struct ServiceChoice {
    /// Service to call, for example http://127.0.0.1:8080, with the token in the file `REVPRIO_TOKEN_FILE` if that is set; if
    /// left out, the command starts its own on a free port
    #[arg(long, value_parser = server_address)]
    pub server: Option<String>,
    /// Call the code of the service as functions, without HTTP
    ///
    /// Without this option, each control period is an HTTP request over one connection that stays open. With it, there are no
    /// requests: the run is faster, and the number of requests and their round trips are not measured. The joint velocities
    /// are the same to the last bit.
    #[arg(long, conflicts_with = "server")]
    pub in_process: bool,
}

/// Returns the address of a service as it is, or why it is none.
pub fn server_address(text: &str) -> Result<String, String> {
    if text.starts_with("https://") {
        return Err(
            "TLS is not supported here; use an address that starts with http://, for example of a proxy on this \
                    machine that adds TLS"
                .to_owned(),
        );
    }
    let authority = text.strip_prefix("http://").and_then(|rest| rest.split('/').next()).unwrap_or_default();
    let (host, port) = match authority.rsplit_once(':') {
        // The colons of an IPv6 address are inside its brackets.
        Some((host, port)) if !port.ends_with(']') => (host, Some(port)),
        _ => (authority, None),
    };
    let is_port = port.is_none_or(|port| port.parse::<u16>().is_ok());
    if !host.is_empty() && is_port && !text.contains(char::is_whitespace) {
        return Ok(text.to_owned());
    }
    Err("an address has the scheme http, a host and a port, for example http://127.0.0.1:8080".to_owned())
}

impl ServiceChoice {
    /// Returns this choice as part of the command that repeats the runs. It has no address, which may differ next time.
    pub const fn repeated(&self) -> &'static str {
        if self.in_process { " --in-process" } else { "" }
    }
}

/// The service that runs call.
pub enum CalledService {
    /// A server, over HTTP.
    Http(Target),
    /// Functions of this process.
    InProcess(InProcess),
}

impl CalledService {
    /// Starts a server in this process, on a free port. It knows the given robot, or the built-in ones.
    pub fn start(robot: Option<&Arc<RobotModel>>) -> Result<Self, CliError> {
        Ok(Self::Http(Target::own(robots(robot)?)?))
    }

    /// Creates a service without a server. It knows the given robot, or the built-in ones.
    pub fn in_process(robot: Option<&Arc<RobotModel>>) -> Result<Self, CliError> {
        Ok(Self::InProcess(InProcess::new(robots(robot)?)))
    }

    /// Returns the calls of a control loop.
    pub fn calls(&self) -> &dyn Service {
        match self {
            Self::Http(target) => &target.client,
            Self::InProcess(service) => service,
        }
    }

    /// Returns the number of HTTP requests so far; `None` without HTTP.
    ///
    /// It is the number that the own server of this command has answered. A server elsewhere has other clients, so there it is
    /// the number that this client has sent.
    pub fn requests(&self) -> Option<u64> {
        match self {
            Self::Http(target) => Some(target.requests()),
            Self::InProcess(_) => None,
        }
    }
}

fn robots(robot: Option<&Arc<RobotModel>>) -> Result<Robots, CliError> {
    Ok(match robot {
        Some(robot) => Robots::none().with(Arc::clone(robot))?,
        None => Robots::built_in(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_have_a_scheme_and_a_host() {
        for address in
            ["http://127.0.0.1:8080", "http://robot-cell/", "http://[::1]:80", "http://[::1]", "http://a:1/b"]
        {
            assert_eq!(server_address(address).as_deref(), Ok(address));
        }
        for wrong in ["nonsense", "127.0.0.1:8080", "http://", "http://:80", "http://a:b", "ftp://a", "http://a b"] {
            assert!(server_address(wrong).unwrap_err().contains("for example http://127.0.0.1:8080"), "{wrong}");
        }
        assert!(server_address("https://127.0.0.1:8443").unwrap_err().contains("TLS is not supported here"));
    }
}
