use super::*;
use crate::linalg::{Matrix, Svd};
use crate::resolution::hierarchy::Demand;

/// Reproducible numbers between −1 and 1.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Equations and inequality rows, some at their bounds, over joints, some of which have no room.
#[test]
fn the_regularity_is_that_of_the_smallest_singular_value() {
    let mut number = numbers();
    let (n, threshold) = (6, 0.3);
    let mut between = 0;
    for _ in 0..300 {
        let mut levels = Hierarchy::default();
        levels.clear(&[0.0; 6]);
        for _ in 0..12 {
            levels.push_row((0..n).map(|_| number()).collect::<Vec<_>>(), Demand::between(0.0, 1.0, None));
        }
        levels.end_level();
        let mut regularity = Regularity {
            room: (0..n).map(|_| number().max(0.0)).collect(),
            row_room: (0..12).map(|i| if i < 3 { 0.0 } else { number().abs() }).collect(),
            counted: (0..12).collect(),
            ..Regularity::default()
        };
        let entry = |i: usize, j: usize| match j.checked_sub(n) {
            None => levels.row(i)[j] * regularity.room[j],
            Some(place) if place == i => regularity.row_room[i],
            Some(_) => 0.0,
        };
        let expected = smooth(Svd::new(&Matrix::from_fn(12, n + 12, entry)).smallest() / threshold);
        let found = regularity.row_regularity(&levels, 12, threshold);
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        between += u32::from(0.01 < expected && expected < 0.99);
    }
    assert!(between > 30, "{between}");
}

#[test]
fn rows_beyond_the_range_of_numbers_end_the_secants() {
    let mut levels = Hierarchy::default();
    levels.clear(&[0.0; 2]);
    for row in [[1e200, 0.0], [0.0, 1e200], [1e-200, 1e200]] {
        levels.push_row(row, Demand::between(0.0, 1.0, None));
    }
    levels.end_level();
    let mut regularity = Regularity {
        room: vec![1.0; 2],
        row_room: vec![0.0, 0.0, 0.5],
        counted: (0..3).collect(),
        ..Regularity::default()
    };
    let found = regularity.row_regularity(&levels, 3, 1.0);
    assert!((0.0..=1.0).contains(&found), "{found}");
}

#[test]
fn a_threshold_that_is_hardly_a_number_gives_no_regularity() {
    let mut levels = Hierarchy::default();
    levels.clear(&[0.0]);
    levels.push_row([0.0], Demand::between(0.0, 1.0, None));
    levels.end_level();
    let mut regularity = Regularity { room: vec![0.0], row_room: vec![0.0], counted: vec![0], ..Regularity::default() };
    assert_eq!(regularity.row_regularity(&levels, 1, 5e-324), 0.0);
}
