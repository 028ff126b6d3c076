//! Set-points over time: [`Profile`] gives a value with its first and second derivative at any time.

mod set_point;
mod spline;

use nalgebra::DVector;

use self::spline::Spline;

pub use set_point::{Entries, Point, SetPoint};

/// Minimum duration of a ramp and minimum time between two points, s. Use steps for faster changes.
pub const MIN_DURATION: f64 = 1e-6;

/// A set-point as a function of time, m rows.
///
/// | constructor | value | derivatives |
/// |---|---|---|
/// | [`Profile::constant`] | the same at all times | 0 |
/// | [`Profile::sine`] | offset + amplitude sin(ω t + φ) | exact; with a start, the rate is 0 before it |
/// | [`Profile::ramp`] | linear from one value to another, constant before and after | exact; the rate jumps at both ends |
/// | [`Profile::steps`] | the value of the last point passed | 0 |
/// | [`Profile::waypoints`] | a smooth curve through all points, at rest before the first and after the last | exact; both are continuous |
#[derive(Debug, Clone, PartialEq)]
pub struct Profile(Shape);

#[derive(Debug, Clone, PartialEq)]
enum Shape {
    Constant(DVector<f64>),
    Sine { offset: DVector<f64>, amplitude: DVector<f64>, angular_frequency: f64, phase: f64, start_time: f64 },
    Ramp { start: DVector<f64>, end: DVector<f64>, start_time: f64, duration: f64 },
    Steps(Vec<Point>),
    Waypoints(Spline),
}

/// Why a profile is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ProfileError {
    /// A value is NaN or infinite.
    #[error("profile values must be finite numbers")]
    NotFinite,
    /// The values of a profile differ in length.
    #[error("{given} values, but {expected} in the first list; give one value per axis in each list")]
    Size {
        /// Length of the first value.
        expected: usize,
        /// Length of the value that differs.
        given: usize,
    },
    /// The list of points is empty.
    #[error("give at least one point")]
    NoPoints,
    /// The times of two points are out of order or closer than [`MIN_DURATION`].
    #[error("the times of the points must increase by at least 1e-6 s from point to point")]
    Times {
        /// Index of the second of the two points, from 0.
        point: usize,
    },
    /// The duration of a ramp is shorter than [`MIN_DURATION`].
    #[error("the duration of a ramp must be at least 1e-6 s; use steps for a step")]
    Duration,
}

impl Profile {
    /// Returns a profile with the same value at all times.
    pub fn constant(value: Vec<f64>) -> Result<Self, ProfileError> {
        check_finite(&value)?;
        Ok(Self(Shape::Constant(DVector::from_vec(value))))
    }

    /// Returns offset + amplitude sin(ω t + φ), with ω `angular_frequency` in rad/s and φ `phase` in rad.
    pub fn sine(
        offset: Vec<f64>,
        amplitude: Vec<f64>,
        angular_frequency: f64,
        phase: f64,
    ) -> Result<Self, ProfileError> {
        check_finite(&[angular_frequency, phase])?;
        let [offset, amplitude] = pair(offset, amplitude)?;
        Ok(Self(Shape::Sine { offset, amplitude, angular_frequency, phase, start_time: f64::NEG_INFINITY }))
    }

    /// Returns a sine that rests before a time, s, at its value of that time. Without a time, and of another kind, a profile stays as it is.
    pub fn starting_at(mut self, time: Option<f64>) -> Result<Self, ProfileError> {
        if let (Shape::Sine { start_time, .. }, Some(time)) = (&mut self.0, time) {
            check_finite(&[time])?;
            *start_time = time;
        }
        Ok(self)
    }

    /// Returns a ramp from `start` to `end` at constant rate that begins at `start_time` and lasts `duration`, s.
    pub fn ramp(start: Vec<f64>, end: Vec<f64>, start_time: f64, duration: f64) -> Result<Self, ProfileError> {
        check_finite(&[start_time, duration])?;
        if duration < MIN_DURATION {
            return Err(ProfileError::Duration);
        }
        let [start, end] = pair(start, end)?;
        Ok(Self(Shape::Ramp { start, end, start_time, duration }))
    }

