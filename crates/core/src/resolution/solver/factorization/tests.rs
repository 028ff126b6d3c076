//! The factorisation and its solution on random working sets, compared with dense matrices, and ranks near their thresholds.
#![allow(non_snake_case)]

use super::*;
use crate::linalg::{Matrix, RANK_TOLERANCE, Svd, Vector};
use crate::resolution::hierarchy::Hierarchy;
use crate::resolution::solver::tests::{RandomSet, WIDTH};

/// Returns the entries of a over the coordinates of a factorisation.
fn over_coordinates(solved: &Factorization<WIDTH>, a: &Row<WIDTH>) -> Vec<f64> {
    (0..solved.free.len()).map(|c| solved.q_column(c).dot(a)).collect()
}

fn is_near(found: &[f64], expected: &[f64], size: f64) -> bool {
    found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= 1e-11 * size)
}

/// A = L Qᵀ with the longest remaining row as each pivot, and the least-squares point of pseudo-inverses.
#[test]
fn the_factorisation_is_a_triangle_and_its_point_is_that_of_pseudo_inverses() {
    let mut residuals = 0;
    for seed in 0..1000 {
        let of = RandomSet::new(seed);
        let (problem, solved) = (of.problem(), &of.solved);
        let n = problem.unknowns;
        let x = of.point();
        let speed = solved.peak_speed;
        assert!(is_near(&solved.x.0[..n], x.as_slice(), speed), "seed {seed}: {:?} {x}", solved.x);
        let base_norm = solved.held.iter().map(|&j| solved.base.0[j].powi(2)).sum::<f64>().sqrt();
        assert!((solved.base_norm - base_norm).abs() < 1e-15 && speed >= solved.base_norm + solved.y.norm());
        assert!(is_near(
            &solved.reference.0,
            &over_coordinates(solved, &problem.reference.times(&solved.is_free)),
            1.0
        ));
        let projectors = of.projectors();
        let mut first = 0;
        for (k, span) in solved.spans.iter().enumerate() {
            let taken = projectors[k].trace() - projectors[k + 1].trace();
            let rank = (0..WIDTH).take_while(|&rank| rank as f64 + 0.5 < taken).count();
            assert_eq!(
                (span.first, span.rank(), span.rank_end()),
                (first, rank, first + rank),
                "seed {seed}, level {k}"
            );
            first += rank;
            let norm = problem.levels[k].norm;
            let rows = &solved.rows[span.start..span.end];
            let left: Vec<f64> =
                rows.iter().map(|row| row.target - solved.x.dot(&problem.coefficients[row.index])).collect();
            let size = span.target + norm * speed;
            assert!(is_near(&rows.iter().map(|row| row.residual).collect::<Vec<_>>(), &left, size), "seed {seed}");
            let largest = left.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
            assert_eq!(span.has_residual, largest > 1e-10 * size, "seed {seed}: {largest:e}");
            residuals += usize::from(span.has_residual);
            for (place, row) in rows.iter().enumerate() {
                let mut expected = over_coordinates(solved, &solved.is_free.times(&problem.coefficients[row.index]));
                assert!(expected[span.rank_end()..].iter().all(|entry| entry.abs() <= 1e-11 * norm), "seed {seed}");
                expected[span.rank_end()..].fill(0.0);
                assert!(is_near(&row.coordinates.0, &expected, norm), "seed {seed}, row {}", row.index);
                // What is left of a later row is not longer than the pivot.
                for c in span.first..span.rank_end().min(span.first + place) {
                    let pivot = 1.0 / rows[c - span.first].inverse;
                    let left = row.coordinates.0[c..span.rank_end()].iter().map(|entry| entry * entry).sum::<f64>();
                    assert!(left.sqrt() <= pivot.abs() * (1.0 + 1e-9), "seed {seed}, level {k}");
                    assert!((pivot - rows[c - span.first].coordinates.0[c]).abs() <= 1e-12 * norm);
                }
            }
        }
        assert_eq!(solved.rank(), first);
    }
    assert!(residuals > 200, "{residuals}");
}

/// Solves levels of rows a·x = b on the empty working set.
fn solved(levels: &[&[([f64; 3], f64)]], unit: f64) -> Factorization<WIDTH> {
    let mut hierarchy = Hierarchy::default();
    hierarchy.clear(&[0.0; 3]);
    hierarchy.set_width(WIDTH);
    for rows in levels {
        rows.iter().for_each(|(row, b)| hierarchy.push_equation(row.iter().map(|a| unit * a), unit * b));
        hierarchy.end_level();
    }
    let mut set = WorkingSet::default();
    set.clear(3, hierarchy.rows.len());
    RandomSet::of(hierarchy, set).solved
}

