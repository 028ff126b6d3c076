//! The service as its clients see it: over HTTP on a loopback port.

mod clients;
mod examples;
mod hard_problems;
mod harness;
mod memory;
mod refusals;
mod robots;
mod sequence;
mod states;
mod tasks;
mod warnings;
