//! The service as its clients see it: over HTTP on a loopback port.

mod batch;
mod bounds;
mod clients;
mod examples;
mod hard_problems;
mod harness;
mod host;
mod inequalities;
mod interactive;
mod kinematics;
mod long_work;
mod memory;
mod message_pack;
mod observability;
mod openapi;
mod overload;
mod refusals;
mod robots;
mod security;
mod sequence;
mod simulations;
mod states;
mod stream;
mod tasks;
mod warnings;
mod watch;
