//! Rotations of all joints about their axes.

use super::angle::Angle;
use super::sin_cos::{MAX_ANGLE, sin_cos};
use crate::JointKind;

/// The rotations of the joints about their z axes: by q + offset for a revolute joint, by the offset for a prismatic one.
///
/// Numbers of the same kind are adjacent, so the compiler processes two or four joints per instruction.
#[derive(Debug, Clone, PartialEq)]
pub struct JointRotations {
    /// n.
    offset_sines: Vec<f64>,
    /// n.
    offset_cosines: Vec<f64>,
    /// 1 for a revolute joint, 0 for a prismatic one, n.
    revolute: Vec<f64>,
}

impl JointRotations {
    pub fn new(kinds: impl Iterator<Item = JointKind>, offsets: &[Angle]) -> Self {
        let revolute = |kind: JointKind| if kind.is_translation() { 0.0 } else { 1.0 };
        Self {
            offset_sines: offsets.iter().map(|offset| offset.sine).collect(),
            offset_cosines: offsets.iter().map(|offset| offset.cosine).collect(),
            revolute: kinds.map(revolute).collect(),
        }
    }

    /// Overwrites `sines` and `cosines` (n) with those of the rotations.
    ///
    /// `joint_position`: q, n; rad or m; finite.
    // Not inlined: the compiler knows of arguments that they do not overlap.
    #[inline(never)]
    pub fn evaluate(&self, joint_position: &[f64], sines: &mut [f64], cosines: &mut [f64]) {
        let mut all_moderate = true;
        for (((angle, offset), sine), cosine) in self.angles(joint_position).zip(&mut *sines).zip(&mut *cosines) {
            (*sine, *cosine) = sum(sin_cos(angle), offset);
            all_moderate &= angle.abs() <= MAX_ANGLE;
        }
        if !all_moderate {
            self.evaluate_large(joint_position, sines, cosines);
        }
    }

    /// Overwrites the entries of the angles beyond [`MAX_ANGLE`], with functions of the standard library.
    #[cold]
    fn evaluate_large(&self, joint_position: &[f64], sines: &mut [f64], cosines: &mut [f64]) {
        for (((angle, offset), sine), cosine) in self.angles(joint_position).zip(sines).zip(cosines) {
            if angle.abs() > MAX_ANGLE {
                (*sine, *cosine) = sum(angle.sin_cos(), offset);
            }
        }
    }

    /// Returns the angle of each joint (rad, zero for a prismatic joint) with sine and cosine of its offset.
    #[inline]
    fn angles(&self, joint_position: &[f64]) -> impl Iterator<Item = (f64, (&f64, &f64))> {
        let angles = joint_position.iter().zip(&self.revolute).map(|(q, revolute)| q * revolute);
        angles.zip(self.offset_sines.iter().zip(&self.offset_cosines))
    }
}

/// Returns sine and cosine of the sum of two angles, each given by its sine and cosine.
#[inline]
fn sum((sine, cosine): (f64, f64), (offset_sine, offset_cosine): (&f64, &f64)) -> (f64, f64) {
    (sine * offset_cosine + cosine * offset_sine, cosine * offset_cosine - sine * offset_sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rotations(kinds: &[JointKind], offset: Angle) -> JointRotations {
        JointRotations::new(kinds.iter().copied(), &vec![offset; kinds.len()])
    }

    fn evaluate(rotations: &JointRotations, joint_position: &[f64]) -> Vec<(f64, f64)> {
        let mut sines = vec![f64::NAN; joint_position.len()];
        let mut cosines = sines.clone();
        rotations.evaluate(joint_position, &mut sines, &mut cosines);
        sines.into_iter().zip(cosines).collect()
    }

    #[test]
    fn angles_of_every_size_are_those_of_the_standard_library() {
        let positions = [0.0, -1.5, 3.0, 5e5, -5e5, 5e5_f64.next_up(), -1e15, 1e300, f64::MAX];
        let all = evaluate(&rotations(&[JointKind::Revolute; 9], Angle::ZERO), &positions);
        for (position, (sine, cosine)) in positions.iter().zip(all) {
            let (expected_sine, expected_cosine) = position.sin_cos();
            assert!((sine - expected_sine).abs() < 2e-16 && (cosine - expected_cosine).abs() < 2e-16, "{position:e}");
        }
    }

    #[test]
    fn offsets_are_added_to_revolute_joints_and_prismatic_joints_do_not_rotate() {
        let (offset, kinds) = (0.7_f64, [JointKind::Revolute, JointKind::Prismatic, JointKind::Revolute]);
        let rotations = rotations(&kinds, Angle { sine: offset.sin(), cosine: offset.cos() });
        let cases: [(_, [f64; 3]); 2] =
            [([0.3, 2.0, -4.0], [1.0, 0.7, -3.3]), ([1e-9, 1e300, 6.0], [0.7 + 1e-9, 0.7, 6.7])];
        for (positions, angles) in cases {
            for ((sine, cosine), angle) in evaluate(&rotations, &positions).into_iter().zip(angles) {
                assert!((sine - angle.sin()).abs() < 1e-15 && (cosine - angle.cos()).abs() < 1e-15, "{angle}");
            }
        }
    }
}
