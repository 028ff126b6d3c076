//! The service in a WebAssembly module, for a page without a server.
//!
//! The module answers the requests of the page with the code of the HTTP service. Requests and answers are JSON texts in the
//! memory of the module: no generated glue, no tool whose version must match, and three exported functions.
//!
//! | file | content |
//! |---|---|
//! | `border` | the exported functions: buffers and requests |
//! | `service` | routes |
//! | `controllers` | sessions |
//! | `simulations`, `run` | interactive simulations, which the host advances |

#[cfg(target_family = "wasm")]
mod border;
mod controllers;
mod run;
mod service;
mod simulations;

pub use service::{Answer, BrowserService};
