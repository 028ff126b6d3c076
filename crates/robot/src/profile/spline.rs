//! Smooth interpolation through points.

use nalgebra::DVector;

use super::set_point::{Entries, Point, SetPoint};

/// A piecewise polynomial through points, twice continuously differentiable.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    /// One per point, m entries each.
    knots: Vec<Knot>,
}

#[derive(Debug, Clone, PartialEq)]
struct Knot {
    time: f64,
    point: SetPoint,
}

impl Spline {
    /// Interpolates points with increasing times; `None` if a derivative overflows.
    pub fn through(points: &[Point]) -> Option<Self> {
        let values: Vec<DVector<f64>> = points.iter().map(|point| DVector::from_row_slice(&point.value)).collect();
        let spans: Vec<f64> = points.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).collect();
        let rates = clamped_rates(&values, &spans);
        let last = points.len() - 1;
        let knot = |i: usize| {
            let (value, rate) = (values[i].clone(), rates[i].clone());
            let acceleration = if i == 0 || i == last {
                DVector::zeros(value.len())
            } else {
                // Second derivative of the cubic that begins at this knot.
                let h = spans[i];
                (&values[i + 1] - &value) * (6.0 / (h * h)) - (&rate * 4.0 + &rates[i + 1] * 2.0) / h
            };
            let [value, rate, acceleration] =
                [value, rate, acceleration].map(|entries| Entries::from_slice(entries.as_slice()));
            Knot { time: points[i].time_s, point: SetPoint { value, rate, acceleration } }
        };
        let knots: Vec<Knot> = (0..points.len()).map(knot).collect();
        let all_finite = |v: &Entries| v.iter().all(|entry| entry.is_finite());
        let is_finite = |k: &Knot| all_finite(&k.point.rate) && all_finite(&k.point.acceleration);
        knots.iter().all(is_finite).then_some(Self { knots })
    }

    /// Returns m, the number of entries.
    pub fn rows(&self) -> usize {
        self.knots[0].point.value.len()
    }

    /// Returns the values at the points, m entries each.
    pub fn values(&self) -> impl Iterator<Item = &[f64]> {
        self.knots.iter().map(|knot| &knot.point.value[..])
    }

    /// Returns bounds of |value| and |rate| at all times, m entries each.
    pub fn bounds(&self) -> [Entries; 2] {
        let first = &self.knots[0].point;
        let still = [first.value.iter().map(|entry| entry.abs()).collect(), Entries::from_elem(0.0, first.value.len())];
        let pieces = self.knots.windows(2).map(|pair| bounds(&pair[0], &pair[1]));
        pieces.fold(still, |[value, rate], piece| [larger(&value, &piece[0]), larger(&rate, &piece[1])])
    }

    /// Returns value and derivatives at time t, s.
    pub fn at(&self, time_s: f64) -> SetPoint {
        let next = self.knots.partition_point(|knot| knot.time <= time_s);
        match (next.checked_sub(1), self.knots.get(next)) {
            (Some(before), Some(after)) => evaluate(&self.knots[before], after, time_s),
            (Some(last), None) => self.knots[last].point.clone(),
            (None, _) => self.knots[0].point.clone(),
        }
    }
}

fn larger(a: &Entries, b: &Entries) -> Entries {
    a.iter().zip(b).map(|(a, b)| a.max(*b)).collect()
}

/// Returns bounds of |value| and |rate| of the quintic between two knots, m entries each.
///
/// A quintic lies in the convex hull of its six Bézier points, and its rate in that of five times their differences over
/// the time between the knots. The points follow from value, rate and acceleration at both ends.
fn bounds(a: &Knot, b: &Knot) -> [Entries; 2] {
    let h = b.time - a.time;
    let row = |row: usize| {
        let near = |knot: &Knot, h: f64| {
            let (p, v, w) = (knot.point.value[row], knot.point.rate[row] * h, knot.point.acceleration[row] * h * h);
            [p, p + v / 5.0, p + v * 0.4 + w / 20.0]
        };
        let ([p0, p1, p2], [p5, p4, p3]) = (near(a, h), near(b, -h));
        let points = [p0, p1, p2, p3, p4, p5];
        let value = points.iter().fold(0.0_f64, |most, point| most.max(point.abs()));
        let rate = points.windows(2).fold(0.0_f64, |most, pair| most.max((pair[1] - pair[0]).abs()));
        (value, rate * 5.0 / h)
    };
    let (value, rate) = (0..a.point.value.len()).map(row).unzip();
    [value, rate]
}

/// Computes the rates v_i at the points of the cubic spline that rests at both ends.
///
/// Continuity of the second derivative gives
/// v_{i−1}/h_{i−1} + 2 (1/h_{i−1} + 1/h_i) v_i + v_{i+1}/h_i = 3 ((p_i − p_{i−1})/h_{i−1}² + (p_{i+1} − p_i)/h_i²).
fn clamped_rates(values: &[DVector<f64>], spans: &[f64]) -> Vec<DVector<f64>> {
    let rows = values[0].len();
    let mut rates = vec![DVector::zeros(rows); values.len()];
    // Forward elimination and back substitution. The matrix is diagonally dominant, so pivoting is not needed.
    let mut above = vec![0.0; values.len()];
    for i in 1..values.len().saturating_sub(1) {
        let (left, right) = (1.0 / spans[i - 1], 1.0 / spans[i]);
        let pivot = 2.0 * (left + right) - left * above[i - 1];
        let slopes = (&values[i] - &values[i - 1]) * (left * left) + (&values[i + 1] - &values[i]) * (right * right);
        rates[i] = (slopes * 3.0 - &rates[i - 1] * left) / pivot;
        above[i] = right / pivot;
    }
    for i in (1..values.len().saturating_sub(1)).rev() {
        let next = &rates[i + 1] * above[i];
        rates[i] -= next;
    }
    rates
}

/// Evaluates the quintic with the value, rate and acceleration of both knots. Between inner knots it equals the cubic.
fn evaluate(a: &Knot, b: &Knot, time: f64) -> SetPoint {
    let h = b.time - a.time;
    let s = (time - a.time) / h;
    let (a, b) = (&a.point, &b.point);
    let mut point = SetPoint::resting(Entries::from_elem(0.0, a.value.len()));
    for row in 0..a.value.len() {
        let (p, v, w) = (a.value[row], a.rate[row] * h, a.acceleration[row] * (0.5 * h * h));
        // Difference at b from motion with constant acceleration: in value, rate and half the acceleration.
        let value_gap = b.value[row] - p - v - w;
        let rate_gap = b.rate[row] * h - v - w * 2.0;
        let acceleration_gap = b.acceleration[row] * (0.5 * h * h) - w;
        let c3 = value_gap * 10.0 - rate_gap * 4.0 + acceleration_gap;
        let c4 = value_gap * -15.0 + rate_gap * 7.0 - acceleration_gap * 2.0;
        let c5 = value_gap * 6.0 - rate_gap * 3.0 + acceleration_gap;
        point.value[row] = p + (v + (w + (c3 + (c4 + c5 * s) * s) * s) * s) * s;
        point.rate[row] = (v + (w * 2.0 + (c3 * 3.0 + (c4 * 4.0 + c5 * (5.0 * s)) * s) * s) * s) / h;
        point.acceleration[row] = (w * 2.0 + (c3 * 6.0 + (c4 * 12.0 + c5 * (20.0 * s)) * s) * s) / (h * h);
    }
    point
}
