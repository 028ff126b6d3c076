//! Working sets in the names of bounds, which outlive a problem.

use revprio_problem::{ActiveSet, Bound, BoundId};

use super::hierarchy::Hierarchy;
use super::solution::WorkingSet;

/// Writes the working set that a guess means in a problem; bounds that the problem does not have are left out.
pub fn write_guess(levels: &Hierarchy, guess: &[ActiveSet], set: &mut WorkingSet) {
    set.clear(levels.unknowns, levels.rows.len());
    // Names ascend in a guess, and mostly in a problem, so that each search begins where the last one ended.
    let mut at = 0;
    for bound in guess.iter().flatten() {
        if let BoundId::Joint(joint) = bound.id {
            if let Some(place) = set.unknowns.get_mut(joint) {
                *place = Some(bound.side);
            }
            continue;
        }
        let place = |rows: std::ops::Range<usize>| rows.clone().find(|&row| levels.rows[row].origin == Some(bound.id));
        if let Some(row) = place(at..levels.rows.len()).or_else(|| place(0..at)) {
            set.rows[row] = Some(bound.side);
            at = row;
        }
    }
}

/// Writes the active bounds of a working set for n joints, by ascending names: the rows of a problem are in the order of its
/// levels, which need not be that of their names.
pub fn write_active_set(levels: &Hierarchy, n: usize, set: &WorkingSet, active: &mut ActiveSet) {
    let joints = set.unknowns[..n].iter().enumerate().map(|(joint, side)| (Some(BoundId::Joint(joint)), side));
    let rows = levels.rows.iter().map(|row| row.origin).zip(&set.rows);
    active.clear();
    active.extend(joints.chain(rows).filter_map(|(id, side)| Some(Bound { id: id?, side: (*side)? })));
    active.sort_unstable_by_key(|bound| bound.id);
}
