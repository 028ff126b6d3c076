//! The way of the joints behind their drive while commands bring them to rest.

use revprio_robot::RobotModel;

use crate::limits::{Drive, DriveState, braking_deceleration, full_braking, reaction_time};

/// Points at which the settling of a lag is sampled, as shares of the way that is left.
const SETTLING: [f64; 4] = [0.45, 0.75, 0.92, 1.0];

/// Time between two samples, s, as far as the period permits.
const SAMPLE_TIME: f64 = 0.004;

/// Returns a bound of the number of periods in which a robot stops from full speed; `period`: T, s.
pub fn longest_stop(robot: &RobotModel, period: f64) -> usize {
    let stop = robot.joints().iter().map(|joint| {
        let (limits, deceleration) = (&joint.limits, braking_deceleration(&joint.limits));
        let rise = if limits.jerk.is_finite() { 3.0 * deceleration / limits.jerk } else { 0.0 };
        limits.velocity / deceleration + rise
    });
    let periods = ((stop.fold(0.0, f64::max) + 2.0 * reaction_time(period)) / period).ceil();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive; more saturates")]
    let periods = periods as usize;
    periods.saturating_add(8)
}

/// Returns a bound of the number of samples of a stop from full speed; `period`: T, s.
pub fn samples_of_stop(robot: &RobotModel, period: f64) -> usize {
    longest_stop(robot, period) / stride(period) + SETTLING.len()
}

/// Returns the number of periods between two samples; `period`: T, s.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive; more saturates")]
pub fn stride(period: f64) -> usize {
    ((SAMPLE_TIME / period).round() as usize).max(1)
}

/// The joints before a stop.
#[derive(Debug, Clone, Copy)]
pub struct Start<'a> {
    /// q, measured position, n.
    pub position: &'a [f64],
    /// What the drive still has to follow.
    pub drive_state: &'a DriveState,
    pub drive: Drive,
    /// T, s.
    pub period: f64,
}

/// The commands of a stop: one that is held for some periods, then braking.
#[derive(Debug, Clone, Copy)]
pub struct Braking<'a> {
    pub robot: &'a RobotModel,
    /// The command that is held, n.
    pub command: &'a [f64],
    /// Number of periods for which it is held.
    pub held: usize,
    /// Its acceleration, n; `None`: the joints brake at once, as a watchdog does.
    pub acceleration: Option<&'a [f64]>,
    /// Whether the joints keep their acceleration limits.
    pub keeps_acceleration: bool,
}

/// The positions of the joints at the ends of all periods, and at some points while the lag settles.
#[derive(Debug)]
pub struct StopPath {
    n: usize,
    /// T, s.
    period: f64,
    /// Positions at each node, n each. Node 0 is the start.
    position: Vec<f64>,
    /// Velocities at each node up to the last period, n each.
    velocity: Vec<f64>,
    /// Commands in the order in which they are sent, n each.
    commands: Vec<f64>,
    /// Number of periods.
    periods: usize,
    /// Number of periods for which commands differ from zero.
    pub sent: usize,
    /// L, s.
    lag: f64,
}

impl StopPath {
    /// Allocates a path of n joints for at most `periods` periods.
    pub fn new(n: usize, periods: usize, period: f64) -> Self {
        let nodes = n * (periods + SETTLING.len() + 1);
        let memory = || Vec::with_capacity(nodes);
        let (position, velocity, commands) = (memory(), memory(), memory());
        Self { n, period, position, velocity, commands, periods: 0, sent: 0, lag: 0.0 }
    }

    /// Follows the commands of a stop until the joints are at rest. What exceeds the allocated number of periods is left out.
    pub fn follow(&mut self, start: Start, braking: Braking) {
        self.write_commands(start.period, braking);
        let Start { position, drive_state, drive, period } = start;
        let n = self.n;
        self.lag = drive.lag_s;
        self.periods = self.sent + drive_state.pending.len();
        let remaining = if drive.lag_s > 0.0 { (-period / drive.lag_s).exp() } else { 0.0 };
        let lag_way = drive.lag_s * (1.0 - remaining);
        self.position.clear();
        self.velocity.clear();
        self.position.extend_from_slice(position);
        self.velocity.extend_from_slice(drive_state.velocity.as_slice());
        for k in 0..self.periods {
            let at = k * n;
            for joint in 0..n {
                let acting = match drive_state.pending.get(k) {
                    Some(pending) => pending[joint],
                    None => self.commands[(k - drive_state.pending.len()) * n + joint],
                };
                let difference = self.velocity[at + joint] - acting;
                self.position.push(self.position[at + joint] + period * acting + difference * lag_way);
                self.velocity.push(acting + difference * remaining);
            }
        }
        let end = self.periods * n;
        for share in SETTLING {
            for joint in 0..n {
                let way = drive.lag_s * self.velocity[end + joint];
                self.position.push(self.position[end + joint] + share * way);
            }
        }
    }

