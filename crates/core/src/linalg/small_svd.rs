//! Singular values and vectors in memory that is used again.

use super::svd::orthogonalize;

/// A = U diag(σ) Vᵀ with min(m, n) singular values in descending order, overwritten by each decomposition.
#[derive(Debug, Clone, Default)]
pub struct SmallSvd {
    /// A row for each singular value: σ times the vector of the longer side, then the vector of the shorter side.
    entries: Vec<f64>,
    /// The rows by descending singular value.
    order: Vec<usize>,
    sigma: Vec<f64>,
    longer: usize,
    stride: usize,
    is_tall: bool,
}

impl SmallSvd {
    /// Decomposes the m × n matrix with these entries (row, column).
    pub fn decompose(&mut self, m: usize, n: usize, entry: impl Fn(usize, usize) -> f64) {
        let shorter = m.min(n);
        (self.is_tall, self.longer, self.stride) = (m > n, m.max(n), m + n);
        self.entries.clear();
        for i in 0..shorter {
            for j in 0..self.longer {
                self.entries.push(if self.is_tall { entry(j, i) } else { entry(i, j) });
            }
            self.entries.extend((0..shorter).map(|j| if i == j { 1.0 } else { 0.0 }));
        }
        let Self { entries, order, sigma, longer, stride, .. } = self;
        orthogonalize(entries, *stride, *longer);
        sigma.clear();
        sigma.extend(entries.chunks_exact(*stride).map(|row| row[..*longer].iter().map(|x| x * x).sum::<f64>().sqrt()));
        order.clear();
        order.extend(0..shorter);
        order.sort_unstable_by(|&a, &b| sigma[b].total_cmp(&sigma[a]));
    }

    /// Returns the number of singular values, min(m, n).
    pub fn count(&self) -> usize {
        self.order.len()
    }

    /// Returns the singular value of this place, 0 = largest.
    pub fn sigma(&self, place: usize) -> f64 {
        self.sigma[self.order[place]]
    }

    /// Returns the number of singular values above `tolerance`.
    pub fn rank(&self, tolerance: f64) -> usize {
        (0..self.count()).take_while(|&place| self.sigma(place) > tolerance).count()
    }

    /// Returns the left singular vector of a singular value that is not zero, m.
    pub fn left(&self, place: usize) -> impl Iterator<Item = f64> {
        self.vector(place, self.is_tall)
    }

    /// Returns the right singular vector of a singular value that is not zero, n.
    pub fn right(&self, place: usize) -> impl Iterator<Item = f64> {
        self.vector(place, !self.is_tall)
    }

    fn vector(&self, place: usize, is_longer: bool) -> impl Iterator<Item = f64> {
        let row = &self.entries[self.order[place] * self.stride..][..self.stride];
        let (own, unit) = if is_longer { (&row[..self.longer], self.sigma(place)) } else { (&row[self.longer..], 1.0) };
        own.iter().map(move |entry| entry / unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_and_tall_matrices_are_the_products_of_their_parts() {
        let entry = |i: usize, j: usize| ((3 * i + 5 * j * j + i * j) % 7) as f64 - 2.5;
        let mut svd = SmallSvd::default();
        for (m, n) in [(2, 4), (4, 2), (3, 3), (1, 1)] {
            svd.decompose(m, n, entry);
            assert_eq!((svd.count(), svd.rank(1e-9)), (m.min(n), m.min(n)));
            assert!((1..svd.count()).all(|place| svd.sigma(place) <= svd.sigma(place - 1)));
            for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let part = |place| {
                    svd.sigma(place) * svd.left(place).nth(i).unwrap_or(0.0) * svd.right(place).nth(j).unwrap_or(0.0)
                };
                let sum: f64 = (0..svd.count()).map(part).sum();
                assert!((sum - entry(i, j)).abs() < 1e-12, "{m} x {n}: {sum}");
            }
        }
    }
}
