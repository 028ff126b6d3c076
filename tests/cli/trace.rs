//! Reads CSV recordings without code of the program.

use std::path::Path;

/// One recording.
pub struct Trace {
    columns: Vec<String>,
    rows: Vec<csv::StringRecord>,
}

impl Trace {
    pub fn read(path: &Path) -> Self {
        let mut reader = csv::Reader::from_path(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let columns = reader.headers().unwrap().iter().map(str::to_owned).collect();
        Self { columns, rows: reader.records().collect::<Result<_, _>>().unwrap() }
    }

    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    pub fn words(&self, column: &str) -> Vec<String> {
        let place = self.columns.iter().position(|name| name == column);
        let place = place.unwrap_or_else(|| panic!("no column {column} in {:?}", self.columns));
        self.rows.iter().map(|row| row[place].to_owned()).collect()
    }

    pub fn numbers(&self, column: &str) -> Vec<f64> {
        self.words(column).iter().map(|word| word.parse().unwrap()).collect()
    }

    /// Returns the root mean square of F_x − F_d,x from a time on, N.
    pub fn rmse_fx(&self, from_s: f64) -> f64 {
        let (time, force, target) =
            (self.numbers("time_s"), self.numbers("force_x_n"), self.numbers("target_force_x_n"));
        let errors = (0..self.rows()).filter(|&i| time[i] >= from_s).map(|i| force[i] - target[i]);
        let errors: Vec<f64> = errors.collect();
        (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
    }

    /// Returns the start times of contacts with the wall, s.
    pub fn contacts_s(&self) -> Vec<f64> {
        let (time, distance) = (self.numbers("time_s"), self.numbers("wall_distance_m"));
        let begins = |&i: &usize| distance[i] <= 0.0 && (i == 0 || distance[i - 1] > 0.0);
        (0..self.rows()).filter(begins).map(|i| time[i]).collect()
    }

    /// Returns F_x at the end, N.
    pub fn final_fx(&self) -> f64 {
        *self.numbers("force_x_n").last().unwrap()
    }

    /// Returns the largest F_x, N.
    pub fn peak_fx(&self) -> f64 {
        self.numbers("force_x_n").into_iter().fold(0.0, f64::max)
    }
}
