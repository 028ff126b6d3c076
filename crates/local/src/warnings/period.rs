//! A warning about a control period that is probably in milliseconds.

/// The longest period that is not reported, s. Arms are moved every 0.5 to 20 ms.
const LONGEST_S: f64 = 1.0;

/// Returns the warning about a control period T, s.
pub fn warning(period_s: f64) -> Option<String> {
    (period_s > LONGEST_S).then(|| {
        format!("`period_s` is {period_s} s, and control periods are usually 0.0005 to 0.02 s; is it in milliseconds?")
    })
}
