//! Simulated experiments through a service over HTTP.

mod closed_loop_golden;
mod contact;
mod hold;
mod recording;
mod scenarios;
mod stability;
