//! The program as its users run it.

mod demo;
mod program;
mod resolve;
mod robot;
mod scenarios;
mod serve;
mod simulate;
mod trace;
