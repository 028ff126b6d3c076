//! Options for the service that runs call.

use std::sync::Arc;

use revprio_api::Service;
use revprio_robot::RobotModel;

use super::{CliError, Target};
use crate::service::{InProcess, Robots};

/// The service that the user chose.
#[derive(Debug, Clone, Default, clap::Args)]
// Without a group, because it is flattened into options of the same name.
#[group(skip)]
pub struct ServiceChoice {
    /// Service to call, for example http://127.0.0.1:8080; if left out, the command starts its own on a free port
    #[arg(long)]
    pub server: Option<String>,
    /// Call the code of the service as functions, without HTTP
    ///
    /// Without this option, each control period is an HTTP request over one connection that stays open. With it, there are no
    /// requests: the run is faster, and the number of requests and their round trips are not measured. The joint velocities
    /// are the same to the last bit.
    #[arg(long, conflicts_with = "server")]
    pub in_process: bool,
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
