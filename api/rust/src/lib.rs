//! The HTTP interface of a revprio service: the bodies of requests and answers, and a typed client.
//!
//! | to | see |
//! |---|---|
//! | call a service | [`Client`] |
//! | read or write bodies in JSON or MessagePack | [`wire`] |
//! | write a control loop that does not care where the service runs | [`Service`] |
//!
//! ```no_run
//! use revprio_api::Client;
//! use revprio_api::wire::ResolveRequest;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let client = Client::new("http://127.0.0.1:8080"); // `revprio serve`
//! let request: ResolveRequest = serde_json::from_str(
//!     r#"{"robot": "planar_3r", "joint_position": [0.3, 0.5, 0.4], "tasks": [{"axes": ["x", "y"], "velocity": [0.1, 0]}]}"#,
//! )?;
//! let answer = client.resolve(&request)?; // a refusal names the field and the remedy
//! println!("{:?} rad/s", answer.joint_velocity);
//! # Ok(())
//! # }
//! ```

mod client;
mod service;
pub mod wire;

pub use client::{Client, ClientError};
pub use service::Service;
