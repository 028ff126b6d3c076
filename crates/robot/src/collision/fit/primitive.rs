//! Capsules that contain cylinders and boxes.

use nalgebra::Vector3;

use super::fitted_capsule::FittedCapsule;
use crate::shape::Segment;

/// Largest number of capsules for one box.
pub const MOST_PER_BOX: usize = 4;

/// Returns the smallest capsule along the axis of a cylinder that contains it; the axis is z.
///
/// A core that ends δ before the faces needs the radius √(r² + δ²) to contain their rims.
pub fn around_cylinder(radius: f64, length: f64) -> FittedCapsule {
    const STEPS: u32 = 64;
    let capsule = |step: u32| {
        let shorter = 0.5 * length * f64::from(step) / f64::from(STEPS);
        let end = Vector3::z() * (0.5 * length - shorter);
        FittedCapsule { core: Segment { from: -end, to: end }, radius: radius.hypot(shorter) }
    };
    let volume = |capsule: &FittedCapsule| capsule.volume();
    (1..=STEPS).map(capsule).fold(capsule(0), |best, next| if volume(&next) < volume(&best) { next } else { best })
}

/// Returns capsules along the longest edge of a box that contain it: as many beside each other as its cross-section is wider than high.
pub fn around_box(size: &Vector3<f64>) -> Vec<FittedCapsule> {
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| size[*b].total_cmp(&size[*a]));
    let [along, across, up] = axes;
    let fitting = (1..=MOST_PER_BOX).find(|count| size[across] <= 1.5 * *count as f64 * size[up]);
    let count = fitting.unwrap_or(MOST_PER_BOX);
    let width = size[across] / count as f64;
    let FittedCapsule { core, radius } = around_cylinder(0.5 * width.hypot(size[up]), size[along]);
    let capsule = |k: usize| {
        let middle = Vector3::ith(across, width * (k as f64 + 0.5) - 0.5 * size[across]);
        let end = Vector3::ith(along, core.to.z);
        FittedCapsule { core: Segment { from: middle - end, to: middle + end }, radius }
    };
    (0..count).map(capsule).collect()
}
