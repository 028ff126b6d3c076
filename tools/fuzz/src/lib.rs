//! Fuzz targets of the service.
//!
//! A target sends the bytes of an input to a service in this process, through the same HTTP connection, routes and worker
//! threads that `revprio serve` uses. Only the socket is replaced by a pipe in memory. [`Checker::check`] finds a defect if
//!
//! - the service panics, answers with a server error without a documented cause, or does not answer,
//! - an answer is not a value of its documented type, or has a number that is not finite,
//! - a joint velocity is outside the stated speed limits,
//! - an answer uses more processor time than its budget (see [`budget`]).
//!
//! `tools/fuzz/run` runs the targets under libFuzzer. The test `corpus` replays the kept inputs without it.
//!
//! | module | content |
//! |---|---|
//! | [`target`] | the targets |
//! | [`checker`] | sends an input to the check of its target; each target has a module of its own |
//! | [`timed_service`] | a service whose answers have a budget |
//! | [`connection`] | a service in memory, and connections to it |
//! | [`answers`] | what must hold for each answer |
//! | [`limits`] | the speed limits of a request |
//! | [`budget`] | processor time that a request may use |
//! | [`mutation`] | mutations that keep an input well-formed |
//! | [`corpus`] | the kept inputs |
//! | [`seeds`] | first inputs: the examples, robots and scenarios of the repository |

pub mod answers;
mod bodies;
pub mod budget;
pub mod checker;
pub mod connection;
pub mod corpus;
mod frames;
pub mod limits;
pub mod mutation;
pub mod seeds;
mod session;
mod stability;
pub mod target;
pub mod timed_service;
mod urdf;

pub use budget::Bound;
pub use checker::Checker;
pub use target::Target;

/// A defect of the service.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Defect {
    /// The answer used more time than its budget. The text has both.
    Slow(String),
    /// The answer is wrong, or missing.
    Wrong(String),
}
