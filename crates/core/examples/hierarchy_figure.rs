//! Draws `docs/solver.svg` from the answers of the worked example.
//!
//! Run with `cargo run -p revprio-core --example hierarchy_figure` in the folder of the repository.

use std::fmt::Write;

use revprio_core::linalg::Damping;

#[path = "hierarchy.rs"]
#[expect(dead_code, reason = "its main function prints the numbers")]
mod hierarchy;

/// Colours that are distinguishable with every kind of colour vision.
const BLUE: &str = "#0072b2";
const ORANGE: &str = "#e69f00";
const VERMILLION: &str = "#d55e00";

type Error = Box<dyn std::error::Error>;

/// Axes with their place in the picture: corner (left, bottom) in pixels, origin and pixels per unit.
struct Axes {
    left: f64,
    bottom: f64,
    from: [f64; 2],
    scale: [f64; 2],
}

impl Axes {
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.left + (x - self.from[0]) * self.scale[0], self.bottom - (y - self.from[1]) * self.scale[1]]
    }

    fn line(&self, points: impl IntoIterator<Item = [f64; 2]>, style: &str) -> String {
        let points = points.into_iter().map(|point| self.at(point));
        let points: Vec<String> = points.map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        format!("<polyline points=\"{}\" fill=\"none\" {style}/>\n", points.join(" "))
    }

    fn dot(&self, point: [f64; 2], colour: &str) -> String {
        let [x, y] = self.at(point);
        format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"{colour}\"/>\n")
    }

    /// Writes a text at a point, shifted by pixels; `anchor` is `start`, `middle` or `end`.
    fn text(&self, point: [f64; 2], shift: [f64; 2], anchor: &str, text: &str) -> String {
        let [x, y] = self.at(point);
        let (x, y) = (x + shift[0], y + shift[1]);
        format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>\n")
    }

    /// Draws both axes up to `to` with ticks.
    fn frame(&self, to: [f64; 2], ticks: [&[f64]; 2], labels: [&str; 2]) -> String {
        let [x0, y0] = self.from;
        let thin = "stroke=\"#666\" stroke-width=\"1\"";
        let mut svg = self.line([[x0, to[1]], [x0, y0], [to[0], y0]], thin);
        for &x in ticks[0] {
            svg += &self.text([x, y0], [0.0, 18.0], "middle", &x.to_string().replace('-', "−"));
            svg += &self.line([[x, y0], [x, y0 + 5.0 / self.scale[1]]], thin);
        }
        for &y in ticks[1] {
            svg += &self.text([x0, y], [-8.0, 5.0], "end", &y.to_string().replace('-', "−"));
            svg += &self.line([[x0, y], [x0 + 5.0 / self.scale[0], y]], thin);
        }
        svg += &self.text([f64::midpoint(x0, to[0]), y0], [0.0, 40.0], "middle", labels[0]);
        svg + &self.text([x0, to[1]], [-4.0, -9.0], "start", labels[1])
    }
}

/// The plane of two joints: the limits, the line of each level, and three answers.
fn plane() -> Result<String, Error> {
    let axes = Axes { left: 60.0, bottom: 380.0, from: [-1.6, -1.2], scale: [110.0, 110.0] };
    let answer =
        |upper| hierarchy::worked_example(upper, &[]).map(|found| [found.joint_velocity[0], found.joint_velocity[1]]);
    let (unlimited, limited) = (answer(2.0)?, answer(1.0)?);
    let ([x, y], [w, h]) = (axes.at([-1.0, 1.0]), [2.0 * axes.scale[0], 2.0 * axes.scale[1]]);
    let mut svg =
        format!("<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"#e8eef3\" stroke=\"#444\"/>\n");
    svg += &axes.frame([1.6, 1.8], [&[-1.0, 0.0, 1.0], &[-1.0, 0.0, 1.0]], ["x₁ (rad/s)", "x₂ (rad/s)"]);
    svg += &axes.line([[-1.55, 1.775], [1.6, 0.2]], &format!("stroke=\"{BLUE}\" stroke-width=\"2.5\""));
    svg += &axes.line([[-1.6, 0.4], [-0.2, 1.8]], &format!("stroke=\"{ORANGE}\" stroke-width=\"2.5\""));
    svg +=
        &axes.line([unlimited, limited], &format!("stroke=\"{VERMILLION}\" stroke-width=\"5\" stroke-opacity=\"0.6\""));
    svg += &axes.text([1.3, 0.35], [6.0, -8.0], "start", "level 1");
    svg += &axes.text([-1.6, 0.4], [8.0, 22.0], "start", "level 2");
    svg += &axes.text([0.0, -0.6], [0.0, 0.0], "middle", "limits");
    svg += &axes.dot(unlimited, "#000");
    svg += &axes.text(unlimited, [14.0, -2.0], "start", "without limits");
    svg += &axes.dot([unlimited[0], 1.0], "#888");
    svg += &axes.text([unlimited[0], 1.0], [-2.0, 20.0], "start", "clamped");
    svg += &axes.dot(limited, VERMILLION);
    Ok(svg + &axes.text(limited, [4.0, -12.0], "start", "answer"))
}

/// x_2 against ε: the exact answer jumps, the damped one does not.
fn jump() -> Result<String, Error> {
    let axes = Axes { left: 520.0, bottom: 380.0, from: [-0.2, -1.2], scale: [850.0, 110.0] };
    let values = |damping: Option<Damping>, sign: f64| -> Result<Vec<[f64; 2]>, Error> {
        let epsilons = (0..=200).map(|i| sign * (f64::from(i) + 0.01) * 1e-3);
        epsilons.map(|epsilon| Ok([epsilon, hierarchy::nearly_parallel(epsilon, damping)?.joint_velocity[1]])).collect()
    };
    let mut svg = axes.frame([0.2, 1.8], [&[-0.2, -0.1, 0.0, 0.1, 0.2], &[-1.0, 0.0, 1.0]], ["ε", "x₂ (rad/s)"]);
    for sign in [-1.0, 1.0] {
        svg += &axes.line(values(None, sign)?, &format!("stroke=\"{BLUE}\" stroke-width=\"2.5\""));
        let style = format!("stroke=\"{VERMILLION}\" stroke-width=\"2.5\" stroke-dasharray=\"6 4\"");
        svg += &axes.line(values(Some(Damping::STANDARD), sign)?, &style);
    }
    svg += &axes.text([0.05, 1.0], [0.0, -10.0], "middle", "exact");
    Ok(svg + &axes.text([0.035, 0.2], [14.0, 5.0], "start", "damped"))
}

fn main() -> Result<(), Error> {
    let style = "font-family=\"sans-serif\" font-size=\"14\"";
    let mut svg = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 900 440\" {style}>\n");
    svg += "<title>Two levels within the limits of two joints, and the damped answer at a limit</title>\n";
    svg += "<rect width=\"900\" height=\"440\" fill=\"#fff\"/>\n";
    for (x, heading) in [(60, "(a) The worked example"), (520, "(b) The exact answer jumps")] {
        writeln!(svg, "<text x=\"{x}\" y=\"22\" font-weight=\"bold\">{heading}</text>")?;
    }
    svg += &plane()?;
    svg += &jump()?;
    Ok(std::fs::write("docs/solver.svg", svg + "</svg>\n")?)
}