    /// Overwrites the commands with those of a stop, without the zeros at its end.
    fn write_commands(&mut self, period: f64, braking: Braking) {
        let Braking { robot, command, held, acceleration, keeps_acceleration } = braking;
        let (n, capacity) = (self.n, self.velocity.capacity() / self.n);
        self.commands.clear();
        for _ in 0..held.min(capacity) {
            self.commands.extend_from_slice(command);
        }
        self.sent = held.min(capacity);
        let mut moves = command.iter().any(|speed| *speed != 0.0);
        while moves && self.sent < capacity {
            moves = false;
            for (joint, description) in robot.joints().iter().enumerate() {
                let limits = &description.limits;
                let last = if self.sent == 0 { command[joint] } else { self.commands[(self.sent - 1) * n + joint] };
                let next = match acceleration {
                    _ if !keeps_acceleration => 0.0,
                    None => {
                        last - last.clamp(-braking_deceleration(limits) * period, braking_deceleration(limits) * period)
                    }
                    Some(first) => {
                        let before = match self.sent {
                            0 | 1 => None,
                            sent => Some(self.commands[(sent - 2) * n + joint]),
                        };
                        // While a command is held, its acceleration is zero.
                        let known = if self.sent == 0 || held == 1 && self.sent == 1 {
                            first[joint]
                        } else {
                            before.map_or(0.0, |before| (last - before) / period)
                        };
                        full_braking(limits, (last, known), period)
                    }
                };
                moves |= next != 0.0;
                self.commands.push(next);
            }
            self.sent += 1;
        }
    }

    /// Returns the number of nodes.
    pub fn nodes(&self) -> usize {
        self.position.len() / self.n
    }

    /// Returns the position at a node, n.
    pub fn position(&self, node: usize) -> &[f64] {
        &self.position[node * self.n..(node + 1) * self.n]
    }

    /// Returns the commands of the stop, without the zeros at its end.
    #[cfg(test)]
    pub fn sent_commands(&self) -> Vec<Vec<f64>> {
        self.commands.chunks_exact(self.n).map(<[f64]>::to_vec).collect()
    }

    /// Returns the number of periods between two samples.
    pub fn stride(&self) -> usize {
        stride(self.period)
    }

    /// Returns the node at the end of the last period; from it on, the joints move straight to rest.
    pub fn last_period(&self) -> usize {
        self.periods
    }

    /// Returns the time of a node, s. At the last one, a lag has settled but for a hundredth.
    pub fn time(&self, node: usize) -> f64 {
        let settling =
            node.checked_sub(self.periods + 1).map_or(0.0, |k| -self.lag * (1.0 - SETTLING[k]).max(0.01).ln());
        node.min(self.periods) as f64 * self.period + settling
    }

    /// Overwrites, for each joint, how far it moves between two nodes at most (n), and how far it leaves the straight way between
    /// them (n), rad or m.
    ///
    /// Between two nodes at most `period` apart, the velocity of a joint lies between those at both, because a lag follows a constant command
    /// monotonously. A joint whose velocities have the range r leaves its chord of duration Δt by at most r Δt/4.
    pub fn write_ways(&self, (from, to): (usize, usize), ways: &mut [f64], strays: &mut [f64]) {
        let n = self.n;
        let steps = from..to.min(self.periods);
        let duration = steps.len() as f64 * self.period;
        for joint in 0..n {
            let (mut least, mut most, mut way) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
            for node in steps.clone() {
                let [a, b] = [node, node + 1].map(|node| self.velocity[node * n + joint]);
                (least, most) = (least.min(a.min(b)), most.max(a.max(b)));
                way += self.period * a.abs().max(b.abs());
            }
            if to > self.periods {
                let last = from.max(self.periods);
                way += (self.position[to * n + joint] - self.position[last * n + joint]).abs();
            }
            (ways[joint], strays[joint]) = (way, 0.25 * duration * (most - least).max(0.0));
        }
    }
}
