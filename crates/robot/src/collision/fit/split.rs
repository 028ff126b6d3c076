//! Several capsules that contain a mesh.

use nalgebra::Vector3;

use super::capsule::around_points;
use super::fitted_capsule::{FittedCapsule, Triangle};

/// Largest share of the volume of a capsule that its two successors may have together. A split that saves less is not worth the pairs.
const WORTH: f64 = 0.7;

/// Returns at most `most` capsules that contain the triangles, at least one. Each triangle is in one of them.
pub fn around_triangles(triangles: &[Triangle], most: usize) -> Vec<FittedCapsule> {
    let mut parts = vec![Part::of(triangles.to_vec())];
    while parts.len() < most {
        let halves = parts.iter().enumerate().filter_map(|(k, part)| Some((k, part.halves()?)));
        let saved = |(k, halves): &(usize, [Part; 2])| {
            parts[*k].capsule.volume() - halves.iter().map(|half| half.capsule.volume()).sum::<f64>()
        };
        let Some((k, halves)) = halves.max_by(|a, b| saved(a).total_cmp(&saved(b))) else { break };
        parts.swap_remove(k);
        parts.extend(halves);
    }
    parts.iter().map(|part| part.capsule).collect()
}

/// Triangles and the capsule that contains them.
struct Part {
    triangles: Vec<Triangle>,
    capsule: FittedCapsule,
}

impl Part {
    fn of(triangles: Vec<Triangle>) -> Self {
        let points: Vec<Vector3<f64>> = triangles.iter().flatten().copied().collect();
        let capsule = around_points(&points);
        Self { triangles, capsule }
    }

    /// Splits the part across an axis of its frame where the halves are smallest; `None` if that is not worth it.
    fn halves(&self) -> Option<[Self; 2]> {
        let middle = |triangle: &Triangle| triangle.iter().sum::<Vector3<f64>>() / 3.0;
        let mean = self.triangles.iter().map(middle).sum::<Vector3<f64>>() / self.triangles.len() as f64;
        let split = |axis: usize| {
            let is_below = |triangle: &Triangle| middle(triangle)[axis] < mean[axis];
            let (below, above): (Vec<Triangle>, Vec<Triangle>) = self.triangles.iter().partition(|t| is_below(t));
            (!below.is_empty() && !above.is_empty()).then(|| [Self::of(below), Self::of(above)])
        };
        let volume = |halves: &[Self; 2]| halves.iter().map(|half| half.capsule.volume()).sum::<f64>();
        let best = (0..3).filter_map(split).min_by(|a, b| volume(a).total_cmp(&volume(b)))?;
        (volume(&best) < WORTH * self.capsule.volume()).then_some(best)
    }
}
