//! Time of deadlines and measured durations.
//!
//! It is the time of tokio, which a test can simulate, except in WebAssembly, where the host sets the clock.

#[cfg(target_family = "wasm")]
pub use revprio_api::clock::Instant;
#[cfg(not(target_family = "wasm"))]
pub use tokio::time::Instant;
