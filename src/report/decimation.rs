//! Fewer points for the same picture.

/// Keeps the first and the last point and, of every run of consecutive points, the lowest and the
/// highest, in order of time: at most `2 * buckets + 2` points. An impact that lasts one sample
/// keeps its full height, which every n-th sample or an average would lose.
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

/// Lowest and highest point of a non-empty chunk, the earlier one first.
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
    fn a_spike_of_one_sample_survives() {
        let kept = extremes_per_bucket(&ramp_with_spikes(), 100);
        assert!(kept.contains(&(1234.0, 900.0)) && kept.contains(&(1235.0, -700.0)));
    }

    #[test]
    fn the_points_are_few_and_in_order_and_reach_both_ends() {
        let points = ramp_with_spikes();
        let kept = extremes_per_bucket(&points, 100);
        assert!(kept.len() <= 202);
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
    }

    #[test]
    fn few_points_are_left_alone() {
        let points = [(0.0, 1.0), (1.0, 1.0), (2.0, 5.0)];
        assert_eq!(extremes_per_bucket(&points, 2), points);
        assert!(extremes_per_bucket(&[], 2).is_empty());
    }
}
