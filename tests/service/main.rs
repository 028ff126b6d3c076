//! The service as its clients see it: over HTTP on a loopback port.

mod batch;
mod clients;
mod examples;
mod hard_problems;
mod harness;
mod kinematics;
mod memory;
mod message_pack;
mod openapi;
mod refusals;
mod robots;
mod sequence;
mod simulations;
mod states;
mod stream;
mod tasks;
mod warnings;
mod watch;
