//! Conversion of profiles over time from a scenario.

use revprio_api::wire::{self, PerAxis, ProfilePoint};
use revprio_robot::profile::{Point, Profile, ProfileError};

use super::field_error::{FieldError, number, per_row};

/// Largest number of points of a profile, as in a controller.
const MAX_POINTS: usize = 1000;

/// Converts the profile at a JSON pointer; `rows` is its number of values.
pub fn profile(profile: &wire::Profile, rows: usize, pointer: &str) -> Result<Profile, FieldError> {
    let at = |field: &str| format!("{pointer}/{field}");
    let list = |values: &PerAxis<f64>, field: &str| per_row(values, rows, &at(field), number);
    let single = |value: f64, field: &str| number(value, &at(field));
    let points = |points: &[ProfilePoint]| -> Result<Vec<Point>, FieldError> {
        if points.len() > MAX_POINTS {
            return Err(FieldError::new(at("points"), format!("has more than {MAX_POINTS} points")));
        }
        let point = |(i, point): (usize, &ProfilePoint)| {
            let time_s = single(point.time_s, &format!("points/{i}/time_s"))?;
            Ok(Point { time_s, value: list(&point.value, &format!("points/{i}/value"))? })
        };
        points.iter().enumerate().map(point).collect()
    };
    let profile = match profile {
        wire::Profile::Constant { value } => Profile::constant(list(value, "value")?),
        wire::Profile::Sine { offset, amplitude, angular_frequency_rad_s, phase_rad, start_time_s } => {
            let start = start_time_s.map(|time| single(time, "start_time_s")).transpose()?;
            let sine = Profile::sine(
                list(offset, "offset")?,
                list(amplitude, "amplitude")?,
                single(*angular_frequency_rad_s, "angular_frequency_rad_s")?,
                single(*phase_rad, "phase_rad")?,
            );
            sine.and_then(|sine| sine.starting_at(start))
        }
        wire::Profile::Ramp { start, end, start_time_s, duration_s } => Profile::ramp(
            list(start, "start")?,
            list(end, "end")?,
            single(*start_time_s, "start_time_s")?,
            single(*duration_s, "duration_s")?,
        ),
        wire::Profile::Steps { points: list } => Profile::steps(points(list)?),
        wire::Profile::Waypoints { points: list } => Profile::waypoints(&points(list)?),
    };
    profile.map_err(|error| FieldError::new(place(error, pointer), format!("is not valid: {error}")))
}

/// Returns the external wrench over time: force and torque.
pub fn external_wrench(wrench: &wire::Profile) -> Result<Profile, FieldError> {
    profile(wrench, 6, "/external_wrench")
}

/// Returns the JSON pointer of an invalid part.
fn place(error: ProfileError, pointer: &str) -> String {
    match error {
        ProfileError::Times { point } => format!("{pointer}/points/{point}/time_s"),
        ProfileError::NoPoints => format!("{pointer}/points"),
        ProfileError::Duration => format!("{pointer}/duration_s"),
        ProfileError::NotFinite | ProfileError::Size { .. } => pointer.to_owned(),
    }
}
