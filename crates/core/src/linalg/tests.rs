//! Decompositions against what defines them, by reflections and by singular values.

use std::cmp::Ordering;

use proptest::prelude::*;

use super::{Conditioning, Decomposition, Matrix, TaskMatrix, TaskVector};

fn any_matrix() -> impl Strategy<Value = TaskMatrix> {
    (1..14_usize, 1..14_usize, 0..4_usize).prop_flat_map(|(m, n, dependent)| {
        prop::collection::vec(-1.0..1.0_f64, m * n).prop_map(move |entries| {
            let mut a = TaskMatrix::from_fn(m, n, |i, j| entries[i * n + j]);
            for row in 0..dependent.min(m - 1) {
                let copy = &a.row_vector(row + 1) * -0.5;
                a[row].copy_from_slice(&copy);
            }
            a
        })
    })
}

fn both_ways(a: &TaskMatrix) -> [Box<Decomposition>; 2] {
    [Box::new(Decomposition::new(a)), Box::new(Decomposition::singular(a, a.norm()))]
}

fn pseudo_inverse(decomposition: &Decomposition, m: usize) -> Matrix {
    let columns: Vec<_> = (0..m).map(|i| decomposition.solve(&TaskVector::unit(m, i)).to_vector()).collect();
    Matrix::from_columns(&columns)
}

fn diagonal(s: f64, factor: f64) -> TaskMatrix {
    TaskMatrix::from_fn(2, 2, |i, j| if i == j { [1.0, s][i] * factor } else { 0.0 })
}

proptest! {
    #[test]
    fn pseudo_inverse_satisfies_the_four_penrose_conditions(rows in any_matrix()) {
        for decomposition in both_ways(&rows) {
            let (a, p) = (rows.to_matrix(), pseudo_inverse(&decomposition, rows.nrows()));
            let scale = 1.0 + p.norm() * p.norm();
            prop_assert!((&a * &p * &a - &a).norm() < 1e-12 * scale);
            prop_assert!((&p * &a * &p - &p).norm() < 1e-12 * scale);
            prop_assert!((&a * &p - (&a * &p).transpose()).norm() < 1e-12 * scale);
            prop_assert!((&p * &a - (&p * &a).transpose()).norm() < 1e-12 * scale);
        }
    }

    #[test]
    fn null_space_and_range_are_orthonormal_and_complete(rows in any_matrix()) {
        for decomposition in both_ways(&rows) {
            let (a, n, range) = (rows.to_matrix(), decomposition.null_space().to_matrix(), decomposition.range());
            prop_assert_eq!(n.ncols() + decomposition.rank(), a.ncols());
            prop_assert!((&a * &n).norm() < 1e-12);
            prop_assert!((n.transpose() * &n - Matrix::identity(n.ncols(), n.ncols())).norm() < 1e-12);
            let u = range.to_matrix();
            prop_assert!((&u * u.transpose() - Matrix::identity(u.nrows(), u.nrows())).norm() < 1e-12);
            prop_assert!((u.transpose() * &u * &a - &a).norm() < 1e-12);
            let b = TaskVector::from_fn(rows.nrows(), |i| i as f64 - 1.5);
            let left = &b - &range.transposed_times(&(&range * &b));
            prop_assert!((&decomposition.unreachable(&b) - &left).norm() < 1e-12);
        }
    }

    #[test]
    fn both_ways_agree_on_the_rank_and_the_singular_values_are_those_of_the_matrix(rows in any_matrix()) {
        let [reflected, singular] = both_ways(&rows);
        prop_assert_eq!(reflected.rank(), singular.rank());
        let values = singular.singular_values();
        let product: f64 = values.iter().map(|sigma| sigma * sigma).sum();
        prop_assert!((product.sqrt() - rows.norm()).abs() < 1e-13 * rows.norm());
        let mut conditioning = Conditioning::default();
        conditioning.update(&rows, rows.norm(), None);
        prop_assert_eq!(conditioning.decomposition().rank(), singular.rank());
        prop_assert!((conditioning.smallest() - singular.smallest()).abs() < 1e-13 * values[0]);
    }

    #[test]
    fn what_is_certain_of_the_smallest_singular_value_is_true(rows in any_matrix(), bound in 0.0..1.0_f64) {
        let [mut reflected, singular] = both_ways(&rows);
        if reflected.exceeds(bound) {
            prop_assert!(singular.smallest() > bound * (1.0 - 1e-12));
        }
    }

    #[test]
    fn damped_solution_satisfies_its_normal_equations(rows in any_matrix(), lambda in 0.01..1.0_f64) {
        let b = TaskVector::from_fn(rows.nrows(), |i| i as f64 - 1.5);
        let decomposition = Decomposition::singular(&rows, rows.norm());
        let mut x = decomposition.damped_in_frame(&b, lambda);
        decomposition.from_frame(&mut x);
        let mut gradient = rows.transposed_times(&(&(&rows * &x) - &b));
        gradient.add_scaled(lambda * lambda, &x);
        prop_assert!(gradient.norm() < 1e-12 * (1.0 + b.norm()));
    }
}

