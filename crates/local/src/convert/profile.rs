//! Values per axis and set-points over time.

use revprio_api::wire::{self, PerAxis};
use revprio_core::law::{Point, Profile, ProfileError};

use super::checks::{Result, check, each};
use super::numbers::{check_numbers, number};
use crate::error::ApiError;

/// Maximum number of points of a profile. It is far above any path of one task, and bounds the time of a request.
pub const MAX_POINTS: usize = 1000;

/// Reads lists with one value per row of a task. `field` is the JSON pointer of the list.
#[derive(Debug, Clone, Copy)]
pub struct PerRow {
    /// Number of rows m.
    pub rows: usize,
}

impl PerRow {
    /// Reads one value per row.
    pub fn each<T: Clone>(self, values: &PerAxis<T>, field: &str) -> Result<Vec<T>> {
        match values {
            PerAxis::All(value) => Ok(vec![value.clone(); self.rows]),
            PerAxis::Each(values) => {
                let (given, rows) = (values.len(), self.rows);
                let detail = format_args!("{given} values for {rows} rows; give one per row, or one for all");
                check(given == rows, field, detail).map(|()| values.clone())
            }
        }
    }

    /// Reads one number per row.
    pub fn numbers(self, values: &PerAxis<f64>, field: &str) -> Result<Vec<f64>> {
        let each = self.each(values, field)?;
        match values {
            PerAxis::All(value) => number(*value, field).map(drop)?,
            PerAxis::Each(_) => check_numbers(&each, field)?,
        }
        Ok(each)
    }

    /// Reads a profile.
    pub fn profile(self, profile: &wire::Profile) -> Result<Profile> {
        let profile = match profile {
            wire::Profile::Constant { value } => Profile::constant(self.numbers(value, "/value")?),
            wire::Profile::Sine { offset, amplitude, angular_frequency_rad_s, phase_rad, start_time_s } => {
                let start = start_time_s.map(|time| number(time, "/start_time_s")).transpose()?;
                let sine = Profile::sine(
                    self.numbers(offset, "/offset")?,
                    self.numbers(amplitude, "/amplitude")?,
                    number(*angular_frequency_rad_s, "/angular_frequency_rad_s")?,
                    number(*phase_rad, "/phase_rad")?,
                );
                sine.and_then(|sine| sine.starting_at(start))
            }
            wire::Profile::Ramp { start, end, start_time_s, duration_s } => Profile::ramp(
                self.numbers(start, "/start")?,
                self.numbers(end, "/end")?,
                number(*start_time_s, "/start_time_s")?,
                number(*duration_s, "/duration_s")?,
            ),
            wire::Profile::Steps { points } => Profile::steps(self.points(points)?),
            wire::Profile::Waypoints { points } => Profile::waypoints(&self.points(points)?),
        };
        profile.map_err(|error| ApiError::invalid(error_pointer(error), error))
    }

    fn points(self, points: &[wire::ProfilePoint]) -> Result<Vec<Point>> {
        check(points.len() <= MAX_POINTS, "/points", format_args!("give at most {MAX_POINTS} points"))?;
        each("/points", points, |_, point| {
            let value = self.numbers(&point.value, "/value")?;
            Ok(Point { time_s: number(point.time_s, "/time_s")?, value })
        })
    }
}

/// Returns the JSON pointer of the value of a row.
pub fn at_row(values: &PerAxis<f64>, field: &str, row: usize) -> String {
    match values {
        PerAxis::All(_) => field.to_owned(),
        PerAxis::Each(_) => format!("{field}/{row}"),
    }
}

/// Returns the JSON pointer of the field that the library refuses.
fn error_pointer(error: ProfileError) -> String {
    match error {
        ProfileError::Times { point } => format!("/points/{point}/time_s"),
        ProfileError::NoPoints => "/points".to_owned(),
        ProfileError::Duration => "/duration_s".to_owned(),
        ProfileError::NotFinite | ProfileError::Size { .. } => String::new(),
    }
}
