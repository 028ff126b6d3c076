//! A wall that leaves, pushes, moves and changes its stiffness at random times.

use super::noise::Noise;

/// Softest and stiffest wall, N/m.
pub const STIFFNESS: [f64; 2] = [1e3, 1e6];

/// Largest force that a push alone would add, N, and its longest way, m, within this time, s.
const PUSH: (f64, f64, f64) = (90.0, 0.002, 0.01);

/// Damping of the wall over √K, that of 5 kg with a damping ratio of 0.02.
const DAMPING: f64 = 0.0894;

/// A wall along the pressing direction.
pub struct RandomWall {
    noise: Noise,
    /// Where its force is zero, m.
    place: f64,
    /// Its velocity, m/s.
    velocity: f64,
    /// Its stiffness, N/m.
    stiffness: f64,
    /// When its velocity ends and when its next event begins, s.
    times: [f64; 2],
    /// The largest stiffness so far, N/m, and the largest speed towards the tool, m/s.
    pub hardest: [f64; 2],
}

impl RandomWall {
    /// A wall of a stiffness, N/m, that rests for a time, s.
    pub fn new(stiffness: f64, rests: f64, seed: u64) -> Self {
        let times = [0.0, rests];
        Self { noise: Noise::new(seed), place: 0.0, velocity: 0.0, stiffness, times, hardest: [stiffness, 0.0] }
    }

    /// Moves the wall to a time, s; `tool`: where the tool is, m; `dt`: s.
    pub fn advance(&mut self, time: f64, tool: f64, dt: f64) {
        self.place += self.velocity * dt;
        let [ends, next] = self.times;
        if time >= ends {
            self.velocity = 0.0;
        }
        self.hardest[1] = self.hardest[1].max(-self.velocity);
        if time < next {
            return;
        }
        let lasts = self.noise.between(0.03, 0.8);
        self.times = [time, time + lasts];
        match self.noise.uniform() {
            kind if kind < 0.25 => self.place += self.noise.between(1e-4, 5e-3),
            kind if kind < 0.45 => {
                let way = (self.noise.uniform() * PUSH.0 / self.stiffness).min(PUSH.1);
                (self.velocity, self.times[0]) = (-way / PUSH.2, time + PUSH.2);
            }
            kind if kind < 0.75 => {
                let speed = self.noise.between(0.003, 0.1);
                // More often away: a wall that comes takes energy, and one that leaves makes the tool hop.
                self.velocity = if self.noise.uniform() < 0.7 { speed } else { -speed };
                self.times[0] = time + lasts;
            }
            _ => {
                let factor = self.noise.between(0.1, 10.0);
                self.change_stiffness(factor, tool);
            }
        }
    }

    /// Changes the stiffness by a factor without a jump of the force.
    fn change_stiffness(&mut self, factor: f64, tool: f64) {
        let spring = self.stiffness * (tool - self.place).max(0.0);
        self.stiffness = (self.stiffness * factor).clamp(STIFFNESS[0], STIFFNESS[1]);
        self.hardest[0] = self.hardest[0].max(self.stiffness);
        if spring > 0.0 {
            self.place = tool - spring / self.stiffness;
        }
    }

    /// Returns the force of a tool (m, m/s) on the wall, N.
    pub fn force(&self, [tool, speed]: [f64; 2]) -> f64 {
        let depth = tool - self.place;
        if depth <= 0.0 {
            return 0.0;
        }
        (self.stiffness * depth + DAMPING * self.stiffness.sqrt() * (speed - self.velocity)).max(0.0)
    }
}