/// Two rows with the angle ε: σ_min = ε ‖A‖ / 2.
#[test]
fn ranks_change_at_the_tolerance_and_are_uncertain_around_it() {
    for unit in [1.0, 1e-3, 1e3] {
        for (ratio, rank, is_uncertain) in [
            (1.3e-6, 2, false),
            (0.8e-6, 2, true),
            (1.3e-10, 2, true),
            // The pivot is above the tolerance, the singular value below it.
            (0.8e-10, 1, true),
            (0.6e-10, 1, true),
            (1.5e-13, 1, true),
            (0.5e-13, 1, false),
        ] {
            let rows = [([1.0, 0.0, 0.0], 1.0), ([1.0, 2.0 * ratio, 0.0], 1.0)];
            let found = solved(&[&rows], unit);
            assert_eq!((found.rank(), found.rank_uncertain), (rank, is_uncertain), "{ratio:e}, unit {unit}");
        }
    }
}

/// After a pivot of 10⁻⁶, the directions that it leaves are known up to 10⁻⁸.
#[test]
fn a_level_below_a_weak_pivot_has_a_larger_tolerance() {
    let rank = |angle: f64, open: f64, unit: f64| {
        let upper = [([1.0, 0.0, 0.0], 0.0), ([1.0, angle, 0.0], 0.0)];
        let rank = solved(&[&upper, &[([0.0, 1.0, open], 1.0)]], unit).spans[1].rank();
        let behind = solved(&[&upper, &[([1.0, 0.0, 0.0], 0.0)], &[([0.0, 1.0, open], 1.0)]], unit).spans[2].rank();
        assert_eq!(rank, behind, "a level between changes nothing");
        rank
    };
    for unit in [1.0, 1e3] {
        // 4·10⁻¹⁵ / (10⁻⁶ / √2) = 5.7·10⁻⁹
        assert_eq!((rank(1e-6, 4.5e-9, unit), rank(1e-6, 7e-9, unit)), (0, 1));
        assert_eq!((rank(1.0, 0.8e-10, unit), rank(1.0, 1.3e-10, unit), rank(1.0, 4.5e-9, unit)), (0, 1, 1));
    }
}

/// x = 1 is met first, and then moves to the mean of 1 and −3.
#[test]
fn the_peak_speed_is_that_of_the_way() {
    let a = [1.0, 0.0, 0.0];
    let found = solved(&[&[(a, 1.0), (a, -3.0)]], 1.0);
    assert!((found.x.0[0] + 1.0).abs() < 1e-15 && (found.peak_speed - 3.0).abs() < 1e-15, "{found:?}");
    let twice = solved(&[&[(a, 1.0), (a, -3.0)], &[([0.0, 1.0, 0.0], 0.5)]], 1.0);
    assert!((twice.peak_speed - 3.0).abs() < 1e-15, "{}", twice.peak_speed);
}

/// Squared lengths that are kept up to date by subtraction alone would be rounding here.
#[test]
fn nearly_parallel_rows_are_taken_in_the_order_of_what_is_left_of_them() {
    for angle in [1e-7_f64, 1e-8, 1e-9] {
        let rows = [([1.0, 0.0, 0.0], 0.0), ([1.0, angle, 0.0], 0.0), ([1.0, angle, 1.5 * angle], 0.0)];
        let found = solved(&[&rows], 1.0);
        let [second, third] = [1, 2].map(|c| found.rows[c].coordinates.0[c].abs());
        // From the last row: √3.25 ε and then 1.5/√3.25 ε; from the first one the same.
        assert!((second / angle - 3.25_f64.sqrt()).abs() < 1e-4, "{angle:e}: {second:e}");
        assert!((third / angle - 1.5 / 3.25_f64.sqrt()).abs() < 1e-4, "{angle:e}: {third:e}");
    }
}

#[test]
fn a_small_inconsistency_is_rounding_and_a_larger_one_a_residual() {
    let a = [0.6, 0.8, 0.0];
    for unit in [1.0, 1e6] {
        let residual = |off: f64| solved(&[&[(a, 1.0), (a, 1.0 + off)]], unit).spans[0].has_residual;
        // ‖b‖ + ‖A‖ ‖x‖ = 2√2
        assert_eq!((residual(2.4e-13), residual(3.3e-13)), (false, true));
    }
}

#[test]
fn singular_values_of_the_triangle_are_those_of_the_rows() {
    let A = Matrix::from_row_slice(2, 3, &[1.0, 2.0, 3.0, -1.0, 0.5, 2.0]);
    let found = solved(&[&[([1.0, 2.0, 3.0], 1.0)], &[([-1.0, 0.5, 2.0], 2.0)]], 1.0);
    let product: f64 = found.triangle().map(|row| 1.0 / row.inverse.abs()).product();
    assert!((product - Svd::new(&A).singular_values().iter().product::<f64>()).abs() < 1e-12);
    let x = Svd::new(&A).solve(2, 0.0, &Vector::from_vec(vec![1.0, 2.0]));
    assert!(is_near(&found.x.0[..3], x.as_slice(), 1.0));
    assert_eq!(found.rank_tolerance, RANK_TOLERANCE);
}
