use super::*;

#[test]
fn wide_and_tall_matrices_are_the_products_of_their_parts() {
    let entry = |i: usize, j: usize| ((3 * i + 5 * j * j + i * j) % 7) as f64 - 2.5;
    let mut svd = Svd::default();
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
