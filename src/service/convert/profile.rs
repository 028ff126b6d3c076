//! Values per axis and set-points over time.

use revprio_api::wire::{self, PerAxis};
use revprio_core::law::{Point, Profile, ProfileError};

use super::numbers::{check_numbers, number};
use crate::service::error::ApiError;

/// Most points of a profile: what is far beyond any path of one task would only hold up others.
pub const MOST_POINTS: usize = 1000;

/// Reads lists with one value per row; fields are named by JSON pointer.
#[derive(Debug, Clone, Copy)]
pub struct PerRow {
    /// m.
    pub rows: usize,
}

impl PerRow {
    /// One value per row.
    pub fn each<T: Clone>(self, values: &PerAxis<T>, field: &str) -> Result<Vec<T>, ApiError> {
        match values {
            PerAxis::All(value) => Ok(vec![value.clone(); self.rows]),
            PerAxis::Each(values) if values.len() == self.rows => Ok(values.clone()),
            PerAxis::Each(values) => {
                let detail =
                    format!("{} values for {} rows; give one per row, or one for all", values.len(), self.rows);
                Err(ApiError::invalid(field, detail))
            }
        }
    }

    /// One number of sensible size per row.
    pub fn numbers(self, values: &PerAxis<f64>, field: &str) -> Result<Vec<f64>, ApiError> {
        let each = self.each(values, field)?;
        match values {
            PerAxis::All(value) => number(*value, field).map(drop)?,
            PerAxis::Each(_) => check_numbers(&each, field)?,
        }
        Ok(each)
    }

    /// A profile.
    pub fn profile(self, profile: &wire::Profile) -> Result<Profile, ApiError> {
        let profile = match profile {
            wire::Profile::Constant { value } => Profile::constant(self.numbers(value, "/value")?),
            wire::Profile::Sine { offset, amplitude, angular_frequency_rad_s, phase_rad } => Profile::sine(
                self.numbers(offset, "/offset")?,
                self.numbers(amplitude, "/amplitude")?,
                number(*angular_frequency_rad_s, "/angular_frequency_rad_s")?,
                number(*phase_rad, "/phase_rad")?,
            ),
            wire::Profile::Ramp { start, end, start_time_s, duration_s } => Profile::ramp(
                self.numbers(start, "/start")?,
                self.numbers(end, "/end")?,
                number(*start_time_s, "/start_time_s")?,
                number(*duration_s, "/duration_s")?,
            ),
            wire::Profile::Steps { points } => Profile::steps(self.points(points)?),
            wire::Profile::Waypoints { points } => Profile::waypoints(&self.points(points)?),
        };
        profile.map_err(|error| ApiError::invalid(flaw(error), error))
    }

    fn points(self, points: &[wire::ProfilePoint]) -> Result<Vec<Point>, ApiError> {
        if points.len() > MOST_POINTS {
            return Err(ApiError::invalid("/points", format!("at most {MOST_POINTS} points")));
        }
        let at_place =
            |(i, point)| self.point(point).map_err(|problem: ApiError| problem.inside(&format!("/points/{i}")));
        points.iter().enumerate().map(at_place).collect()
    }

    fn point(self, point: &wire::ProfilePoint) -> Result<Point, ApiError> {
        let value = self.numbers(&point.value, "/value")?;
        Ok(Point { time_s: number(point.time_s, "/time_s")?, value })
    }
}

/// JSON pointer of a row's value.
pub fn at_row(values: &PerAxis<f64>, field: &str, row: usize) -> String {
    match values {
        PerAxis::All(_) => field.to_owned(),
        PerAxis::Each(_) => format!("{field}/{row}"),
    }
}

/// JSON pointer of what the library refuses.
fn flaw(error: ProfileError) -> String {
    match error {
        ProfileError::Times { point } => format!("/points/{point}/time_s"),
        ProfileError::NoPoints => "/points".to_owned(),
        ProfileError::Duration => "/duration_s".to_owned(),
        ProfileError::NotFinite | ProfileError::Size { .. } => String::new(),
    }
}
