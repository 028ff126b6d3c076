use revprio_robot::built_in;

use super::*;

/// A period T at the last command u brings the point nearer by T (g·u + turn), up to terms of third order.
#[test]
fn the_bound_counts_the_turn_of_the_normal_on_the_way() {
    const PERIOD: f64 = 0.01;
    let mut turns = 0;
    for (seed, robot) in built_in()[..5].iter().enumerate() {
        let n = robot.joints().len();
        for case in 0..20 {
            let wave = |j: usize, scale: f64| scale * ((17 * seed + 5 * case + 3 * j) as f64).sin();
            let q: Vec<f64> = robot
                .joints()
                .iter()
                .enumerate()
                .map(|(j, joint)| {
                    let (lower, upper) = (joint.limits.lower.max(-3.0), joint.limits.upper.min(3.0));
                    0.5 * (lower + upper) + wave(j, 0.4 * (upper - lower))
                })
                .collect();
            let command: Vec<f64> = (0..n).map(|j| wave(j + 1, 1.0)).collect();
            let after = |share: f64| {
                let moved: Vec<f64> = q.iter().zip(&command).map(|(q, u)| q + share * PERIOD * u).collect();
                Configuration::new(robot, &moved).unwrap()
            };
            let (rest, half_way) = (after(0.0), after(0.5));
            let plane = VirtualPlane::new("plane", [0.3, -0.5, 0.8], 2.0, PlanePoint::Tool, APPROACH_RATE).unwrap();
            let ahead = Ahead { rest: &rest, half_way: &half_way, last_command: &command };
            let row = plane.at(&rest, Some(ahead), None);
            let turn = APPROACH_RATE * plane.distance(&rest) - row.bound();
            let approached = (plane.distance(&rest) - plane.distance(&after(1.0))) / PERIOD;
            let straight: f64 =
                plane.columns(&rest).zip(&command).map(|(column, u)| column.dot(&plane.normal) * u).sum();
            let expected = (approached - straight).max(0.0);
            assert!((turn - expected).abs() < 1e-4, "{} {case}: {turn} instead of {expected}", robot.name());
            turns += usize::from(expected > 1e-3);
        }
    }
    assert!(turns > 20, "{turns} turns");
}
