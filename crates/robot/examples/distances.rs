//! Prints the distances of pairs of shapes, one a line, for `tools/check/distances.py`, which compares them with Coal's.
//!
//! Each line of the input is a pair: the kind, the ends and the radius of a capsule (7 numbers, m), and then
//!
//! - `capsule`: the ends and the radius of another one (7);
//! - `box`: middle (3), rotation by rows (9) and half edges (3);
//! - `half_space`: normal (3) and offset (1).
//!
//! ```sh
//! echo 'capsule 0 0 0 1 0 0 0.1  0 0 1 0 1 1 0.1' | cargo run -p revprio-robot --example distances
//! ```

use std::error::Error;
use std::io::{BufRead, BufWriter, Write, stdin, stdout};

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3, Vector3};
use revprio_robot::collision::{OrientedBox, Segment};

fn main() -> Result<(), Box<dyn Error>> {
    let mut output = BufWriter::new(stdout().lock());
    for line in stdin().lock().lines() {
        writeln!(output, "{:?}", distance(&line?)?)?;
    }
    Ok(output.flush()?)
}

/// Returns the distance of the pair of a line, m.
fn distance(line: &str) -> Result<f64, Box<dyn Error>> {
    let (kind, rest) = line.split_once(' ').ok_or("a line without numbers")?;
    let numbers: Vec<f64> = rest.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
    let (capsule, other) = numbers.split_at_checked(7).ok_or("a line without a capsule")?;
    let (segment, radius) = (segment(capsule), capsule[6]);
    match (kind, other.len()) {
        ("capsule", 7) => Ok(segment.to_segment(&self::segment(other)).distance - radius - other[6]),
        ("box", 15) => Ok(segment.to_box(&oriented_box(other)).distance - radius),
        ("half_space", 4) => Ok(segment.to_half_space(&vector(other), other[3]).distance - radius),
        _ => Err(format!("a pair of the kind `{kind}` with {} numbers", other.len()).into()),
    }
}

fn vector(numbers: &[f64]) -> Vector3<f64> {
    Vector3::new(numbers[0], numbers[1], numbers[2])
}

fn segment(numbers: &[f64]) -> Segment {
    Segment { from: vector(numbers), to: vector(&numbers[3..]) }
}

fn oriented_box(numbers: &[f64]) -> OrientedBox {
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&numbers[3..12]));
    let pose = IsometryMatrix3::from_parts(Translation3::from(vector(numbers)), rotation);
    OrientedBox { pose, half: vector(&numbers[12..]) }
}
