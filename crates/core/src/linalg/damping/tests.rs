use super::*;

#[test]
fn damping_is_zero_at_and_above_the_threshold_and_full_at_zero() {
    let damping = Damping::STANDARD;
    assert_eq!(damping.factor(0.05), 0.0);
    assert_eq!(damping.factor(1.0), 0.0);
    assert_eq!(damping.factor(0.0), 0.1);
    assert!(damping.factor(0.05 - 1e-9) > 0.0);
    assert!((damping.factor(0.03).powi(2) - (1.0 - 0.36) * 0.01).abs() < 1e-15);
}
