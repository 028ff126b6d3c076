//! The picture of the maps: a panel of peaks and one of times for each law.

use crate::{Cell, DRIVE, Map, SPEEDS, STIFFNESSES};

/// Size of a cell, and of a panel with its margins, pixels.
const CELL: [f64; 2] = [38.0, 20.0];
const PANEL: [f64; 2] = [350.0, 158.0];
const LEFT: f64 = 60.0;
const COLUMNS: usize = 3;

/// Steps of a scale: up to which value a colour counts.
type Scale = [(f64, &'static str); 6];

/// Peak over target.
const PEAKS: Scale = [
    (1.05, "#2166ac"),
    (1.2, "#92c5de"),
    (1.5, "#fddbc7"),
    (2.0, "#f4a582"),
    (5.0, "#d6604d"),
    (f64::INFINITY, "#b2182b"),
];
/// Time beyond the travel, s.
const TIMES: Scale = [
    (0.25, "#2166ac"),
    (0.5, "#92c5de"),
    (1.0, "#fddbc7"),
    (1.5, "#f4a582"),
    (2.5, "#d6604d"),
    (f64::INFINITY, "#b2182b"),
];
/// Where a contact does not settle, and where a law is refused.
const NEVER: &str = "#4d4d4d";
const REFUSED: &str = "#e8e8e8";

/// Returns the picture as SVG.
pub fn draw(maps: &[Map]) -> String {
    let rows = maps.len().div_ceil(COLUMNS) as f64;
    let block = 34.0 + rows * PANEL[1];
    let [width, height] = [COLUMNS as f64 * PANEL[0] + 10.0, 2.0 * block + 24.0];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <title>Peak force and settling time of six laws over stiffness and approach speed</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    let (lag, delay, period) = DRIVE;
    let drive = format!("L = {} ms, D = {delay}, T = {} ms", 1e3 * lag, 1e3 * period);
    let peak = |cell: &Cell| match cell {
        Cell::Refused => (REFUSED, "–".to_owned()),
        Cell::Pressed { peak, .. } => (colour(&PEAKS, *peak), short(*peak)),
    };
    let late = |cell: &Cell| match cell {
        Cell::Refused => (REFUSED, "–".to_owned()),
        Cell::Pressed { late: None, .. } => (NEVER, "never".to_owned()),
        Cell::Pressed { late: Some(late), .. } => (colour(&TIMES, *late), format!("{late:.2}")),
    };
    svg += &panels(maps, 0.0, &format!("Largest force over the target of 30 N ({drive}; –: refused)"), peak);
    svg += &panels(
        &maps[1..],
        block,
        "Time until the force stays within 5 %, beyond F_d/(K v), s (never: not within the run)",
        late,
    );
    svg + "</svg>\n"
}

fn colour(scale: &Scale, value: f64) -> &'static str {
    scale.iter().find(|(end, _)| value <= *end).map_or(NEVER, |(_, colour)| colour)
}

/// Returns a ratio with two or three digits.
fn short(value: f64) -> String {
    if value < 9.95 { format!("{value:.2}") } else { format!("{value:.0}") }
}

/// Draws a title and the panels of some maps.
fn panels(maps: &[Map], top: f64, title: &str, show: impl Fn(&Cell) -> (&'static str, String)) -> String {
    let mut svg =
        format!("<text x=\"{LEFT}\" y=\"{}\" font-size=\"16\" font-weight=\"bold\">{title}</text>\n", top + 24.0);
    for (k, map) in maps.iter().enumerate() {
        let left = LEFT + (k % COLUMNS) as f64 * PANEL[0];
        svg += &panel(map, [left, top + 56.0 + (k / COLUMNS) as f64 * PANEL[1]], &show);
    }
    svg
}

fn panel(map: &Map, [left, top]: [f64; 2], show: &impl Fn(&Cell) -> (&'static str, String)) -> String {
    let [width, height] = CELL;
    let mut svg = format!("<text x=\"{left}\" y=\"{}\" font-weight=\"bold\">{}</text>\n", top - 6.0, map.name);
    for (j, (speed, cells)) in SPEEDS.iter().zip(&map.cells).enumerate() {
        // Fast approaches are at the top.
        let y = top + (SPEEDS.len() - 1 - j) as f64 * height;
        svg += &text([left - 4.0, y + 14.0], "end", "#333", &format!("{} cm/s", 100.0 * speed));
        for (i, cell) in cells.iter().enumerate() {
            let (x, (fill, label)) = (left + i as f64 * width, show(cell));
            svg += &rectangle([x, y], fill);
            let is_dark = ["#2166ac", "#d6604d", "#b2182b", NEVER].contains(&fill);
            svg += &text([x + 0.5 * width, y + 14.0], "middle", if is_dark { "#fff" } else { "#222" }, &label);
        }
    }
    let below = top + SPEEDS.len() as f64 * height + 13.0;
    for (i, stiffness) in STIFFNESSES.iter().enumerate() {
        svg += &text([left + (i as f64 + 0.5) * width, below], "middle", "#333", &format!("{stiffness:.0e}"));
    }
    svg += &text([left + STIFFNESSES.len() as f64 * width + 2.0, below], "start", "#333", "N/m");
    svg
}

fn rectangle([x, y]: [f64; 2], fill: &str) -> String {
    let [width, height] = CELL;
    format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"{fill}\" stroke=\"#fff\"/>\n")
}

fn text([x, y]: [f64; 2], anchor: &str, fill: &str, text: &str) -> String {
    format!("<text x=\"{x}\" y=\"{y}\" font-size=\"11\" text-anchor=\"{anchor}\" fill=\"{fill}\">{text}</text>\n")
}
