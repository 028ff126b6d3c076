//! How fast the joints can move along a line: the time-optimal parametrisation within V and A.
//!
//! On the line q(σ) joint j has the velocity q′ σ̇ and the acceleration q′ σ̈ + q″ σ̇². With x = σ̇² both limits are linear in (σ̈, x):
//!
//! |q′_j| √x ≤ V_j, |q′_j σ̈ + q″_j x| ≤ A_j.
//!
//! A pass backwards from the end of the known line gives the largest x at each place from which the joints can still stop there (the
//! controllable sets of TOPP-RA, Pham and Pham 2018). Each period then accelerates as much as these sets permit.

use super::joint_law::Capability;
use crate::controller::state::{LINE_INTERVALS, Line};

/// Share of A that the line uses. The rest is for the feedback and for what lies between the places.
const LINE_SHARE: f64 = 0.95;

/// Share of V that the line uses, for the same reason.
const SPEED_SHARE: f64 = 0.97;

/// Steps of the bisections: each halves the error.
const BISECTIONS: usize = 20;

/// Δσ.
const INTERVAL: f64 = 1.0 / LINE_INTERVALS as f64;

/// Smallest |q′| that limits σ̈, rad or m.
const LEAST_RATE: f64 = 1e-6;

/// Updates the speeds at all known places of a line.
pub(super) fn update_speeds(line: &mut Line, can: &[Capability]) {
    let known = line.postures.len();
    line.speeds.resize(known, 0.0);
    line.speeds[known - 1] = 0.0;
    for i in (0..known - 1).rev() {
        let next = line.speeds[i + 1].powi(2);
        let stops = |x: f64| {
            let [least, greatest] = accelerations_in(&line.postures, i, x, can);
            least <= greatest && x + 2.0 * INTERVAL * least <= next
        };
        let rates = |j: usize| rates_at(&line.postures, i, j);
        line.speeds[i] = largest(stops, largest_square(&rates, can)).sqrt();
    }
}

/// Moves on along a line for one period (T, s) as fast as the joints can; returns whether the line has ended.
pub(super) fn advance(line: &mut Line, can: &[Capability], period: f64) -> bool {
    let (progress, speed) = (line.progress, line.speed);
    let (i, _) = split(progress, line.postures.len());
    let last = line.postures.len() - 1;
    let end = last as f64 * INTERVAL;
    let [least, greatest] = accelerations_in(&line.postures, i.min(last - 1), speed * speed, can);
    // What the speeds ahead permit comes first: they leave room to stop.
    let moved = |next: f64| progress + 0.5 * period * (speed + next);
    let fastest = if least <= greatest { (speed + period * greatest).max(0.0) } else { speed };
    let next = largest(|next| next * next <= square_at(line, moved(next)), fastest);
    (line.progress, line.speed) = if moved(next) < end { (moved(next), next) } else { (end, 0.0) };
    line.progress >= 1.0
}

/// Returns the time of a known line at its speeds, s: infinite if the joints must stop on the way.
pub(super) fn time(line: &Line) -> f64 {
    // The line begins at rest.
    let last = line.speeds.len() - 1;
    let speed = |i: usize| if i == 0 { 0.0 } else { line.speeds[i] };
    (0..last).map(|i| 2.0 * INTERVAL / (speed(i) + speed(i + 1))).sum()
}

/// Returns q(σ) of joint j at a place of the known line.
pub(super) fn position_at(line: &Line, place: f64, j: usize) -> f64 {
    let (i, part) = split(place, line.postures.len());
    let (from, to) = (line.postures[i][j], line.postures[(i + 1).min(line.postures.len() - 1)][j]);
    from + part * (to - from)
}

/// Returns the largest value from 0 to `most` that a condition accepts, which accepts all below one of them.
fn largest(accepts: impl Fn(f64) -> bool, most: f64) -> f64 {
    if accepts(most) {
        return most;
    }
    let (mut low, mut high) = (0.0, most);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if accepts(middle) { low = middle } else { high = middle }
    }
    low
}

/// Returns the least and the greatest σ̈ that the joints permit at x.
fn accelerations(rates: &dyn Fn(usize) -> [f64; 2], x: f64, can: &[Capability]) -> [f64; 2] {
    let mut range = [f64::NEG_INFINITY, f64::INFINITY];
    for (j, can) in can.iter().enumerate() {
        let [first, second] = rates(j);
        if first.abs() > LEAST_RATE {
            let (centre, half) = (-second * x / first, LINE_SHARE * can.acceleration / first.abs());
            range = [range[0].max(centre - half), range[1].min(centre + half)];
        }
    }
    range
}

