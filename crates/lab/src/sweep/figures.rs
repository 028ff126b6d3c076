//! Figures of a sweep: for each measure a heat map over the first two numeric quantities, or curves over the only one. Other
//! numeric quantities are averaged.

use std::path::{Path, PathBuf};

use super::partial::Rows;
use super::values::Variation;
use crate::report::figure::{Colour, Curve, Figure, Panel, Stroke};
use crate::report::heat_map::{HeatMap, Scale};
use crate::report::{self, Error};
use crate::simulator::recording::{Kind, Value};

const COLOURS: [Colour; 6] =
    [Colour::Blue, Colour::Orange, Colour::Green, Colour::Vermillion, Colour::SkyBlue, Colour::Black];

/// Draws the measures and returns the paths of the figures. Draws nothing for an incomplete sweep.
pub fn write(
    out: &Path,
    label: &str,
    variations: &[Variation],
    measures: &[String],
    columns: &[(String, Kind)],
    rows: &Rows,
) -> Result<Vec<PathBuf>, Error> {
    let cells: usize = variations.iter().map(|variation| variation.values.len()).product();
    if rows.len() < cells {
        return Ok(Vec::new());
    }
    let table = Table { label, variations, columns, rows };
    let axes: Vec<usize> =
        (0..variations.len()).filter(|&i| variations[i].path != "seed" && variations[i].numbers().is_some()).collect();
    let mut written = Vec::new();
    for measure in measures {
        match axes[..] {
            [] => {}
            [x] => written.extend(report::write_figures(out, &[table.lines(measure, x)])?),
            [x, y, ..] => {
                for map in table.maps(measure, x, y) {
                    written.extend(report::write_heat_map(out, &map)?);
                }
            }
        }
    }
    Ok(written)
}

struct Table<'a> {
    label: &'a str,
    variations: &'a [Variation],
    columns: &'a [(String, Kind)],
    rows: &'a Rows,
}

impl Table<'_> {
    /// Returns curves over a quantity, one for each combination of the quantities that are not numbers.
    fn lines(&self, measure: &str, x: usize) -> Figure {
        let variation = &self.variations[x];
        let numbers = variation.numbers().unwrap_or_default();
        let place = |value: f64| if variation.is_logarithmic() { value.abs().log10() } else { value };
        let kinds = self.kinds();
        let curve = |(i, kind): (usize, &Vec<usize>)| Curve {
            label: self.named(kind).unwrap_or_else(|| measure.to_owned()),
            colour: COLOURS[i % COLOURS.len()],
            stroke: if i < COLOURS.len() { Stroke::Thin } else { Stroke::Dashed },
            points: (0..numbers.len())
                .filter_map(|at| Some((place(numbers[at]), self.mean(measure, kind, &[(x, at)])?)))
                .collect(),
        };
        let ends = numbers.iter().map(|&number| place(number));
        let window = (ends.clone().fold(f64::INFINITY, f64::min), ends.fold(f64::NEG_INFINITY, f64::max));
        let x_label =
            if variation.is_logarithmic() { format!("log10 {}", variation.path) } else { variation.path.clone() };
        Figure {
            name: format!("{}-{measure}", self.label),
            title: plain(&format!("{}: {measure}", self.scenario())),
            caption: String::new(),
            panels: vec![Panel {
                heading: String::new(),
                x_label: plain(&x_label),
                y_label: plain(measure),
                window,
                y_covers: Vec::new(),
                curves: kinds.iter().enumerate().map(curve).collect(),
            }],
        }
    }

    fn scenario(&self) -> &str {
        self.label.strip_prefix("sweep-").unwrap_or(self.label)
    }

    /// Returns heat maps, one for each combination of the quantities that are not numbers.
    fn maps(&self, measure: &str, x: usize, y: usize) -> Vec<HeatMap> {
        let scale = |i: usize| Scale {
            label: plain(&self.variations[i].path),
            values: self.variations[i].numbers().unwrap_or_default(),
        };
        let kinds = self.kinds();
        let map = |kind: &Vec<usize>| {
            let name = self.named(kind);
            let (nx, ny) = (self.variations[x].values.len(), self.variations[y].values.len());
            let suffix =
                name.as_ref().map(|name| format!("-{}", name.replace([' ', ',', '='], "_"))).unwrap_or_default();
            HeatMap {
                name: format!("{}-{measure}{suffix}", self.label),
                title: plain(&format!(
                    "{}: {measure}{}",
                    self.scenario(),
                    name.map(|n| format!(", {n}")).unwrap_or_default()
                )),
                x: scale(x),
                y: scale(y),
                label: plain(measure),
                cells: (0..ny)
                    .map(|j| (0..nx).map(|i| self.mean(measure, kind, &[(x, i), (y, j)])).collect())
                    .collect(),
            }
        };
        kinds.iter().map(map).collect()
    }

    /// Returns all combinations of the quantities that are not numbers, as indices of their values.
    fn kinds(&self) -> Vec<Vec<usize>> {
        let words = self.words().map(|i| self.variations[i].values.len());
        words.fold(vec![Vec::new()], |kinds, count| {
            let longer = |kind: &Vec<usize>, value| kind.iter().copied().chain([value]).collect();
            kinds.iter().flat_map(|kind| (0..count).map(move |value| longer(kind, value))).collect()
        })
    }

    fn words(&self) -> impl Iterator<Item = usize> {
        (0..self.variations.len()).filter(|&i| self.variations[i].values.iter().any(|value| !value.is_number()))
    }

    fn named(&self, kind: &[usize]) -> Option<String> {
        let word = |(i, &value): (usize, &usize)| match &self.variations[i].values[value] {
            serde_json::Value::String(word) => word.clone(),
            other => other.to_string(),
        };
        let words: Vec<String> = self.words().zip(kind).map(word).collect();
        (!words.is_empty()).then(|| words.join(", "))
    }

    /// Returns the mean of a measure over all cells in which the quantities have these values.
    fn mean(&self, measure: &str, kind: &[usize], fixed: &[(usize, usize)]) -> Option<f64> {
        let column = self.columns.iter().position(|(name, _)| name == measure)?;
        let words = self.words().zip(kind.iter().copied());
        let fixed: Vec<(usize, usize)> = words.chain(fixed.iter().copied()).collect();
        let chosen =
            self.rows.iter().filter(|(cell, _)| fixed.iter().all(|&(i, value)| self.place(**cell, i) == value));
        let numbers = chosen.filter_map(|(_, row)| match row.get(column) {
            Some(Value::Number(number)) if number.is_finite() => Some(*number),
            _ => None,
        });
        let (sum, count) = numbers.fold((0.0, 0.0), |(sum, count), number| (sum + number, count + 1.0));
        (count > 0.0).then(|| sum / count)
    }

    /// Returns the index of the value of a quantity in a cell.
    fn place(&self, cell: usize, variation: usize) -> usize {
        let faster: usize = self.variations[variation + 1..].iter().map(|variation| variation.values.len()).product();
        cell / faster % self.variations[variation].values.len()
    }
}

/// Removes underscores, which would print an index in the texts of figures.
fn plain(text: &str) -> String {
    text.replace('_', " ")
}
