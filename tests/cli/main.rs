//! Tests of the program on the command line.

mod check;
mod compare;
mod demo;
mod openapi;
mod payload;
mod press;
mod program;
mod replay;
mod resolve;
mod restart;
mod robot;
mod scenarios;
mod serve;
mod settings;
mod simulate;
mod sweep;
mod trace;
