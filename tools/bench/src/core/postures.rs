//! Postures that the measurements use.

/// Returns postures of Sawyer, spread over the joint ranges by irrational strides.
pub fn postures(count: usize) -> Vec<[f64; 7]> {
    const STRIDES: [f64; 7] = [0.754_878, 0.569_840, 0.430_160, 0.324_718, 0.245_122, 0.185_037, 0.139_681];
    let posture = |i: usize| STRIDES.map(|stride| 4.0 * ((i as f64 * stride).fract() - 0.5));
    (1..=count).map(posture).collect()
}
