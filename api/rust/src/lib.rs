//! Client of a revprio service: the bodies of requests and answers, and a typed, blocking HTTP client.
//!
//! | to | see |
//! |---|---|
//! | call a service over HTTP | [`Client`], [`Service`] |
//! | read or write bodies as JSON or MessagePack with serde | [`wire`] |
//! | get the tasks of a common job | [`presets`] |
//! | write a control loop for a service over HTTP or in the same process | [`Service`] |
//!
//! ```no_run
//! use revprio_api::Client;
//! use revprio_api::wire::ResolveRequest;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let client = Client::new("http://127.0.0.1:8080"); // `revprio serve`
//! let request: ResolveRequest = serde_json::from_str(
//!     r#"{"robot": "planar_3r", "joint_position": [0.3, 0.5, 0.4],
//!         "tasks": [{"axes": ["x", "y"], "velocity": [0.1, 0]}]}"#,
//! )?;
//! let answer = client.resolve(&request)?; // an error names the field and the remedy
//! println!("{:?} rad/s", answer.joint_velocity);
//! # Ok(())
//! # }
//! ```

mod address;
mod client;
pub mod clock;
pub mod presets;
pub mod wire;

pub use client::{Client, ClientError, Service};
