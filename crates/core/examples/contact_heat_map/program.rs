//! A law that another program computes, so that anybody can compare theirs.
//!
//! The program reads lines and answers some of them. Numbers are separated by spaces.
//!
//! - `start T L D a sigma tau_f F_d v`: a run begins with this period (s), lag (s), delay (periods), limit of acceleration (m/s²), noise
//!   (N), lag of the sensor (s), target force (N) and approach speed (m/s). No answer. The stiffness is not told.
//! - `F v`: the reading (N) and the measured velocity (m/s) of a period. Answer: the command, m/s.
//!
//! A command that changes by more than a T is shortened to that.

use std::io::{BufRead, BufReader, Error, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use crate::plant::{Conditions, Controller};

pub struct Program {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    /// a T, m/s.
    step: f64,
    last: f64,
    failure: Option<String>,
}

impl Program {
    pub fn start(command: &[String]) -> Result<Self, Error> {
        let [program, arguments @ ..] = command else { return Err(Error::other("give a program")) };
        let mut child = Command::new(program).args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let (input, output) = (child.stdin.take(), child.stdout.take());
        let missing = || Error::other("the program has no input or output");
        let (input, output) = (input.ok_or_else(missing)?, BufReader::new(output.ok_or_else(missing)?));
        Ok(Self { child, input, output, step: 0.0, last: 0.0, failure: None })
    }

    /// Begins a run.
    pub fn begin(&mut self, terms: &Conditions) -> &mut Self {
        let Conditions { period, lag, delay, acceleration, noise, sensor_lag, target, speed, .. } = terms;
        (self.step, self.last) = (acceleration * period, *speed);
        let line = format!("start {period} {lag} {delay} {acceleration} {noise} {sensor_lag} {target} {speed}");
        if let Err(error) = writeln!(self.input, "{line}") {
            self.failure = Some(error.to_string());
        }
        self
    }

    /// Returns what went wrong.
    pub fn failure(&mut self) -> Option<String> {
        self.failure.take()
    }

    fn ask(&mut self, reading: f64, velocity: f64) -> Result<f64, Error> {
        writeln!(self.input, "{reading} {velocity}")?;
        let mut line = String::new();
        self.output.read_line(&mut line)?;
        let command = line.trim().parse().ok().filter(|command: &f64| command.is_finite());
        command.ok_or_else(|| Error::other(format!("the program answered `{}`, not a number", line.trim())))
    }
}

impl Controller for Program {
    fn command(&mut self, reading: f64, [_, velocity]: [f64; 2]) -> f64 {
        if self.failure.is_none() {
            match self.ask(reading, velocity) {
                Ok(command) => self.last = command.clamp(self.last - self.step, self.last + self.step),
                Err(error) => self.failure = Some(error.to_string()),
            }
        }
        self.last
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
