//! Binary and ASCII files that programs write, and files that are cut.

use nalgebra::Vector3;

use super::{StlError, Triangle, read};

/// Coordinates that single precision represents exactly.
fn triangles(count: usize) -> Vec<Triangle> {
    let corner = |k: usize, i: usize| Vector3::new(0.25 * k as f64, 0.5 * i as f64, -1.0);
    (0..count).map(|k| [corner(k, 0), corner(k, 1), corner(k + 1, 2)]).collect()
}

/// A binary file of these triangles.
#[expect(clippy::cast_possible_truncation, reason = "single precision represents the coordinates")]
fn binary(header: &str, triangles: &[Triangle]) -> Vec<u8> {
    let mut bytes = format!("{header:80}").into_bytes();
    bytes.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
    for triangle in triangles {
        let numbers = [0.0, 0.0, 1.0].iter().chain(triangle.iter().flatten());
        bytes.extend(numbers.flat_map(|number| (*number as f32).to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

/// An ASCII file of these triangles.
fn ascii(triangles: &[Triangle]) -> String {
    let corners = |triangle: &Triangle| triangle.map(|p| format!("vertex {} {} {}\n", p.x, p.y, p.z)).concat();
    let facet = |t: &Triangle| format!("facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n", corners(t));
    format!("solid a part\n{}endsolid a part\n", triangles.iter().map(facet).collect::<String>())
}

#[test]
fn a_binary_file_may_begin_with_solid() {
    for count in [1, 2, 13, 14, 100] {
        for header in ["written by CAD", "solid foot", "solid a\nfacet normal", "SOLID"] {
            assert_eq!(read(&binary(header, &triangles(count))), Ok(triangles(count)), "{header}, {count}");
        }
    }
    let with_line_break = [binary("solid", &triangles(3)), b"\r\n".to_vec()].concat();
    assert_eq!(read(&with_line_break), Ok(triangles(3)));
}

#[test]
fn a_binary_file_with_another_size_than_its_header_says_is_refused() {
    for header in ["written by CAD", "solid foot"] {
        let whole = binary(header, &triangles(1000));
        for size in [84, 84 + 50 * 500, 84 + 50 * 500 + 7, whole.len() - 1] {
            let error = read(&whole[..size]).unwrap_err();
            assert_eq!(error, StlError::Size { stated: 1000, found: (size - 84) / 50, size }, "{header}");
        }
        let longer = [whole.as_slice(), &[0; 100]].concat();
        assert_eq!(read(&longer), Err(StlError::Size { stated: 1000, found: 1002, size: longer.len() }));
    }
    let error = read(&binary("", &triangles(1000))[..84 + 50 * 500]).unwrap_err().to_string();
    assert!(error.contains("states 1000 triangles") && error.contains("is that of 500"), "{error}");
    assert_eq!(read(b""), Err(StlError::NotStl));
    assert_eq!(read(b"version https://git-lfs.github.com/spec/v1"), Err(StlError::NotStl));
}

#[test]
fn ascii_files_are_read_whatever_their_name_case_and_lines_are() {
    let text = ascii(&triangles(9));
    let files = [
        text.clone(),
        text.replace("solid a part", "solid"),
        text.to_uppercase(),
        format!("\n  {}", text.replace('\n', "  \n\t")),
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.trim_end().to_owned(),
        format!("\u{feff}{text}"),
        text.replace("loop\nvertex", "loop vertex").replace("endloop\nend", "endloop end"),
        text.replace("vertex ", "vertex\n"),
    ];
    for file in files {
        assert_eq!(read(file.as_bytes()), Ok(triangles(9)), "{file}");
    }
    let latin_1 = [b"solid \xe9t\xe9\n", text.split_once('\n').unwrap().1.as_bytes()].concat();
    assert_eq!(read(&latin_1), Ok(triangles(9)));
    assert_eq!(read(format!("{text}{text}").as_bytes()), Ok([triangles(9), triangles(9)].concat()));
    assert_eq!(read(b"solid\nendsolid"), Ok(Vec::new()));
}

#[test]
fn an_ascii_file_that_is_cut_or_wrong_is_refused() {
    let text = ascii(&triangles(2));
    let lines: Vec<&str> = text.lines().collect();
    for count in 1..lines.len() {
        assert_eq!(read(lines[..count].join("\n").as_bytes()), Err(StlError::Unfinished), "{count} lines");
    }
    let refused = |from: &str, to: &str| read(text.replacen(from, to, 1).as_bytes()).unwrap_err();
    let word = |facet, expected| StlError::Word { facet, expected };
    assert_eq!(refused("normal 0 0 1", "normal 0 0"), word(1, "X Y Z behind normal"));
    assert_eq!(refused("vertex 0 0 -1", "vertex 0 0"), word(1, "X Y Z behind vertex"));
    assert_eq!(refused("vertex 0 0 -1", "vertex 0 0 -1 2"), word(1, "vertex"));
    assert_eq!(refused("vertex 0 0 -1\n", ""), word(1, "vertex"));
    assert_eq!(refused("endfacet\nfacet", "endfacet\nsolid"), word(2, "facet"));
    assert_eq!(refused("endsolid a part", "endsolid\nfacet"), word(3, "solid"));
}