    /// Returns a profile that holds the value of the last point passed, and before the first point its value.
    pub fn steps(points: Vec<Point>) -> Result<Self, ProfileError> {
        check_points(&points)?;
        Ok(Self(Shape::Steps(points)))
    }

    /// Returns a curve through all points, twice continuously differentiable, at rest at the first and the last point.
    ///
    /// Between inner points it is the cubic spline. The first and the last piece are quintics, so that motion begins
    /// and ends without a jump of acceleration. If the spacing of the points is very unequal, the curve may overshoot
    /// between them.
    pub fn waypoints(points: &[Point]) -> Result<Self, ProfileError> {
        check_points(points)?;
        Ok(Self(Shape::Waypoints(Spline::through(points).ok_or(ProfileError::NotFinite)?)))
    }

    /// Returns m, the number of entries.
    pub fn rows(&self) -> usize {
        match &self.0 {
            Shape::Constant(value) => value.len(),
            Shape::Sine { offset, .. } => offset.len(),
            Shape::Ramp { start, .. } => start.len(),
            Shape::Steps(points) => points[0].value.len(),
            Shape::Waypoints(spline) => spline.rows(),
        }
    }

    /// Returns whether the value is the same at all times.
    pub fn is_constant(&self) -> bool {
        matches!(self.0, Shape::Constant(_))
    }

    /// Returns whether the value jumps at some time.
    pub fn jumps(&self) -> bool {
        matches!(&self.0, Shape::Steps(points) if points.len() > 1)
    }

    /// Returns of each entry the value that is farthest from zero, at the points of the profile.
    pub fn largest(&self) -> Entries {
        self.fold(|a, b| if b.abs() > a.abs() { b } else { a })
    }

    /// Returns the smallest and the largest value of each entry, at the points of the profile; 0 if all are on its other side.
    pub fn range(&self) -> [Entries; 2] {
        [self.fold(f64::min), self.fold(f64::max)]
    }

    /// Combines 0 with the extreme values of each entry, those of a sine from the one that is farther from zero on.
    fn fold(&self, combine: impl Fn(f64, f64) -> f64) -> Entries {
        let all = |points: &mut dyn Iterator<Item = &[f64]>| {
            points.fold(Entries::from_elem(0.0, self.rows()), |found, value| {
                found.iter().zip(value).map(|(a, b)| combine(*a, *b)).collect()
            })
        };
        match &self.0 {
            Shape::Constant(value) => all(&mut [value.as_slice()].into_iter()),
            Shape::Sine { offset, amplitude, .. } => {
                let far = offset.zip_map(amplitude, |offset, a| offset + a.abs().copysign(offset));
                let near = offset.zip_map(amplitude, |offset, a| offset - a.abs().copysign(offset));
                all(&mut [far.as_slice(), near.as_slice()].into_iter())
            }
            Shape::Ramp { start, end, .. } => all(&mut [start.as_slice(), end.as_slice()].into_iter()),
            Shape::Steps(points) => all(&mut points.iter().map(|point| point.value.as_slice())),
            Shape::Waypoints(spline) => all(&mut spline.values()),
        }
    }

    /// Returns bounds of |value| and of |rate| at all times, m entries each. They are exact, except that a curve through
    /// waypoints may stay below its bounds.
    pub fn bounds(&self) -> [Entries; 2] {
        let sizes = |entries: Entries| entries.iter().map(|entry| entry.abs()).collect();
        let value = |profile: &Self| sizes(profile.largest());
        match &self.0 {
            Shape::Constant(_) | Shape::Steps(_) => [value(self), Entries::from_elem(0.0, self.rows())],
            Shape::Sine { amplitude, angular_frequency, .. } => {
                [value(self), amplitude.iter().map(|a| (a * angular_frequency).abs()).collect()]
            }
            Shape::Ramp { start, end, duration, .. } => {
                [value(self), (end - start).iter().map(|change| change.abs() / duration).collect()]
            }
            Shape::Waypoints(spline) => spline.bounds(),
        }
    }

