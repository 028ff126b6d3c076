//! What the last factorisation tells, compared with singular values of dense matrices.
#![allow(non_snake_case)]

use revprio_problem::MAX_UNKNOWNS;

use super::*;
use crate::linalg::{Matrix, Svd, Vector, smallest_and_product};
use crate::resolution::solver::tests::{below, numbers};

/// Returns levels of random rows for n unknowns, a third of which depend on the one before.
fn levels(seed: u64) -> Hierarchy {
    let mut number = numbers(seed);
    let mut below = |count: usize| below(number(), count);
    let (n, counts) = (2 + below(6), (0..=below(3)).map(|_| 1 + below(4)).collect::<Vec<_>>());
    let mut number = numbers(seed + 1_000_000);
    let mut hierarchy = Hierarchy::default();
    hierarchy.clear(&vec![0.0; n]);
    for count in counts {
        let mut A = Matrix::from_fn(count, n, |_, _| number());
        for i in 1..count {
            if number() > 0.4 {
                A.set_row(i, &(2.0 * A.row(i - 1)));
            }
        }
        hierarchy.push_equations(&A, |_| 0.5);
        hierarchy.end_level();
    }
    hierarchy
}

#[test]
fn the_last_factorisation_tells_the_singular_values() {
    let (mut full, mut deficient) = (0, 0);
    for seed in 0..500 {
        let hierarchy = levels(seed);
        let n = hierarchy.unknowns;
        let mut solver = HierarchicalSolver::default();
        let solver = solver.of_width(&hierarchy);
        solver.solve(&hierarchy, Start::default(), &mut Solution::default());
        let all = Matrix::from_fn(hierarchy.rows.len(), n, |i, j| hierarchy.row(i)[j]);
        let norm = hierarchy.equation_norm();
        let sigma = Svd::new(&all).singular_values().to_vec();
        if all.nrows() > n || sigma[sigma.len() - 1] < 1e-9 {
            deficient += 1;
            assert!(solver.bound_smallest(norm, 0.0, 0.0).is_nan(), "seed {seed}");
        } else {
            full += 1;
            let product = sigma.iter().product::<f64>();
            let (found, found_product) = smallest_and_product(&all);
            assert!((found_product - product).abs() < 1e-11 * product);
            assert!((found - sigma[sigma.len() - 1]).abs() < 1e-12);
            // 1/‖A⁺‖_F
            let certain = sigma.iter().map(|sigma| 1.0 / (sigma * sigma)).sum::<f64>().sqrt().recip();
            let found = [0.999, 1.001].map(|factor| solver.bound_smallest(norm, f64::INFINITY, factor * certain));
            assert!((found[0] - certain).abs() < 1e-9 * certain, "seed {seed}");
            assert!((found[1] - sigma[sigma.len() - 1]).abs() < 1e-12, "seed {seed}");
            let others = sigma.len() as f64 - 1.0;
            let quick = product * (others / all.norm_squared()).powf(0.5 * others);
            assert!((solver.bound_smallest(norm, 0.999 * quick, certain) - quick).abs() < 1e-9 * quick, "seed {seed}");
            assert!(quick <= found[1] * (1.0 + 1e-12), "seed {seed}");
            assert!((norm - all.norm()).abs() < 1e-12 * all.norm());
        }
    }
    assert!(full > 100 && deficient > 200, "{full} {deficient}");
}

#[test]
fn each_number_of_unknowns_has_a_solver() {
    for n in [1, 4, 5, 8, 9, 16, 17, 24, 25, 32, 33, 40, 41, 72, 73, MAX_UNKNOWNS] {
        let mut hierarchy = Hierarchy::default();
        hierarchy.clear(&vec![0.0; n]);
        hierarchy.push_equation((0..n).map(|_| 1.0), 1.0);
        hierarchy.end_level();
        let (mut solver, mut solution) = (HierarchicalSolver::default(), Solution::default());
        solver.of_width(&hierarchy).solve(&hierarchy, Start::default(), &mut solution);
        assert!(solution.x.iter().all(|x| (x * n as f64 - 1.0).abs() < 1e-12), "{n} unknowns");
        assert!(solution.certainty.is_optimal && solution.certainty.kkt_residual < 1e-14);
    }
}

/// The strict hierarchy by pseudo-inverses, level by level.
#[test]
fn a_solution_is_regular_where_no_level_is_near_singular_on_what_is_left() {
    const LEAST: f64 = 0.3;
    let (mut regular, mut refused, mut emptied) = (0, 0, 0);
    for seed in 0..2000 {
        let hierarchy = levels(seed);
        let n = hierarchy.unknowns;
        let mut solver = HierarchicalSolver::default();
        let solver = solver.of_width(&hierarchy);
        solver.factorize(&hierarchy);
        let (mut x, mut kept, mut left) = (Vector::zeros(n), Matrix::zeros(n, n), n);
        let (mut is_regular, mut has_dependent_rows, mut has_emptied) = (true, false, false);
        for level in &hierarchy.levels {
            let rows = Matrix::from_fn(level.end - level.start, n, |i, j| hierarchy.row(level.start + i)[j]);
            let svd = Svd::new(&(&rows - &rows * &kept));
            let open = svd.count().min(left);
            let rank = svd.rank(1e-9).min(open);
            has_emptied |= rank == 0;
            has_dependent_rows |= (1..rows.nrows()).contains(&rank);
            is_regular &= rank == 0 || svd.sigma(open - 1) >= LEAST;
            let missing = Vector::from_element(rows.nrows(), 0.5) - &rows * &x;
            x += svd.solve(rank, 0.0, &missing);
            kept += svd.row_projector(rank);
            left -= rank;
        }
        let found = solver.regular_solution(LEAST);
        assert!(found.is_none_or(|(_, is_emptied)| is_emptied == has_emptied), "seed {seed}");
        let found = found.map(|(found, _)| Vector::from_column_slice(&found[..n]));
        regular += usize::from(found.is_some());
        refused += usize::from(found.is_none());
        emptied += usize::from(has_emptied);
        // Fewer rows have smaller singular values.
        assert!(found.is_some() == is_regular || (is_regular && has_dependent_rows), "seed {seed}");
        if let Some(found) = found {
            assert!((&found - &x).amax() < 1e-12 * (1.0 + x.amax()), "seed {seed}: {found} instead of {x}");
        }
    }
    assert!(regular > 100 && refused > 100 && emptied > 100, "{regular} regular, {refused} refused, {emptied} emptied");
}
