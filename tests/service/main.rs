//! The service as its clients see it: over HTTP on a loopback port.

mod clients;
mod examples;
mod hard_problems;
mod harness;
mod memory;
mod observability;
mod overload;
mod refusals;
mod security;
mod sequence;
mod states;
