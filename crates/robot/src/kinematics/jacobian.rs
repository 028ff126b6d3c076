//! Jacobians of points of a tree.

use nalgebra::{Matrix6xX, Vector3};

use crate::forward::JointFrame;
use crate::tree::Tree;

/// Jacobian, 6 × n: linear rows (m/s), then angular rows (rad/s), along the base axes, at a point; by default the tool point.
pub type Jacobian = Matrix6xX<f64>;

/// A joint that moves a point of one link relative to another link.
pub(super) struct Mover {
    joint: usize,
    /// 1 if the joint moves the point, −1 if it moves the link from which the motion is seen.
    sign: f64,
}

impl Mover {
    /// Returns the joints between the links that two joints carry (`None`: the base), those of their common part left out.
    pub(super) fn between(tree: &Tree, carrier: Option<usize>, observer: Option<usize>) -> impl Iterator<Item = Self> {
        let (mut carrier, mut observer) = (carrier, observer);
        std::iter::from_fn(move || {
            // A parent has a smaller index than its child, and the base is below all. So the larger of both is no common
            // ancestor.
            if carrier == observer {
                return None;
            }
            let (end, sign) = if carrier > observer { (&mut carrier, 1.0) } else { (&mut observer, -1.0) };
            let joint = (*end)?;
            *end = tree.moving()[joint].parent;
            Some(Self { joint, sign })
        })
    }

    /// Returns whether the joint moves the point, not the link from which the motion is seen.
    pub(super) fn moves_carrier(&self) -> bool {
        self.sign > 0.0
    }

    /// Returns the entry of the joint position that moves the joint, and the column it adds for a point (base frame, m).
    #[inline]
    pub(super) fn column(&self, tree: &Tree, frames: &[JointFrame], point: &Vector3<f64>) -> (usize, [f64; 6]) {
        let (joint, frame) = (&tree.moving()[self.joint], &frames[self.joint]);
        let scale = self.sign * joint.multiplier;
        let [x, y, z] = [frame.direction[0] * scale, frame.direction[1] * scale, frame.direction[2] * scale];
        let column = if joint.kind.is_translation() {
            [x, y, z, 0.0, 0.0, 0.0]
        } else {
            let [dx, dy, dz] = [point.x - frame.origin[0], point.y - frame.origin[1], point.z - frame.origin[2]];
            [y * dz - z * dy, z * dx - x * dz, x * dy - y * dx, x, y, z]
        };
        (joint.coordinate, column)
    }
}

/// Overwrites the Jacobian (6 × n) with that of a point (base frame, m) on the link of `carrier`, seen from that of
/// `observer`.
pub(super) fn write_jacobian(
    tree: &Tree,
    frames: &[JointFrame],
    [carrier, observer]: [Option<usize>; 2],
    point: &Vector3<f64>,
    jacobian: &mut Jacobian,
) {
    let (columns, _) = jacobian.as_mut_slice().as_chunks_mut::<6>();
    columns.fill([0.0; 6]);
    for mover in Mover::between(tree, carrier, observer) {
        let (coordinate, column) = mover.column(tree, frames, point);
        for row in 0..6 {
            columns[coordinate][row] += column[row];
        }
    }
}