#[test]
fn rank_is_relative_to_the_scale() {
    for (matrix, rank) in [
        (diagonal(1.1e-10, 1.0), 2),
        (diagonal(0.9e-10, 1.0), 1),
        (diagonal(0.5, 1e-30), 2),
        (diagonal(0.5, 1e-200), 0),
    ] {
        for decomposition in both_ways(&matrix) {
            assert_eq!(decomposition.rank(), rank, "{matrix:?}");
        }
    }
    assert_eq!(Decomposition::with_scale(&diagonal(0.5, 1e-15), 1.0).rank(), 0);
}

/// Rows that are nearly dependent as a whole, but no two of them (Kahan): the last of the triangle is far above the
/// smallest singular value.
#[test]
fn rank_means_singular_values_where_reflections_cannot_tell() {
    let (n, c) = (30, 0.9_f64);
    let s = (1.0 - c * c).sqrt();
    let kahan = |i: usize, j: usize| {
        let scale = s.powi(i32::try_from(i).unwrap());
        match i.cmp(&j) {
            Ordering::Equal => scale,
            Ordering::Less => -c * scale,
            Ordering::Greater => 0.0,
        }
    };
    let rows = TaskMatrix::from_fn(n, n, |i, j| kahan(j, i));
    let [reflected, singular] = both_ways(&rows);
    assert_eq!(reflected.rank(), singular.rank());
    assert!(reflected.rank() < n, "{:?}", singular.singular_values());
}

#[test]
fn empty_matrices_have_rank_zero_and_a_full_null_space() {
    let none = Decomposition::new(&TaskMatrix::zeros(0, 3));
    assert_eq!((none.rank(), none.null_space()), (0, TaskMatrix::identity(3)));
    assert_eq!(Decomposition::new(&TaskMatrix::zeros(2, 0)).solve(&TaskVector::zeros(2)).len(), 0);
}

#[test]
fn coinciding_singular_values_are_harmless() {
    let a = TaskMatrix::from_fn(2, 3, |i, j| [[0.0, 2.0, 0.0], [0.0, 0.0, -2.0]][i][j]);
    for decomposition in both_ways(&a) {
        assert!((a.to_matrix() * pseudo_inverse(&decomposition, 2) - Matrix::identity(2, 2)).norm() < 1e-15);
    }
}

#[test]
fn singular_values_of_thirty_joints_converge() {
    let rows = TaskMatrix::from_fn(64, 30, |i, j| (((i * i + 3 * j) * (j + 1)) as f64).sin());
    let decomposition = Decomposition::singular(&rows, rows.norm());
    assert_eq!(decomposition.rank(), 30);
    let p = pseudo_inverse(&decomposition, 64);
    assert!((p * rows.to_matrix() - Matrix::identity(30, 30)).amax() < 1e-11);
}

#[test]
fn what_is_asked_of_rows_of_nothing_reaches_no_other_row() {
    // Dependent rows, a row of zeros among them, and a small singular value to divide rounding by.
    let rows = [
        [1.0, 1.0, 0.0, 1.0, 2.0, 2.0, 2.0],
        [2.0, 2.0, 0.0, 2.0, 4.0, 4.0, 4.0],
        [0.0; 7],
        [0.0, 1.0, 0.0, 0.0, 1.0, -2.0, -2.0],
        [0.0, 1.0, 0.0, 0.0, 1.0, -2.0, -2.0],
        [1.002, 0.999, 0.0, 1.0, 1.999, 2.001, 2.001],
    ];
    let a = TaskMatrix::from_fn(6, 7, |i, j| rows[i][j]);
    let asked = &TaskVector::unit(6, 2) * 2.0;
    for decomposition in both_ways(&a) {
        assert_eq!(decomposition.solve(&asked).amax(), 0.0);
        assert_eq!(*decomposition.unreachable(&asked), *asked);
    }
}
