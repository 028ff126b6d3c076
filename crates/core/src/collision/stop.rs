//! The way of the joints behind their drive while commands bring them to rest.

use revprio_robot::RobotModel;

use crate::limits::{Drive, DriveState, MAX_DRIVE_DELAY, braking_deceleration, full_braking, reaction_time};
use crate::linalg::Vector;

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
    /// Its acceleration, n; `None`: the joints keep no jerk limits, as a watchdog does not.
    pub acceleration: Option<&'a [f64]>,
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
    /// How far each joint has moved until each node at most, n each, rad or m.
    travelled: Vec<f64>,
    /// Commands in the order in which they are sent, n each.
    commands: Vec<f64>,
    /// How much the command of each joint changes in a period of braking, n.
    changes: Vec<f64>,
    /// Largest number of commands.
    longest: usize,
    /// Number of periods.
    periods: usize,
    /// Number of periods for which commands differ from zero.
    pub sent: usize,
    /// L, s.
    lag: f64,
    /// Whether joints may jump to another velocity.
    jumps: bool,
}

impl StopPath {
    /// Allocates a path of n joints for at most `longest` commands, after those that the drive still has to follow.
    pub fn new(n: usize, longest: usize, period: f64) -> Self {
        let nodes = n * (MAX_DRIVE_DELAY + longest + SETTLING.len() + 1);
        let memory = || Vec::with_capacity(nodes);
        let (position, velocity, travelled, commands) = (memory(), memory(), memory(), memory());
        let changes = Vec::with_capacity(n);
        Self {
            n,
            period,
            position,
            velocity,
            travelled,
            commands,
            changes,
            longest,
            periods: 0,
            sent: 0,
            lag: 0.0,
            jumps: false,
        }
    }

    /// Says that joints may jump to another velocity. The velocity before a jump is then no part of the motion after it.
    pub fn let_joints_jump(&mut self) {
        self.jumps = true;
    }

    /// Follows the commands of a stop until the joints are at rest. Commands that exceed the allocated number are left
    /// out: only a robot that is first measured at more than twice its speed limits needs more.
    pub fn follow(&mut self, start: Start, braking: Braking) {
        self.write_commands(start.period, braking);
        let Start { position, drive_state, drive, period } = start;
        let n = self.n;
        self.lag = drive.lag_s;
        self.periods = self.sent + drive_state.pending.len();
        let remaining = if drive.lag_s > 0.0 { (-period / drive.lag_s).exp() } else { 0.0 };
        let lag_way = drive.lag_s * (1.0 - remaining);
        let end = self.periods * n;
        for memory in [&mut self.position, &mut self.velocity, &mut self.travelled] {
            memory.resize(end + n, 0.0);
        }
        self.position[..n].copy_from_slice(position);
        self.velocity[..n].copy_from_slice(drive_state.velocity.as_slice());
        self.travelled[..n].fill(0.0);
        let pending = drive_state.pending.iter().map(Vector::as_slice);
        for (k, acting) in pending.chain(self.commands.chunks_exact(n)).enumerate() {
            let [position, velocity, travelled] = [&mut self.position, &mut self.velocity, &mut self.travelled]
                .map(|memory| memory[k * n..(k + 2) * n].split_at_mut(n));
            let before = velocity.0.iter().zip(position.0).zip(travelled.0);
            let after = velocity.1.iter_mut().zip(position.1).zip(travelled.1);
            for ((acting, ((v, q), way)), ((next_v, next_q), next_way)) in acting.iter().zip(before).zip(after) {
                let difference = *v - acting;
                *next_v = acting + difference * remaining;
                *next_q = *q + period * acting + difference * lag_way;
                *next_way = *way + period * v.abs().max(next_v.abs());
            }
        }
        for share in SETTLING {
            for joint in 0..n {
                let way = drive.lag_s * self.velocity[end + joint];
                self.position.push(self.position[end + joint] + share * way);
                self.travelled.push(self.travelled[end + joint] + share * way.abs());
            }
        }
    }

    /// Overwrites the commands with those of a stop, without the zeros at its end.
    fn write_commands(&mut self, period: f64, braking: Braking) {
        let Braking { command, held, acceleration, .. } = braking;
        self.sent = held.min(self.longest);
        self.commands.clear();
        for _ in 0..self.sent {
            self.commands.extend_from_slice(command);
        }
        match acceleration {
            Some(acceleration) => self.brake_with_jerk_limits(period, braking, acceleration),
            None => self.brake(period, braking),
        }
    }

