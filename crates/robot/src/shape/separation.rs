//! Distance and common normal of two convex cores, by closed formulas.
//!
//! A shape is a *core* and a radius: a capsule is a segment, a sphere a point. The distance of two shapes is the distance of
//! their cores less both radii.
//!
//! # The common normal
//!
//! While two convex cores P and Q are apart, x, the point of P − Q next to zero, is unique, and so is n = x/|x|. It turns
//! continuously as the cores move, also where segments become parallel and their nearest points jump. For every unit vector n
//! and all points, with σ(n) the largest n·f over the points f of Q,
//!
//! > dist(P, Q) ≥ min over the ends e of P of n·e − σ(n),
//!
//! because n separates the cores by that much and a linear function has its minimum at an end. With the common normal both sides are
//! equal.
//!
//! Where the cores intersect, there is no such normal. The result is then a direction in which they come apart by a short way, and the
//! distance is minus that way.

use nalgebra::{IsometryMatrix3, Vector3};

/// Length below which a direction is rounding, m.
const TINY: f64 = 1e-12;

/// Square of the sine of an angle below which rounding moves the nearest points of two lines.
const NEARLY_PARALLEL: f64 = 1e-6;

/// The core of a capsule: the points between two ends, m. Both are the same for a sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// One end.
    pub from: Vector3<f64>,
    /// The other end.
    pub to: Vector3<f64>,
}

/// A box with a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedBox {
    /// The pose of its middle.
    pub pose: IsometryMatrix3<f64>,
    /// Half of its edges, m.
    pub half: Vector3<f64>,
}

/// The distance of two cores.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Separation {
    /// Distance, m; negative: how far the cores intersect.
    pub distance: f64,
    /// n, a unit vector from the second core towards the first one.
    pub normal: Vector3<f64>,
    /// The point of the first core that is next to the second one, m.
    pub nearest: Vector3<f64>,
}

impl Segment {
    /// Returns the segment of a sphere.
    pub fn point(position: Vector3<f64>) -> Self {
        Self { from: position, to: position }
    }

    /// Returns the same segment in the frame that contains `pose`.
    #[must_use]
    pub fn moved(&self, pose: &IsometryMatrix3<f64>) -> Self {
        let moved = |point: &Vector3<f64>| pose.rotation * point + pose.translation.vector;
        Self { from: moved(&self.from), to: moved(&self.to) }
    }

    /// Returns the same segment, shifted by `way`, m.
    #[must_use]
    pub fn shifted(&self, way: Vector3<f64>) -> Self {
        Self { from: self.from + way, to: self.to + way }
    }

    /// Returns both ends.
    pub fn ends(&self) -> [Vector3<f64>; 2] {
        [self.from, self.to]
    }

    /// Returns σ(n), the largest n·f over the points f of the segment, m.
    #[inline]
    pub fn support(&self, normal: &Vector3<f64>) -> f64 {
        normal.dot(&self.from).max(normal.dot(&self.to))
    }

    /// Returns the smallest n·e over the points e of the segment, m.
    #[inline]
    pub fn least(&self, normal: &Vector3<f64>) -> f64 {
        normal.dot(&self.from).min(normal.dot(&self.to))
    }

    /// Returns the distance to another segment.
    pub fn to_segment(&self, other: &Self) -> Separation {
        let (u, v, between) = (self.to - self.from, other.to - other.from, self.from - other.from);
        let (s, t) = nearest_parameters(&u, &v, &between);
        let nearest = self.from + u * s;
        let difference = nearest - (other.from + v * t);
        let distance = difference.norm();
        if distance > TINY {
            return Separation { distance, normal: difference / distance, nearest };
        }
        let middles = between + 0.5 * (u - v);
        let across = u.cross(&v);
        let away = [across, middles, u.cross(&any_across(&u)), Vector3::z()];
        let normal = away.iter().find_map(|way| way.try_normalize(TINY)).unwrap_or_else(Vector3::z);
        Separation { distance, normal: if normal.dot(&middles) < 0.0 { -normal } else { normal }, nearest }
    }

    /// Returns the distance to a half-space n·x ≤ offset whose unit normal n points to the free side.
    pub fn to_half_space(&self, normal: &Vector3<f64>, offset: f64) -> Separation {
        let [a, b] = self.ends().map(|end| normal.dot(&end));
        let nearest = if a <= b { self.from } else { self.to };
        Separation { distance: a.min(b) - offset, normal: *normal, nearest }
    }

