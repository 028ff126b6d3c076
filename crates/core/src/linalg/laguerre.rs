//! The outermost root of a polynomial with real roots.

/// Maximum number of steps. About four are needed, and about ten where roots coincide.
const MAX_STEPS: usize = 100;

/// How far from a whole number the multiplicity of the nearest root may seem to be. With more, distant roots look like one, and more steps pass
/// the root.
const MULTIPLICITY_ERROR: f64 = 0.01;

/// Returns the nearest root to the start of an interval, to rounding: the smallest or the largest one of a polynomial of this degree.
///
/// `derivatives` returns g = Σ 1/|x − λ_i| and h = Σ 1/(x − λ_i)² over its roots; `None` for x beyond the nearest one.
///
/// Laguerre's iteration never passes a single root, and converges cubically. Roots that lie close together would need many steps. So a step is
/// that for a root of the multiplicity g²/h, where this is close to a whole number. A step that passes the root is taken back, all but a little.
pub fn outermost_root(degree: usize, (start, end): (f64, f64), derivatives: impl Fn(f64) -> Option<(f64, f64)>) -> f64 {
    let (n, sign) = (degree as f64, 1_f64.copysign(end - start));
    let (mut before, mut x, mut behind, mut back) = (start, start, end, 4.0 * f64::EPSILON);
    for _ in 0..MAX_STEPS {
        if let Some((g, h)) = derivatives(x) {
            before = x;
            let ratio = g * g / h;
            let whole = ratio.round().clamp(1.0, n);
            let multiplicity = if (ratio - whole).abs() < MULTIPLICITY_ERROR { whole } else { 1.0 };
            let step = n / (g + ((n - multiplicity) / multiplicity * (n * h - g * g)).max(0.0).sqrt());
            x += sign * step;
            // Of a single root, the next distance is about the distance times the square of what the ratio is off.
            let is_single = multiplicity == 1.0 && step * (ratio - 1.0).powi(2) <= 1e-17 * x;
            if is_single || step <= 1e-16 * before {
                return x;
            }
        } else {
            behind = x;
        }
        let gap = sign * (behind - before);
        if gap <= 1e-15 * before {
            break;
        }
        if sign * (behind - x) <= 0.0 {
            x = behind - sign * (back * before.max(behind)).min(0.5 * gap);
            back *= 16.0;
        }
    }
    before
}
