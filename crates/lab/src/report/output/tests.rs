//! The files of a report.

use super::*;
use crate::report::figure::{self, Colour, Curve, Panel, Stroke};
use crate::report::{Report, Section};

fn report() -> Report {
    let curve = Curve {
        label: "F_x".to_owned(),
        colour: Colour::Blue,
        stroke: Stroke::Dashed,
        points: vec![(0.0, 0.0), (1.0, 30.0)],
    };
    let panel = Panel {
        heading: "(a)".to_owned(),
        x_label: figure::TIME.to_owned(),
        y_label: "force (N)".to_owned(),
        window: (0.0, 1.0),
        y_covers: vec![],
        curves: vec![curve],
    };
    let figure = Figure {
        name: "figure5_nominal".to_owned(),
        title: "Force".to_owned(),
        caption: String::new(),
        panels: vec![panel],
    };
    Report {
        title: "Title".to_owned(),
        sections: vec![Section { name: "a".to_owned(), figures: vec![figure], ..Section::default() }],
        ..Report::default()
    }
}

const ALL: [Output; 3] = [Output::Page, Output::Svg, Output::Png];

fn directory(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("revprio-{name}-{}", std::process::id()))
}

/// Returns width and height from the header of a PNG file (pixels).
fn png_size(bytes: &[u8]) -> [u32; 2] {
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()))
}

#[test]
fn figure_is_written_as_svg_as_png_of_three_times_its_size_and_into_the_page() {
    let directory = directory("figures");
    let written = write(&directory, &report(), &ALL).unwrap();
    let names = ["figure5_nominal.svg", "figure5_nominal.png", "index.html"];
    assert_eq!(written, names.map(|name| directory.join(name)));

    let [svg, page] = [&written[0], &written[2]].map(|path| fs::read_to_string(path).unwrap());
    assert!(page.contains(&svg));
    let [width, height] = png_size(&fs::read(&written[1]).unwrap());
    assert!(svg.contains(&format!(r#"width="{}" height="{}""#, width / 3, height / 3)));
    fs::remove_dir_all(directory).unwrap();
}

#[test]
fn only_requested_files_are_written() {
    let directory = directory("requested");
    let written = write(&directory, &report(), &[Output::Svg]).unwrap();
    assert_eq!(written, [directory.join("figure5_nominal.svg")]);
    assert_eq!(fs::read_dir(&directory).unwrap().count(), 1);
    fs::remove_dir_all(directory).unwrap();
}

#[test]
fn same_report_gives_the_same_picture() {
    let figure = &report().sections[0].figures[0];
    assert_eq!(drawing::svg(figure).unwrap(), drawing::svg(figure).unwrap());
}

#[test]
fn error_names_the_path_and_the_cause() {
    let file = directory("file");
    fs::write(&file, "").unwrap();
    let error = write(&file, &report(), &ALL).unwrap_err();
    assert!(error.to_string().contains(&file.display().to_string()));
    let source = std::error::Error::source(&error).unwrap();
    assert!(error.to_string().ends_with(&source.to_string()), "{error}");
    fs::remove_file(file).unwrap();
}