/// Returns the least and the greatest σ̈ in the interval after place i that the joints permit at both of its ends, with x at the first one.
fn accelerations_in(postures: &[Vec<f64>], i: usize, x: f64, can: &[Capability]) -> [f64; 2] {
    let at_start = |j: usize| rates_at(postures, i, j);
    // At the end of the interval x has changed by 2 Δσ σ̈.
    let at_end = |j: usize| {
        let [first, second] = rates_at(postures, i + 1, j);
        [first + 2.0 * INTERVAL * second, second]
    };
    let [[a, b], [c, d]] = [accelerations(&at_start, x, can), accelerations(&at_end, x, can)];
    [a.max(c), b.min(d)]
}

/// Returns the largest x that the speed limits permit.
fn largest_square(rates: &dyn Fn(usize) -> [f64; 2], can: &[Capability]) -> f64 {
    let square = |(j, can): (usize, &Capability)| (SPEED_SHARE * can.speed / rates(j)[0].abs().max(LEAST_RATE)).powi(2);
    can.iter().enumerate().map(square).fold(f64::INFINITY, f64::min)
}

/// Returns x of the speeds at a place.
fn square_at(line: &Line, place: f64) -> f64 {
    let (i, part) = split(place, line.speeds.len());
    let square = |i: usize| line.speeds.get(i).map_or(0.0, |speed| speed * speed);
    square(i) + part * (square(i + 1) - square(i))
}

/// Returns the interval of a place, and the part of the interval before it.
fn split(place: f64, known: usize) -> (usize, f64) {
    let scaled = (place / INTERVAL).clamp(0.0, (known - 1) as f64);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to LINE_INTERVALS")]
    let i = scaled.floor() as usize;
    (i, scaled - i as f64)
}

/// Returns q′ and q″ of joint j at place i, from differences.
fn rates_at(postures: &[Vec<f64>], i: usize, j: usize) -> [f64; 2] {
    let last = postures.len() - 1;
    if last < 2 {
        return [(postures[last][j] - postures[0][j]) / INTERVAL, 0.0];
    }
    let middle = i.clamp(1, last - 1);
    let [before, at, after] = [middle - 1, middle, middle + 1].map(|k| postures[k][j]);
    let second = (after - 2.0 * at + before) / (INTERVAL * INTERVAL);
    let first = (after - before) / (2.0 * INTERVAL);
    [first + second * (i as f64 - middle as f64) * INTERVAL, second]
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 1e-3;

    /// Returns the time to the end of a line and the largest acceleration of a joint on the way.
    fn run(position: impl Fn(f64) -> Vec<f64>, can: Capability) -> (f64, f64) {
        let mut line = Line::default();
        line.start(&position(0.0), &[1.0]);
        for i in 1..=LINE_INTERVALS {
            line.postures.push(position(i as f64 * INTERVAL));
        }
        let can = vec![can; position(0.0).len()];
        update_speeds(&mut line, &can);
        let (mut time, mut places) = (0.0, vec![position(0.0)]);
        while !advance(&mut line, &can, PERIOD) && time < 10.0 {
            time += PERIOD;
            places.push(position(line.progress));
        }
        let of_joint = |w: &[Vec<f64>], j: usize| ((w[0][j] - 2.0 * w[1][j] + w[2][j]) / PERIOD / PERIOD).abs();
        let acceleration = |w: &[Vec<f64>]| (0..can.len()).map(|j| of_joint(w, j)).fold(0.0, f64::max);
        (time, places.windows(3).map(acceleration).fold(0.0, f64::max))
    }

    #[test]
    fn a_straight_joint_moves_by_its_trapezoid() {
        for speed in [1.0, 100.0] {
            let can = Capability { speed, acceleration: 4.0, jerk: f64::INFINITY };
            let (time, acceleration) = run(|x| vec![2.0 * x], can);
            let (v, a, d): (f64, f64, f64) = (speed, LINE_SHARE * 4.0, 2.0);
            let best = if d > v * v / a { d / v + v / a } else { 2.0 * (d / a).sqrt() };
            assert!(time < 1.03 * best + 0.02 && time > 0.98 * best, "{time}, not {best}");
            assert!(acceleration <= 4.0 + 1e-6, "{acceleration}");
        }
    }

    /// The first joint turns back on the way, while the second one moves on.
    #[test]
    fn a_bent_line_keeps_the_acceleration() {
        let can = Capability { speed: 3.0, acceleration: 5.0, jerk: f64::INFINITY };
        let (time, acceleration) = run(|x| vec![(2.0 * x).sin(), x], can);
        assert!(time < 1.3 && acceleration < 5.0, "{time} {acceleration}");
    }
}
