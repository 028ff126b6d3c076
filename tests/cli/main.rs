//! The program as its users run it.

mod demo;
mod load;
mod openapi;
mod program;
mod resolve;
mod restart;
mod robot;
mod scenarios;
mod serve;
mod settings;
mod simulate;
mod trace;
