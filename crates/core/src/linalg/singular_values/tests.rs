use super::*;
use crate::linalg::{Matrix, Svd};

/// Random and singular matrices of many sizes; the values are those of one-sided rotations.
#[test]
fn counts_the_smallest_value_and_the_product_are_those_of_the_decomposition() {
    let mut singular = SingularValues::default();
    for (m, n) in [(1, 1), (1, 5), (2, 2), (3, 7), (6, 7), (9, 9), (12, 35), (32, 35)] {
        for dependent in [false, true] {
            for unit in [1e-200, 1.0, 1e150] {
                let entry =
                    |i: usize, j: usize| ((7 * i * i + 3 * i * j + 5 * j) % 11) as f64 - 5.3 + (i + 2 * j) as f64;
                let row = |i: usize| if dependent && i + 1 == m { 0 } else { i };
                let matrix = Matrix::from_fn(m, n, |i, j| unit * (entry(row(i), j) * (1.0 + row(i) as f64)).sin());
                singular.decompose(n, (0..m).flat_map(|i| (0..n).map(move |j| (i, j))).map(|at| matrix[at]));
                let expected = Svd::new(&matrix);
                let (sigma, norm) = (expected.singular_values(), matrix.amax() * (m * n) as f64);
                assert!((singular.smallest() - expected.smallest()).abs() <= 1e-15 * norm, "{m} {n} {unit:e}");
                for (place, sigma) in sigma.iter().enumerate().filter(|(_, sigma)| **sigma > 1e-12 * norm) {
                    let around = [0.999, 1.001].map(|factor| singular.count_from(factor * sigma));
                    assert!(around[0] > place && around[1] <= place, "{m} {n} {unit:e}: {around:?} {place}");
                }
                let product: f64 = sigma.iter().map(|sigma| sigma / unit).product();
                let found = singular.product() / unit.powi(i32::try_from(m).unwrap());
                assert!(unit != 1.0 || dependent || (found - product).abs() <= 1e-9 * product);
            }
        }
    }
    singular.decompose(4, std::iter::empty());
    assert_eq!((singular.count_from(1.0), singular.smallest(), singular.product()), (0, 0.0, 1.0));
    singular.decompose(2, [0.0; 4].into_iter());
    assert_eq!((singular.count_from(0.0), singular.smallest(), singular.product()), (0, 0.0, 0.0));
}

/// A posture of all joints beside a task: as many singular values are one as the task leaves joints.
#[test]
fn the_smallest_value_is_exact_where_values_coincide() {
    let mut singular = SingularValues::default();
    for (n, m) in [(1, 0), (2, 0), (7, 0), (7, 1), (7, 3), (7, 5), (7, 6), (32, 6), (32, 30)] {
        let task = |i: usize, j: usize| ((3 * i * i + 5 * i * j + 7 * j) as f64).sin();
        let entry = |i: usize, j: usize| if j < m { task(i, j) } else { f64::from(u8::from(i == j - m)) };
        singular.decompose(n + m, (0..n).flat_map(|i| (0..n + m).map(move |j| entry(i, j))));
        assert!((singular.smallest() - 1.0).abs() < 1e-14, "{n} joints, {m} rows: {}", singular.smallest());
    }
}

/// The tasks of an arm may have more rows than it has joints.
#[test]
fn the_shape_of_the_matrix_does_not_matter() {
    let tall = Matrix::from_fn(9, 4, |i, j| ((3 * i * i + 5 * i * j + 7 * j) as f64).sin());
    let (smallest, product) = smallest_and_product(&tall);
    let expected = Svd::new(&tall);
    assert!((smallest - expected.smallest()).abs() < 1e-13);
    assert!((product / expected.singular_values().iter().product::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!(smallest_and_product(&tall.transpose()), (smallest, product));
    assert_eq!(smallest_and_product(&Matrix::zeros(0, 4)), (0.0, 0.0));
}
