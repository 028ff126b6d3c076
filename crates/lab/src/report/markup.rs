//! Completes the SVG of the drawing library: indices, an accessible name, and a root element that scales with the page.

use super::figure::Figure;
use super::index::{Piece, pieces};
use super::sheet::{UNITS_PER_PIXEL, WIDTH};

/// Returns the SVG document of a figure with the given height (pixels) from the output of the drawing library.
#[must_use]
pub fn finished(drawn: &str, figure: &Figure, height: u32) -> String {
    let (_root, elements) = drawn.split_once('\n').unwrap_or_default();
    let mut svg = root(&figure.title, height);
    for line in elements.lines() {
        svg.push_str(&if line.starts_with('<') { line.to_owned() } else { indexed(line) });
        svg.push('\n');
    }
    svg
}

fn root(title: &str, height: u32) -> String {
    let (units_x, units_y) = (WIDTH * UNITS_PER_PIXEL, height * UNITS_PER_PIXEL);
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" \
         viewBox=\"0 0 {units_x} {units_y}\" stroke-linejoin=\"round\" role=\"img\">\n\
         <title>{title}</title>\n"
    )
}

/// Returns the text of an element with its indices as `tspan` elements. They use `dy`, which stays in force until the next
/// `dy`, because not every browser supports `baseline-shift`.
fn indexed(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut lowered = false;
    for piece in pieces(text) {
        match piece {
            Piece::Index(index) => {
                out.extend([r#"<tspan dy="0.3em" font-size="72%">"#, index, "</tspan>"]);
            }
            Piece::Line(line) if lowered => {
                out.extend([r#"<tspan dy="-0.216em">"#, line, "</tspan>"]);
            }
            Piece::Line(line) => out.push_str(line),
        }
        lowered = matches!(piece, Piece::Index(_));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::indexed;

    #[test]
    fn text_after_an_index_returns_to_the_baseline() {
        let expected = r#"F<tspan dy="0.3em" font-size="72%">x</tspan><tspan dy="-0.216em"> (N)</tspan>"#;
        assert_eq!(indexed("F_x (N)"), expected);
    }
}