    /// Adds commands that brake each joint as fast as its limits of acceleration allow, see [`full_braking`].
    fn brake(&mut self, period: f64, braking: Braking) {
        let n = self.n;
        self.changes.clear();
        self.changes.extend(braking.robot.joints().iter().map(|joint| braking_deceleration(&joint.limits) * period));
        let mut moves = braking.command.iter().any(|entry| *entry != 0.0);
        while moves && self.sent < self.longest {
            moves = false;
            let end = self.sent * n;
            self.commands.resize(end + n, 0.0);
            let (before, next) = self.commands.split_at_mut(end);
            let last = before.len().checked_sub(n).map_or(braking.command, |start| &before[start..]);
            for ((next, last), change) in next.iter_mut().zip(last).zip(&self.changes) {
                *next = last - last.clamp(-change, *change);
                // A change that is rounded to zero brings no joint to rest.
                moves |= *next != 0.0 && *next != *last;
            }
            self.sent += 1;
        }
    }

    /// Adds commands that brake each joint as fast as its limits of acceleration and jerk allow; `first`: the acceleration of the
    /// command, n.
    fn brake_with_jerk_limits(&mut self, period: f64, Braking { robot, command, held, .. }: Braking, first: &[f64]) {
        let n = self.n;
        // A joint at zero speed with an acceleration moves on, too.
        let mut moves = command.iter().chain(first).any(|entry| *entry != 0.0);
        while moves && self.sent < self.longest {
            moves = false;
            for (joint, description) in robot.joints().iter().enumerate() {
                let last = if self.sent == 0 { command[joint] } else { self.commands[(self.sent - 1) * n + joint] };
                let known = match self.sent {
                    0 => first[joint],
                    1 if held == 1 => first[joint],
                    // While a command is held, its acceleration is zero.
                    1 => 0.0,
                    sent => (last - self.commands[(sent - 2) * n + joint]) / period,
                };
                let next = full_braking(&description.limits, (last, Some(known)), period);
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

    /// Returns the node some periods after another one. From the end of the last period on, it is the next one.
    pub fn next_node(&self, node: usize, periods: usize) -> usize {
        if node < self.periods { (node + periods).min(self.periods) } else { node + 1 }
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

    /// Returns the time until the joints rest, s; 0 if they do.
    pub fn duration(&self) -> f64 {
        let last = self.nodes() - 1;
        let moves = self.travelled[last * self.n..].iter().any(|way| *way > 0.0);
        if moves { self.time(last) } else { 0.0 }
    }

    /// Overwrites, for each joint, how far it moves between two nodes at most, n, rad or m.
    ///
    /// In a period, the velocity of a joint lies between those at both ends, because a lag follows a constant command monotonously.
    pub fn write_ways(&self, (from, to): (usize, usize), ways: &mut [f64]) {
        let [before, after] = [from, to].map(|node| &self.travelled[node * self.n..][..self.n]);
        for ((way, before), after) in ways.iter_mut().zip(before).zip(after) {
            *way = after - before;
        }
    }

    /// Overwrites, for each joint, how far it leaves the straight way between two nodes at most, n, rad or m.
    ///
    /// A joint whose velocities have the range r leaves its chord of duration Δt by at most r Δt/4. While a lag settles, all joints move
    /// straight to rest together.
    pub fn write_strays(&self, (from, to): (usize, usize), strays: &mut [f64]) {
        let n = self.n;
        let last = to.min(self.periods);
        if from >= last {
            strays.fill(0.0);
            return;
        }
        // Without a lag, the joints move uniformly in each period, with the velocity at its end.
        let first = if self.jumps && self.lag == 0.0 { from + 1 } else { from };
        let quarter = 0.25 * (last - from) as f64 * self.period;
        for (joint, stray) in strays.iter_mut().enumerate() {
            let velocities = (first..=last).map(|node| self.velocity[node * n + joint]);
            let (least, most) =
                velocities.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| (least.min(v), most.max(v)));
            *stray = quarter * (most - least);
        }
    }
}

#[cfg(test)]
mod tests {
    use revprio_robot::{JointLimits, built_in};

    use super::*;

    #[test]
    fn a_joint_that_cannot_brake_needs_no_more_memory() {
        let mut joints = built_in()[0].joints().to_vec();
        // A change of the velocity by 1e-322/s × 0.01 s is rounded to zero.
        joints[0].limits = JointLimits { velocity: 1e-320, acceleration: 1e-322, ..joints[0].limits };
        let robot = RobotModel::new("arm", "", joints, *built_in()[0].tool()).unwrap();
        let (period, n) = (0.01, robot.joint_count());
        let mut path = StopPath::new(n, longest_stop(&robot, period), period);
        let allocated = path.velocity.capacity();
        let drive = Drive { lag_s: 0.0, delay_periods: 2 };
        let drive_state = DriveState::moving(drive, &Vector::zeros(n));
        let command = [5e-324, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0];
        for _ in 0..3 {
            let start = Start { position: &[0.0; 7], drive_state: &drive_state, drive, period };
            path.follow(start, Braking { robot: &robot, command: &command, held: 0, acceleration: None });
            assert_eq!(path.velocity.capacity(), allocated);
            assert!(path.sent < 20, "{} commands", path.sent);
        }
    }
}
