//! The smallest capsule that contains points.

use nalgebra::{Matrix3, SymmetricEigen, Vector2, Vector3};

use super::fitted_capsule::FittedCapsule;
use crate::shape::Segment;

/// Factors by which the radius may exceed that of the narrowest tube around the points: a wider tube can be shorter.
const WIDER: [f64; 6] = [1.0, 1.02, 1.05, 1.1, 1.2, 1.4];

/// Number of directions whose farthest points stand for all points during the search.
const DIRECTIONS: u32 = 256;

/// First and last step of the search for the direction of the axis, rad.
const STEPS: [f64; 2] = [0.3, 0.01];

/// Steps towards the middle of the smallest circle. Its radius is then right to about one in this number.
const CIRCLE_STEPS: u32 = 64;

/// Share of the radius that covers rounding.
const ROUNDING: f64 = 1e-9;

/// Returns a capsule that contains all points, at least one, and is as small as a search over the direction of its axis finds.
pub fn around_points(points: &[Vector3<f64>]) -> FittedCapsule {
    let outer = outermost(points);
    let axes = principal_axes(&outer);
    let mut best = axes.map(|axis| along(&outer, axis)).into_iter().reduce(smaller).unwrap_or_else(|| point(points));
    let mut step = STEPS[0];
    while step > STEPS[1] {
        let axis = (best.core.to - best.core.from).try_normalize(1e-9).unwrap_or(axes[0]);
        let (u, v) = across(&axis);
        let tilted = [u, -u, v, -v].map(|side| along(&outer, (axis + side * step).normalize()));
        let found = tilted.into_iter().fold(best, smaller);
        if found == best {
            step *= 0.5;
        }
        best = found;
    }
    containing(best, points)
}

fn smaller(a: FittedCapsule, b: FittedCapsule) -> FittedCapsule {
    if b.volume() < a.volume() { b } else { a }
}

fn point(points: &[Vector3<f64>]) -> FittedCapsule {
    FittedCapsule { core: Segment::point(points[0]), radius: 0.0 }
}

/// Returns the capsule with the radius that all points need.
fn containing(capsule: FittedCapsule, points: &[Vector3<f64>]) -> FittedCapsule {
    let distance = |point: &Vector3<f64>| Segment::point(*point).to_segment(&capsule.core).distance;
    let needed = points.iter().map(distance).fold(0.0, f64::max);
    let size = points.iter().map(Vector3::amax).fold(needed, f64::max);
    FittedCapsule { radius: needed + ROUNDING * size, ..capsule }
}

/// Returns the capsule with an axis of this direction that contains the points, as small as it gets.
fn along(points: &[Vector3<f64>], axis: Vector3<f64>) -> FittedCapsule {
    let (u, v) = across(&axis);
    let flat: Vec<Vector2<f64>> = points.iter().map(|point| Vector2::new(u.dot(point), v.dot(point))).collect();
    let (middle, narrowest) = circle(&flat);
    let middle = u * middle.x + v * middle.y;
    let capsule = |wider: f64| {
        let radius = wider * narrowest;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for point in points {
            let along = axis.dot(point);
            let aside = (point - middle - axis * along).norm_squared();
            let reach = (radius * radius - aside).max(0.0).sqrt();
            (low, high) = (low.min(along + reach), high.max(along - reach));
        }
        if low > high {
            (low, high) = (0.5 * (low + high), 0.5 * (low + high));
        }
        FittedCapsule { core: Segment { from: middle + axis * low, to: middle + axis * high }, radius }
    };
    WIDER[1..].iter().map(|wider| capsule(*wider)).fold(capsule(WIDER[0]), smaller)
}

/// Returns middle and radius of a circle that contains the points, nearly the smallest one (Bădoiu and Clarkson): the middle moves ever
/// smaller steps towards the farthest point.
fn circle(points: &[Vector2<f64>]) -> (Vector2<f64>, f64) {
    let farthest = |middle: &Vector2<f64>| {
        let squared = |point: &&Vector2<f64>| (**point - middle).norm_squared();
        points.iter().max_by(|a, b| squared(a).total_cmp(&squared(b))).copied().unwrap_or(*middle)
    };
    let mut middle = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
    for step in 1..=CIRCLE_STEPS {
        middle += (farthest(&middle) - middle) / f64::from(step + 1);
    }
    (middle, (farthest(&middle) - middle).norm())
}

/// Returns the points that are farthest in some direction.
fn outermost(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let mut kept: Vec<usize> = (0..DIRECTIONS)
        .filter_map(|k| {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(DIRECTIONS);
            let (sin, cos) = (golden * f64::from(k)).sin_cos();
            let direction = Vector3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            let height = |k: &usize| direction.dot(&points[*k]);
            (0..points.len()).max_by(|a, b| height(a).total_cmp(&height(b)))
        })
        .collect();
    kept.sort_unstable();
    kept.dedup();
    kept.iter().map(|k| points[*k]).collect()
}

/// Returns the eigenvectors of the covariance of the points.
fn principal_axes(points: &[Vector3<f64>]) -> [Vector3<f64>; 3] {
    let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let products = points.iter().map(|point| (point - middle) * (point - middle).transpose());
    let vectors = SymmetricEigen::new(products.sum::<Matrix3<f64>>()).eigenvectors;
    [0, 1, 2].map(|k| vectors.column(k).into_owned())
}

/// Returns two unit vectors that are orthogonal to a unit vector and to each other.
fn across(axis: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let u = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
    (u, axis.cross(&u))
}
