use nalgebra::{Rotation3, Translation3};
use proptest::prelude::*;

use super::*;

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

fn segment() -> impl Strategy<Value = Segment> {
    let long = (vector(0.5), vector(0.3));
    let along = prop_oneof![4 => Just(1.0), 1 => Just(0.0), 1 => Just(1e-7)];
    (long, along).prop_map(|((from, way), scale)| Segment { from, to: from + way * scale })
}

/// Two segments, half of them nearly parallel.
fn segments() -> impl Strategy<Value = [Segment; 2]> {
    let parallel = (segment(), vector(0.4), vector(1.0), -9.0..0.0_f64).prop_map(|(first, shift, turn, exponent)| {
        let along = first.to - first.from + turn * 10_f64.powf(exponent);
        let from = first.from + shift;
        [first, Segment { from, to: from + along }]
    });
    prop_oneof![(segment(), segment()).prop_map(<[_; 2]>::from), parallel]
}

fn any_box() -> impl Strategy<Value = OrientedBox> {
    (vector(0.5), vector(2.0), prop::array::uniform3(0.01..0.3_f64)).prop_map(|(shift, turn, half)| OrientedBox {
        pose: IsometryMatrix3::from_parts(Translation3::from(shift), Rotation3::new(turn)),
        half: Vector3::from(half),
    })
}

/// Returns the least value of a convex function of 0 … 1, by a golden section search.
fn least(function: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let (a, b) = (low + 0.381_966 * (high - low), low + 0.618_034 * (high - low));
        if function(a) < function(b) { high = b } else { low = a }
    }
    function(low).min(function(high)).min(function(0.0)).min(function(1.0))
}

fn searched_to_segment(first: &Segment, second: &Segment) -> f64 {
    let along = second.to - second.from;
    least(|s| {
        let point = first.from + (first.to - first.from) * s - second.from;
        let t = (point.dot(&along) / along.norm_squared().max(1e-300)).clamp(0.0, 1.0);
        (point - along * t).norm()
    })
}

fn searched_to_box(segment: &Segment, other: &OrientedBox) -> f64 {
    least(|t| {
        let point = segment.from + (segment.to - segment.from) * t;
        let local = other.pose.rotation.inverse() * (point - other.pose.translation.vector);
        local.zip_map(&other.half, |x, h| x - x.clamp(-h, h)).norm()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn the_distance_of_segments_is_that_of_a_search([first, second] in segments()) {
        let expected = searched_to_segment(&first, &second);
        let found = first.to_segment(&second);
        prop_assert!((found.distance - expected).abs() < 1e-9, "{found:?}, not {expected}");
        prop_assert!((found.normal.norm() - 1.0).abs() < 1e-12);
        if expected > 1e-6 {
            // The common normal separates the cores by their whole distance.
            let apart = first.least(&found.normal) - second.support(&found.normal);
            prop_assert!((apart - expected).abs() < 1e-7, "{apart}, not {expected}");
        }
    }

    #[test]
    fn the_distance_to_a_box_is_that_of_a_search((segment, other) in (segment(), any_box())) {
        let expected = searched_to_box(&segment, &other);
        let found = segment.to_box(&other);
        prop_assert!((found.normal.norm() - 1.0).abs() < 1e-12);
        let apart = segment.least(&found.normal) - other.support(&found.normal);
        if expected > 1e-9 {
            prop_assert!((found.distance - expected).abs() < 1e-9, "{found:?}, not {expected}");
            prop_assert!((apart - expected).abs() < 1e-7, "{apart}, not {expected}");
        } else {
            prop_assert!(found.distance <= 1e-9, "{found:?}");
            // A shift by the depth along the normal brings them apart.
            let shifted = segment.shifted(found.normal * (1e-6 - found.distance));
            prop_assert!(searched_to_box(&shifted, &other) > 0.0);
        }
    }

    #[test]
    fn every_direction_separates_by_at_most_the_distance(
        ([first, second], other, direction) in (segments(), any_box(), vector(1.0)),
    ) {
        let Some(normal) = direction.try_normalize(1e-3) else { return Ok(()) };
        prop_assert!(first.least(&normal) - second.support(&normal) <= first.to_segment(&second).distance + 1e-12);
        let to_box = first.to_box(&other).distance;
        prop_assert!(first.least(&normal) - other.support(&normal) <= to_box.max(0.0) + 1e-12);
    }
}

#[test]
fn the_normal_is_continuous_where_segments_become_parallel() {
    let lower = Segment { from: Vector3::new(-0.2, 0.0, 0.0), to: Vector3::new(0.2, 0.0, 0.0) };
    let at = |angle: f64| {
        let way = Vector3::new(0.15, 0.0, 0.15 * angle.sin());
        let middle = Vector3::new(0.0, 0.0, 0.2);
        Segment { from: middle - way, to: middle + way }.to_segment(&lower)
    };
    let normals: Vec<_> = (-2000..=2000).map(|k| at(f64::from(k) * 1e-6)).collect();
    let largest = |change: &dyn Fn(&Separation) -> Vector3<f64>| {
        normals.windows(2).map(|pair| (change(&pair[1]) - change(&pair[0])).norm()).fold(0.0, f64::max)
    };
    assert!(largest(&|at| at.normal) < 1e-9);
    // The nearest point jumps from one end to the other, so it is no place for a gradient.
    assert!(largest(&|at| at.nearest) > 0.1);
}

#[test]
fn crossing_segments_come_apart_along_both_of_their_normals() {
    let x = Segment { from: Vector3::new(-1.0, 0.0, 0.0), to: Vector3::new(1.0, 0.0, 0.0) };
    let y = Segment { from: Vector3::new(0.0, -1.0, 0.0), to: Vector3::new(0.0, 1.0, 0.0) };
    let found = x.to_segment(&y);
    assert_eq!((found.distance, found.normal.z.abs()), (0.0, 1.0));
    // The same segment twice, and the same point twice: some unit vector.
    assert!((x.to_segment(&x).normal.norm() - 1.0).abs() < 1e-12);
    let point = Segment::point(Vector3::zeros());
    assert!((point.to_segment(&point).normal.norm() - 1.0).abs() < 1e-12);
    assert!(x.to_segment(&x).normal.x.abs() < 1e-12, "not along the segment");
}

#[test]
fn a_half_space_has_the_distance_of_the_nearer_end() {
    let segment = Segment { from: Vector3::new(0.0, 0.0, 0.3), to: Vector3::new(1.0, 0.0, 0.1) };
    let found = segment.to_half_space(&Vector3::z(), 0.02);
    assert!((found.distance - 0.08).abs() < 1e-15);
    assert_eq!(found.nearest, segment.to);
}