    /// Returns value and derivatives at time t, s.
    pub fn at(&self, time_s: f64) -> SetPoint {
        match &self.0 {
            Shape::Constant(value) => SetPoint::resting(Entries::from_slice(value.as_slice())),
            Shape::Sine { offset, amplitude, angular_frequency: omega, phase, start_time } => {
                let (sine, cosine) = (omega * time_s.max(*start_time) + phase).sin_cos();
                let moves = f64::from(time_s >= *start_time);
                let (rate, acceleration) = (moves * omega * cosine, -moves * omega * omega * sine);
                let times_amplitude = |factor: f64| amplitude.iter().map(|a| a * factor).collect();
                SetPoint {
                    value: offset.iter().zip(amplitude).map(|(offset, a)| offset + a * sine).collect(),
                    rate: times_amplitude(rate),
                    acceleration: times_amplitude(acceleration),
                }
            }
            Shape::Ramp { start, end, start_time, duration } => {
                let fraction = (time_s - start_time) / duration;
                let clamped = fraction.clamp(0.0, 1.0);
                let change: Entries = end.iter().zip(start).map(|(end, start)| end - start).collect();
                let mut point = SetPoint::resting(
                    start.iter().zip(&change).map(|(start, change)| start + change * clamped).collect(),
                );
                if (0.0..1.0).contains(&fraction) {
                    point.rate = change.iter().map(|change| change / duration).collect();
                }
                point
            }
            Shape::Steps(points) => {
                let passed = points.partition_point(|point| point.time_s <= time_s);
                SetPoint::resting(Entries::from_slice(&points[passed.saturating_sub(1)].value))
            }
            Shape::Waypoints(spline) => spline.at(time_s),
        }
    }
}

fn pair(first: Vec<f64>, second: Vec<f64>) -> Result<[DVector<f64>; 2], ProfileError> {
    check_finite(&first)?;
    check_finite(&second)?;
    if first.len() != second.len() {
        return Err(ProfileError::Size { expected: first.len(), given: second.len() });
    }
    Ok([first, second].map(DVector::from_vec))
}

fn check_points(points: &[Point]) -> Result<(), ProfileError> {
    let expected = points.first().ok_or(ProfileError::NoPoints)?.value.len();
    for (i, Point { time_s, value }) in points.iter().enumerate() {
        check_finite(&[*time_s])?;
        check_finite(value)?;
        if value.len() != expected {
            return Err(ProfileError::Size { expected, given: value.len() });
        }
        if i > 0 && time_s - points[i - 1].time_s < MIN_DURATION {
            return Err(ProfileError::Times { point: i });
        }
    }
    Ok(())
}

