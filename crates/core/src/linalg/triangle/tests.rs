#![allow(non_snake_case)]

use super::*;
use crate::linalg::Matrix;

/// M = H diag(λ) H for a reflection H, with λ_min from 0 to about the trace, alone, several times, and with others close to it.
#[test]
fn the_smallest_eigenvalue_is_exact_to_the_rounding_of_the_trace() {
    for size in [1, 2, 3, 5, 8] {
        for (smallest, apart) in [0.0, 1e-12, 1e-6, 1e-3, 0.5, 1.0]
            .into_iter()
            .flat_map(|smallest| [0.0, 1e-12, 1e-8, 1e-6, 1e-4, 1e-2].map(|apart| (smallest, apart)))
        {
            for copies in 1..=size {
                let lambda = |i: usize| smallest + if i < copies { apart * i as f64 } else { (i * i) as f64 };
                let v = Matrix::from_fn(size, 1, |i, _| 1.0 + (3 * i % 5) as f64);
                let H = Matrix::identity(size, size) - 2.0 / v.norm_squared() * &v * v.transpose();
                let M = &H * Matrix::from_fn(size, size, |i, j| if i == j { lambda(i) } else { 0.0 }) * &H;
                let mut entries = M.as_slice().to_vec();
                let found = smallest_eigenvalue(&mut entries, size, &mut Vec::new());
                assert!(
                    (found - smallest).abs() <= 1e-13 * (1.0 + M.trace()),
                    "{size} {smallest} {apart} {copies}: {found:e}"
                );
            }
        }
    }
}