    /// Returns the distance to a box.
    pub fn to_box(&self, other: &OrientedBox) -> Separation {
        let (half, rotation) = (&other.half, &other.pose.rotation);
        let local = |point: &Vector3<f64>| rotation.inverse() * (point - other.pose.translation.vector);
        let (from, to) = (local(&self.from), local(&self.to));
        let along = to - from;
        let t = nearest_to_box(&from, &along, half);
        let point = from + along * t;
        let outside = point.zip_map(half, |x, h| x - x.clamp(-h, h));
        let (distance, nearest) = (outside.norm(), self.from + (self.to - self.from) * t);
        if distance > TINY {
            return Separation { distance, normal: rotation * (outside / distance), nearest };
        }
        let (depth, normal) = shallowest_face(&from, &to, half);
        Separation { distance: depth, normal: rotation * normal, nearest }
    }
}

impl OrientedBox {
    /// Returns σ(n), the largest n·f over the points f of the box, m.
    #[inline]
    pub fn support(&self, normal: &Vector3<f64>) -> f64 {
        let local = self.pose.rotation.inverse() * normal;
        normal.dot(&self.pose.translation.vector) + local.abs().dot(&self.half)
    }

    /// Returns the same box, shifted by `way`, m.
    #[must_use]
    pub fn shifted(mut self, way: Vector3<f64>) -> Self {
        self.pose.translation.vector += way;
        self
    }
}

/// Returns s and t in 0 … 1 for which |b + s u − t v| is least.
fn nearest_parameters(u: &Vector3<f64>, v: &Vector3<f64>, between: &Vector3<f64>) -> (f64, f64) {
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(v));
    let (ub, vb) = (u.dot(between), v.dot(between));
    let clamp = |x: f64| x.clamp(0.0, 1.0);
    if uu <= TINY * TINY {
        return (0.0, if vv <= TINY * TINY { 0.0 } else { clamp(vb / vv) });
    }
    if vv <= TINY * TINY {
        return (clamp(-ub / uu), 0.0);
    }
    // The determinant as that of a cross product, which does not cancel where the segments are nearly parallel.
    let determinant = u.cross(v).norm_squared();
    let inner = if determinant > 0.0 { clamp((uv * vb - ub * vv) / determinant) } else { 0.0 };
    let of_t = |t: f64| (clamp((t * uv - ub) / uu), t);
    if determinant > NEARLY_PARALLEL * uu * vv {
        // The best s of the lines, clamped, has a best t. If that lies outside, the nearer end of the other segment is nearest.
        let across = (vb + inner * uv) / vv;
        return if (0.0..=1.0).contains(&across) { (inner, across) } else { of_t(clamp(across)) };
    }
    // The function is convex, so the best of what each edge and the inside give is the best of all.
    let of_s = |s: f64| (s, clamp((vb + s * uv) / vv));
    let length = |(s, t): (f64, f64)| (between + u * s - v * t).norm_squared();
    let mut best = of_s(inner);
    let mut least = length(best);
    for candidate in [of_s(0.0), of_s(1.0), of_t(0.0), of_t(1.0)] {
        let found = length(candidate);
        if found < least {
            (best, least) = (candidate, found);
        }
    }
    best
}

/// Returns t in 0 … 1 for which the point `from` + t `along` is next to the box of half edges `half` about the origin.
///
/// The square of the distance is convex, and its derivative is continuous and linear between the places where an entry passes
/// a face. So its zero lies between two of them.
fn nearest_to_box(from: &Vector3<f64>, along: &Vector3<f64>, half: &Vector3<f64>) -> f64 {
    let slope = |t: f64| -> f64 {
        (0..3).map(|i| (from[i] + t * along[i], along[i], half[i])).map(|(x, a, h)| a * (x - x.clamp(-h, h))).sum()
    };
    let (mut low, mut high) = ((0.0, slope(0.0)), (1.0, slope(1.0)));
    if low.1 >= 0.0 {
        return 0.0;
    }
    if high.1 <= 0.0 {
        return 1.0;
    }
    for i in 0..3 {
        for face in [-half[i], half[i]] {
            let t = (face - from[i]) / along[i];
            if t > low.0 && t < high.0 {
                let at = (t, slope(t));
                *(if at.1 <= 0.0 { &mut low } else { &mut high }) = at;
            }
        }
    }
    let rise = high.1 - low.1;
    if rise > 0.0 { low.0 - low.1 * (high.0 - low.0) / rise } else { low.0 }
}

/// Returns the face through which a segment leaves a box by the shortest way: minus that way, and the face's normal.
fn shallowest_face(from: &Vector3<f64>, to: &Vector3<f64>, half: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let mut best = (f64::NEG_INFINITY, Vector3::z());
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let depth = (sign * from[axis]).min(sign * to[axis]) - half[axis];
            if depth > best.0 {
                best = (depth, Vector3::ith(axis, sign));
            }
        }
    }
    best
}

/// Returns a vector that is not parallel to `direction`.
fn any_across(direction: &Vector3<f64>) -> Vector3<f64> {
    Vector3::ith(direction.iamin(), 1.0)
}

#[cfg(test)]
mod tests;
