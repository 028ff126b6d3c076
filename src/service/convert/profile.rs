//! Values per axis and set-points over time.

use super::numbers::{number, numbers};
use crate::law::{Point, Profile, ProfileError};
use crate::service::problem::Problem;
use crate::wire::{self, PerAxis};

/// Most points of a profile: what is far beyond any path of one task would only hold up others.
pub const MOST_POINTS: usize = 1000;

/// Reads lists with one value per row for the object at a JSON pointer.
pub struct PerRow<'a> {
    /// m.
    pub rows: usize,
    /// Where the object stands.
    pub pointer: &'a str,
}

impl PerRow<'_> {
    /// JSON pointer of a field.
    pub fn at(&self, field: &str) -> String {
        format!("{}/{field}", self.pointer)
    }

    /// One value per row.
    pub fn each<T: Clone>(&self, values: &PerAxis<T>, field: &str) -> Result<Vec<T>, Problem> {
        match values {
            PerAxis::All(value) => Ok(vec![value.clone(); self.rows]),
            PerAxis::Each(values) if values.len() == self.rows => Ok(values.clone()),
            PerAxis::Each(values) => {
                let detail =
                    format!("{} values for {} rows; give one per row, or one for all", values.len(), self.rows);
                Err(Problem::invalid(self.at(field), detail))
            }
        }
    }

    /// One number of sensible size per row.
    pub fn numbers(&self, values: &PerAxis<f64>, field: &str) -> Result<Vec<f64>, Problem> {
        let each = self.each(values, field)?;
        match values {
            PerAxis::All(value) => number(*value, &self.at(field)).map(|_| each),
            PerAxis::Each(_) => numbers(&each, &self.at(field)),
        }
    }

    /// JSON pointer of a row's value.
    pub fn at_row(&self, values: &PerAxis<f64>, field: &str, row: usize) -> String {
        match values {
            PerAxis::All(_) => self.at(field),
            PerAxis::Each(_) => format!("{}/{row}", self.at(field)),
        }
    }

    /// The profile that is this object.
    pub fn profile(&self, profile: &wire::Profile) -> Result<Profile, Problem> {
        let single = |value: f64, field: &str| number(value, &self.at(field));
        let profile = match profile {
            wire::Profile::Constant { value } => Profile::constant(self.numbers(value, "value")?),
            wire::Profile::Sine { offset, amplitude, angular_frequency_rad_s, phase_rad } => Profile::sine(
                self.numbers(offset, "offset")?,
                self.numbers(amplitude, "amplitude")?,
                single(*angular_frequency_rad_s, "angular_frequency_rad_s")?,
                single(*phase_rad, "phase_rad")?,
            ),
            wire::Profile::Ramp { start, end, start_time_s, duration_s } => Profile::ramp(
                self.numbers(start, "start")?,
                self.numbers(end, "end")?,
                single(*start_time_s, "start_time_s")?,
                single(*duration_s, "duration_s")?,
            ),
            wire::Profile::Steps { points } => Profile::steps(self.points(points)?),
            wire::Profile::Waypoints { points } => Profile::waypoints(&self.points(points)?),
        };
        profile.map_err(|error| Problem::invalid(self.flaw(error), error))
    }

    fn points(&self, points: &[wire::ProfilePoint]) -> Result<Vec<Point>, Problem> {
        if points.len() > MOST_POINTS {
            return Err(Problem::invalid(self.at("points"), format!("at most {MOST_POINTS} points")));
        }
        let point = |(i, point): (usize, &wire::ProfilePoint)| {
            let value = self.numbers(&point.value, &format!("points/{i}/value"))?;
            Ok(Point { time_s: number(point.time_s, &self.at(&format!("points/{i}/time_s")))?, value })
        };
        points.iter().enumerate().map(point).collect()
    }

    /// JSON pointer of what the library refuses.
    fn flaw(&self, error: ProfileError) -> String {
        match error {
            ProfileError::Times { point } => self.at(&format!("points/{point}/time_s")),
            ProfileError::NoPoints => self.at("points"),
            ProfileError::Duration => self.at("duration_s"),
            ProfileError::NotFinite | ProfileError::Size { .. } => self.pointer.to_owned(),
        }
    }
}
