//! Sine and cosine of one angle, computed without branches.
//!
//! In a loop over many angles, the compiler therefore computes two or four of them per instruction. The formulas are
//! those of fdlibm. They contain no fused multiply-add, so the results have the same bits on every machine.

use std::f64::consts::FRAC_2_PI;

/// Largest angle of [`sin_cos`], rad: the products of k and the first two parts of [`HALF_PI`] are exact up to here.
pub const MAX_ANGLE: f64 = 5e5;

/// 1.5 · 2^52. Adding it rounds a smaller number to an integer and leaves this integer in the lowest bits of the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// π/2 as a sum. The first two parts have 33 significant bits.
const HALF_PI: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];

/// Coefficients of r³, r⁵, … in r − sin r.
const SINE: [f64; 6] = [
    1.666_666_666_666_663_2e-1,
    -8.333_333_333_322_49e-3,
    1.984_126_982_985_795e-4,
    -2.755_731_370_707_006_8e-6,
    2.505_076_025_340_686_3e-8,
    -1.589_690_995_211_55e-10,
];

/// Coefficients of r⁴, r⁶, … in cos r − (1 − r²/2).
const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Returns sine and cosine of an angle up to [`MAX_ANGLE`], each within 1 ulp of the exact value.
#[inline]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    let (k, r, excess) = reduce(angle);
    let (sine, cosine) = (sine_of_reduced(r, excess).to_bits(), cosine_of_reduced(r, excess).to_bits());
    // If k is odd, sine and cosine are exchanged. Bit 1 of k is the sign of the sine, that of k + 1 the cosine's.
    let exchange = (sine ^ cosine) & (k & 1).wrapping_neg();
    let sine_sign = (k & 2) << 62;
    let cosine_sign = (k.wrapping_add(1) & 2) << 62;
    (f64::from_bits(sine ^ exchange ^ sine_sign), f64::from_bits(cosine ^ exchange ^ cosine_sign))
}

/// Returns k, r and excess with angle = k π/2 + r − excess and |r| ≤ π/4. Only the two lowest bits of k are valid.
#[inline]
fn reduce(angle: f64) -> (u64, f64, f64) {
    let rounded = angle * FRAC_2_PI + ROUNDER;
    let k = rounded - ROUNDER;
    let first = angle - k * HALF_PI[0];
    let step = k * HALF_PI[1];
    let second = first - step;
    // The third part, without the rounding error of `second`.
    let correction = k * HALF_PI[2] - ((first - second) - step);
    let r = second - correction;
    (rounded.to_bits(), r, correction - (second - r))
}

/// Returns sin(r − excess) for |r| ≤ π/4.
#[inline]
fn sine_of_reduced(r: f64, excess: f64) -> f64 {
    let square = r * r;
    r - (excess + square * r * polynomial(&SINE, square))
}

/// Returns cos(r − excess) for |r| ≤ π/4.
#[inline]
fn cosine_of_reduced(r: f64, excess: f64) -> f64 {
    let square = r * r;
    let half = 0.5 * square;
    let leading = 1.0 - half;
    leading + (((1.0 - leading) - half) + (square * square * polynomial(&COSINE, square) + r * excess))
}

/// Returns Σ `coefficients`\[i\] xⁱ.
#[inline]
fn polynomial<const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    coefficients.iter().rev().copied().reduce(|sum, coefficient| sum * x + coefficient).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use proptest::prelude::*;

    use super::*;

    /// Returns how many floating-point numbers `a` is away from `b`.
    fn ulps(a: f64, b: f64) -> u64 {
        let place =
            |x: f64| if x.is_sign_negative() { -x.abs().to_bits().cast_signed() } else { x.to_bits().cast_signed() };
        place(a).abs_diff(place(b))
    }

    /// Returns the larger distance of sine and cosine from those of the standard library.
    fn distance(angle: f64) -> u64 {
        let ((sine, cosine), (expected_sine, expected_cosine)) = (sin_cos(angle), angle.sin_cos());
        ulps(sine, expected_sine).max(ulps(cosine, expected_cosine))
    }

    #[test]
    fn tiny_angles_and_both_zeros_are_their_own_sines() {
        for angle in [0.0, 5e-324, 1e-300, 1e-20, 1e-9] {
            for angle in [angle, -angle] {
                assert_eq!((sin_cos(angle).0.to_bits(), sin_cos(angle).1), (angle.to_bits(), 1.0), "{angle:e}");
            }
        }
    }

    #[test]
    fn angles_next_to_multiples_of_half_pi_are_exact_to_one_ulp() {
        let multiples = (0..318_309).map(|k| f64::from(k) * FRAC_PI_2).take_while(|angle| *angle < MAX_ANGLE);
        for multiple in multiples.flat_map(|angle| [angle, -angle]) {
            for angle in [multiple.next_down(), multiple, multiple.next_up()] {
                assert!(distance(angle) <= 1, "{angle:e}");
            }
        }
    }

    #[test]
    fn last_bits_rarely_differ_from_the_standard_library() {
        // A reduction without the excess would make one bit in four differ.
        let differ = (0..10_000).filter(|i| distance(f64::from(*i) * 0.01 - 50.0) > 0).count();
        assert!(differ < 1500, "{differ} of 10000");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn angles_of_every_size_are_exact_to_one_ulp(
            angle in prop_oneof![-1.0..1.0, -7.0..7.0, -1e3..1e3, -MAX_ANGLE..=MAX_ANGLE],
            exponent in -300..0_i32,
        ) {
            prop_assert!(distance(angle) <= 1, "{angle:e}");
            let small = angle * 10.0_f64.powi(exponent);
            prop_assert!(distance(small) <= 1, "{small:e}");
        }
    }
}
