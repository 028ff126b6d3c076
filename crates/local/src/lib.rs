//! The service as function calls: it reads the JSON bodies of the HTTP interface, and computes and writes the answers.
//!
//! The HTTP service, the Python package and the WebAssembly module share this code, so they refuse the same requests and
//! give the same answers. It needs no server and no files, and no threads where there is one core.
//!
//! | to | use |
//! |---|---|
//! | answer a request by its method, path and body | [`LocalService`] |
//! | step a controller in this process | [`LocalController`] |
//! | convert bodies to the types of the core and back | [`convert`] |
//! | control and show an interactive simulation | [`simulation`] |

pub mod all_cores;
pub mod checked_stepper;
pub mod clock;
pub mod constraint_names;
pub mod convert;
pub mod error;
mod inner_place;
pub mod json;
mod local;
pub mod price;
pub mod request_warnings;
pub mod robots;
pub mod simulation;
pub mod solvers;
pub mod state_rules;
pub mod stateless_service;
pub mod step;
pub mod warnings;
pub mod why;

pub use error::ApiError;
pub use local::{LocalController, LocalService, Price};