fn check_finite(values: &[f64]) -> Result<(), ProfileError> {
    if values.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(ProfileError::NotFinite) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(list: &[(f64, f64)]) -> Vec<Point> {
        list.iter().map(|&(time_s, value)| Point { time_s, value: vec![value, -2.0 * value] }).collect()
    }

    const POINTS: [(f64, f64); 5] = [(0.5, 1.0), (1.0, 3.0), (1.2, 2.0), (2.5, -1.0), (3.0, -1.0)];

    fn waypoints() -> Profile {
        Profile::waypoints(&points(&POINTS)).unwrap()
    }

    fn column(entries: &[f64]) -> DVector<f64> {
        DVector::from_row_slice(entries)
    }

    #[test]
    fn a_sine_oscillates_about_its_offset() {
        // Eq. (54): 30 + 5 sin(t/π).
        let profile = Profile::sine(vec![30.0], vec![5.0], std::f64::consts::FRAC_1_PI, 0.0).unwrap();
        assert_eq!(profile.at(0.0).value[0], 30.0);
        assert!((profile.at(2.0).value[0] - (30.0 + 5.0 * (2.0 / std::f64::consts::PI).sin())).abs() < 1e-14);
    }

    #[test]
    fn rates_and_accelerations_match_finite_differences() {
        let sine = Profile::sine(vec![1.0, 2.0], vec![0.5, -3.0], 2.0, 0.3).unwrap();
        let later = sine.clone().starting_at(Some(1.5)).unwrap();
        assert_eq!((later.at(1.5), later.at(2.0)), (sine.at(1.5), sine.at(2.0)));
        assert_eq!((later.at(-3.0), &later.at(0.0).value), (later.at(1.0), &sine.at(1.5).value));
        assert!(later.at(1.0).rate.iter().chain(&later.at(1.0).acceleration).all(|entry| *entry == 0.0));
        let ramp = Profile::ramp(vec![1.0, 0.0], vec![3.0, -5.0], 0.6, 2.2).unwrap();
        let step = 1e-5;
        for profile in [sine, ramp, waypoints()] {
            for t in [0.1, 0.7, 1.1, 1.9, 2.6, 2.9, 3.4] {
                let (before, now, after) = (profile.at(t - step), profile.at(t), profile.at(t + step));
                let slope = |after, before| (column(after) - column(before)) * (0.5 / step);
                let rate_error = slope(&after.value, &before.value) - column(&now.rate);
                let acceleration_error = slope(&after.rate, &before.rate) - column(&now.acceleration);
                assert!(rate_error.amax() < 1e-7, "{profile:?} at {t}");
                assert!(acceleration_error.amax() < 1e-6, "{profile:?} at {t}");
            }
        }
    }

    #[test]
    fn the_largest_values_are_those_farthest_from_zero() {
        let constant = Profile::constant(vec![-3.0, 0.0]).unwrap();
        let sine = Profile::sine(vec![-3.0, 1.0], vec![2.0, -4.0], 1.0, 0.0).unwrap();
        let ramp = Profile::ramp(vec![1.0, -4.0], vec![-2.0, 3.0], 0.0, 1.0).unwrap();
        let found: Vec<_> = [constant, sine, ramp, waypoints()].iter().map(Profile::largest).collect();
        let expected = [[-3.0, 0.0], [-5.0, 5.0], [-2.0, -4.0], [3.0, -6.0]];
        assert!(found.iter().zip(&expected).all(|(found, expected)| found[..] == expected[..]), "{found:?}");
    }

    #[test]
    fn the_range_spans_zero_and_all_points() {
        let constant = Profile::constant(vec![-3.0, 2.0]).unwrap();
        let sine = Profile::sine(vec![-3.0, 1.0], vec![2.0, -4.0], 1.0, 0.0).unwrap();
        let ramp = Profile::ramp(vec![1.0, -4.0], vec![-2.0, -3.0], 0.0, 1.0).unwrap();
        let found: Vec<_> = [constant, sine, ramp, waypoints()].iter().map(Profile::range).collect();
        let expected = [
            [[-3.0, 0.0], [0.0, 2.0]],
            [[-5.0, -3.0], [0.0, 5.0]],
            [[-2.0, -4.0], [1.0, 0.0]],
            [[-1.0, -6.0], [3.0, 2.0]],
        ];
        assert!(
            found.iter().flatten().zip(expected.iter().flatten()).all(|(found, expected)| found[..] == expected[..]),
            "{found:?}"
        );
    }

    #[test]
    fn no_value_and_no_rate_is_beyond_its_bound() {
        let sine = Profile::sine(vec![-3.0, 1.0], vec![2.0, -4.0], 1.5, 0.0).unwrap();
        let ramp = Profile::ramp(vec![1.0, -4.0], vec![-2.0, 3.0], 0.3, 1.0).unwrap();
        let steps = Profile::steps(points(&POINTS)).unwrap();
        for profile in [Profile::constant(vec![-3.0, 0.0]).unwrap(), sine, ramp, steps, waypoints()] {
            let [value, rate] = profile.bounds();
            let mut reached = [vec![0.0_f64; 2], vec![0.0; 2]];
            for point in (0..5000).map(|i| profile.at(1e-3 * f64::from(i))) {
                for (reached, entries) in reached.iter_mut().zip([&point.value, &point.rate]) {
                    reached.iter_mut().zip(entries).for_each(|(reached, entry)| *reached = reached.max(entry.abs()));
                }
            }
            for (reached, bound) in reached.iter().flatten().zip(value.iter().chain(&rate)) {
                let is_near =
                    *reached > 0.99 * bound || matches!(profile.0, Shape::Waypoints(_)) && *reached > 0.4 * bound;
                assert!(*reached <= bound + 1e-12 && is_near || *bound == 0.0, "{profile:?}: {reached} of {bound}");
            }
        }
    }

    #[test]
    fn a_ramp_begins_and_ends_at_its_values() {
        let ramp = Profile::ramp(vec![1.0], vec![3.0], 2.0, 4.0).unwrap();
        let value = |t: f64| ramp.at(t).value[0];
        assert_eq!([value(-1.0), value(2.0), value(4.0), value(6.0), value(9.0)], [1.0, 1.0, 2.0, 3.0, 3.0]);
        assert_eq!([ramp.at(1.9).rate[0], ramp.at(2.0).rate[0], ramp.at(6.0).rate[0]], [0.0, 0.5, 0.0]);
    }

    #[test]
    fn steps_hold_each_value_until_the_next_point() {
        let steps = Profile::steps(points(&[(1.0, 5.0), (2.0, 7.0)])).unwrap();
        let value = |t: f64| steps.at(t).value[0];
        assert_eq!([value(0.0), value(1.0), value(1.999), value(2.0), value(9.0)], [5.0, 5.0, 5.0, 7.0, 7.0]);
        assert_eq!(steps.at(2.0).rate[..], [0.0, 0.0]);
    }

    #[test]
    fn waypoints_pass_through_their_points_and_rest_before_and_after() {
        for (t, value) in POINTS {
            let at = waypoints().at(t).value;
            assert!((at[0] - value).abs() < 1e-14 && (at[1] + 2.0 * value).abs() < 1e-14, "{t}: {at:?}");
        }
        assert_eq!(waypoints().at(0.0), SetPoint::resting(Entries::from_slice(&[1.0, -2.0])));
        assert_eq!(waypoints().at(9.0), SetPoint::resting(Entries::from_slice(&[-1.0, 2.0])));
    }

    #[test]
    fn waypoints_are_twice_continuously_differentiable() {
        for (t, _) in POINTS {
            let (before, after) = (waypoints().at(t - 1e-9), waypoints().at(t + 1e-9));
            assert!((column(&before.rate) - column(&after.rate)).amax() < 1e-6, "rate at {t}");
            assert!((column(&before.acceleration) - column(&after.acceleration)).amax() < 1e-5, "acceleration at {t}");
        }
        let moving = waypoints().at(1.0);
        assert!(
            column(&moving.acceleration).amax() > 1.0 && column(&waypoints().at(1.2).rate).amax() > 1.0,
            "the curve must not stop at inner points"
        );
    }

    #[test]
    fn two_waypoints_are_the_minimum_jerk_path_and_one_is_a_constant() {
        let two = Profile::waypoints(&points(&[(0.0, 0.0), (2.0, 1.0)])).unwrap();
        for s in [0.25, 0.5, 0.9_f64] {
            let expected = 10.0 * s.powi(3) - 15.0 * s.powi(4) + 6.0 * s.powi(5);
            assert!((two.at(2.0 * s).value[0] - expected).abs() < 1e-14);
        }
        let one = Profile::waypoints(&points(&[(1.0, 4.0)])).unwrap();
        assert!([0.0, 1.0, 5.0].iter().all(|t| one.at(*t) == SetPoint::resting(Entries::from_slice(&[4.0, -8.0]))));
    }

    #[test]
    fn invalid_profiles_are_refused() {
        assert_eq!(Profile::constant(vec![f64::NAN]), Err(ProfileError::NotFinite));
        assert_eq!(Profile::sine(vec![1.0], vec![], 1.0, 0.0), Err(ProfileError::Size { expected: 1, given: 0 }));
        for duration in [0.0, -1.0, 1e-300] {
            assert_eq!(Profile::ramp(vec![1.0], vec![2.0], 0.0, duration), Err(ProfileError::Duration));
        }
        assert_eq!(Profile::steps(Vec::new()), Err(ProfileError::NoPoints));
        for second in [1.0, 0.9, 1.0 + 1e-9] {
            let refused = Profile::waypoints(&points(&[(1.0, 0.0), (second, 1.0)]));
            assert_eq!(refused, Err(ProfileError::Times { point: 1 }));
        }
        assert_eq!(Profile::waypoints(&points(&[(f64::NAN, 0.0)])), Err(ProfileError::NotFinite));
        assert_eq!(Profile::waypoints(&points(&[(0.0, 1e308), (1.0, -1e308)])), Err(ProfileError::NotFinite));
    }
}
