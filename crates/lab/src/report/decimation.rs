//! Removes points of a curve that the picture cannot show.

/// Keeps the first and the last point, and the lowest and the highest point of each bucket of consecutive points, in
/// order of time: at most `2 * buckets + 2` points. An impact that lasts one sample keeps its full height.
#[must_use]
pub fn extremes_per_bucket(points: &[(f64, f64)], buckets: usize) -> Vec<(f64, f64)> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    if points.len() <= 2 * buckets {
        return points.to_vec();
    }
    let length = points.len().div_ceil(buckets.max(1));
    let inner = points.chunks(length).flat_map(extremes);
    let mut kept: Vec<_> = std::iter::once(*first).chain(inner).chain([*last]).collect();
    kept.dedup();
    kept
}

/// Removes points so that the vertical distance between the old and the new polyline stays within `tolerance` (unit of
/// the ordinate). The abscissas must ascend.
#[must_use]
pub fn within(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let Some((&first, rest)) = points.split_first() else { return Vec::new() };
    let mut kept = vec![first];
    let mut cone = Cone::from(first);
    for &point in rest {
        if !cone.contains(point) {
            kept.push(cone.end);
            cone = Cone::from(cone.end);
        }
        cone.narrow(point, tolerance);
    }
    if rest.is_empty() { kept } else { [kept, vec![cone.end]].concat() }
}

/// The range of slopes of straight lines from a point that pass within the tolerance of every later point.
struct Cone {
    apex: (f64, f64),
    slopes: (f64, f64),
    end: (f64, f64),
}

impl Cone {
    fn from(apex: (f64, f64)) -> Self {
        Self { apex, slopes: (f64::NEG_INFINITY, f64::INFINITY), end: apex }
    }

    fn slope(&self, (x, y): (f64, f64)) -> f64 {
        (y - self.apex.1) / (x - self.apex.0)
    }

    fn contains(&self, point: (f64, f64)) -> bool {
        (self.slopes.0..=self.slopes.1).contains(&self.slope(point))
    }

    fn narrow(&mut self, (x, y): (f64, f64), tolerance: f64) {
        self.slopes.0 = self.slopes.0.max(self.slope((x, y - tolerance)));
        self.slopes.1 = self.slopes.1.min(self.slope((x, y + tolerance)));
        self.end = (x, y);
    }
}

/// Returns the lowest and the highest point of a non-empty chunk, the earlier one first.
fn extremes(chunk: &[(f64, f64)]) -> [(f64, f64); 2] {
    let pick = |a: (f64, f64), b: (f64, f64), keep_a: bool| if keep_a { a } else { b };
    let fold = |(low, high): ((f64, f64), (f64, f64)), p: &(f64, f64)| {
        (pick(low, *p, low.1 <= p.1), pick(high, *p, high.1 >= p.1))
    };
    let (low, high) = chunk.iter().fold((chunk[0], chunk[0]), fold);
    if low.0 <= high.0 { [low, high] } else { [high, low] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp_with_spikes() -> Vec<(f64, f64)> {
        let mut points: Vec<_> = (0..5000).map(|i| (f64::from(i), 0.01 * f64::from(i))).collect();
        points[1234].1 = 900.0;
        points[1235].1 = -700.0;
        points
    }

    #[test]
    fn spike_of_one_sample_is_kept() {
        let kept = extremes_per_bucket(&ramp_with_spikes(), 100);
        assert!(kept.contains(&(1234.0, 900.0)) && kept.contains(&(1235.0, -700.0)));
    }

    #[test]
    fn result_is_short_ordered_and_keeps_both_ends() {
        let points = ramp_with_spikes();
        let kept = extremes_per_bucket(&points, 100);
        assert!(kept.len() <= 202);
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
    }

    #[test]
    fn reduced_polyline_stays_within_its_tolerance() {
        let wave = |i: i32| (f64::from(i), (0.01 * f64::from(i)).sin() + if i == 700 { 5.0 } else { 0.0 });
        let points: Vec<_> = (0..2000).map(wave).collect();
        let kept = within(&points, 1e-3);
        assert!(kept.len() < 200, "{}", kept.len());
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
        for pair in kept.windows(2) {
            let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
            let between = points.iter().filter(|(x, _)| (x0..=x1).contains(x));
            let worst = between.map(|(x, y)| (y - (y0 + (y1 - y0) * (x - x0) / (x1 - x0))).abs()).fold(0.0, f64::max);
            assert!(worst <= 1.001e-3, "{worst}");
        }
    }

    #[test]
    fn straight_line_is_reduced_to_its_two_ends() {
        let points = [(0.0, 1.0), (1.0, 2.0), (2.0, 3.0), (3.0, 4.0)];
        assert_eq!(within(&points, 1e-9), [points[0], points[3]]);
        assert_eq!(within(&points[..1], 1e-9), points[..1]);
        assert!(within(&[], 1.0).is_empty());
    }

    #[test]
    fn few_points_are_not_changed() {
        let points = [(0.0, 1.0), (1.0, 1.0), (2.0, 5.0)];
        assert_eq!(extremes_per_bucket(&points, 2), points);
        assert!(extremes_per_bucket(&[], 2).is_empty());
    }
}
