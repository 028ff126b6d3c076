//! A policy that looks at the arm, thinks, and answers with a chunk of actions.

/// How a policy answers.
#[derive(Debug, Clone, Copy)]
pub struct Policy {
    /// Time between two actions, s.
    pub interval_s: f64,
    /// Number of actions of a chunk.
    pub count: u32,
    /// Time from one look to the next, s.
    pub cycle_s: f64,
    /// Time from the look to the answer, s.
    pub latency_s: f64,
    /// Largest additional time, s.
    pub jitter_s: f64,
    /// Share of the answers that get lost.
    pub lost: f64,
    /// Largest offset of a whole chunk, m, rad.
    pub bias: f64,
    /// Largest error of an action, m, rad.
    pub noise: f64,
}

/// A chunk on its way: actions as time (s) and values.
#[derive(Debug, Clone)]
pub struct Answer {
    /// Time at which it arrives, s.
    pub arrives_s: f64,
    /// The actions.
    pub actions: Vec<(f64, Vec<f64>)>,
}

impl Policy {
    /// Returns the answers to all looks until `end` s, in the order of their arrival. `path`: the right values at a time; `random`:
    /// numbers from -1 to 1.
    pub fn answers(&self, end: f64, path: impl Fn(f64) -> Vec<f64>, mut random: impl FnMut() -> f64) -> Vec<Answer> {
        let mut answers = Vec::new();
        let mut look = 0.0;
        while look < end {
            let is_lost = 0.5 * (random() + 1.0) < self.lost;
            let arrives_s = look + self.latency_s + self.jitter_s * 0.5 * (random() + 1.0);
            let bias: Vec<f64> = path(look).iter().map(|_| self.bias * random()).collect();
            let mut action = |k: u32| {
                let time_s = look + f64::from(k) * self.interval_s;
                let values =
                    path(time_s).into_iter().zip(&bias).map(|(value, bias)| value + bias + self.noise * random());
                (time_s, values.collect())
            };
            let actions = (0..self.count).map(&mut action).collect();
            if !is_lost {
                answers.push(Answer { arrives_s, actions });
            }
            look += self.cycle_s;
        }
        answers.sort_by(|a, b| a.arrives_s.total_cmp(&b.arrives_s));
        answers
    }
}
