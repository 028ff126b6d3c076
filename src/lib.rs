//! The `revprio` program as a library.
//!
//! The program computes joint velocities of redundant robot arms over HTTP, simulates controllers against scenarios, and
//! reports the results. Use this library to run the program inside another one, for example in a test:
//!
//! ```
//! use revprio::service::{AppState, Robots, RunningServer, router};
//!
//! let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
//! let client = revprio_api::Client::new(&server.url());
//! assert!(client.robots().unwrap().robots.iter().any(|robot| robot.name == "sawyer"));
//! ```
//!
//! The server listens on a free loopback port and ends when it is dropped.
//!
//! | module | content |
//! |---|---|
//! | [`service`] | the HTTP service: routes, sessions, simulations |
//! | [`cli`] | the commands of the program |
//!
//! # The layers below
//!
//! To control an arm from Rust without a server, use `revprio_core` alone.
//!
//! | crate | content |
//! |---|---|
//! | [`revprio_robot`] | robot models, URDF, joint limits, kinematics |
//! | [`revprio_core`] | the controller: tasks, limits, laws and their resolution into joint velocities |
//! | [`revprio_api`] | the JSON bodies of the service and a typed HTTP client |
//! | [`revprio_lab`] | simulator, scenarios, recordings, metrics, figures and reports |

pub mod cli;
mod dashboard;
pub mod service;
