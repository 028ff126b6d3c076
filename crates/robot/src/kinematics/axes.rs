//! The six directions of a twist or a wrench, and selections of them.

use nalgebra::DMatrix;

use super::Jacobian;

/// One row of a twist, in base axes at the tool point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Translation along x, m/s.
    X,
    /// Translation along y, m/s.
    Y,
    /// Translation along z, m/s.
    Z,
    /// Rotation about x, rad/s.
    Rx,
    /// Rotation about y, rad/s.
    Ry,
    /// Rotation about z, rad/s.
    Rz,
}

impl Axis {
    /// All six, in the order of a twist: linear, then angular.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::Rx, Self::Ry, Self::Rz];

    /// Row of a twist, wrench or Jacobian, 0 … 5.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// Why a selection is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum AxisSelectionError {
    /// A task without rows asks for nothing.
    #[error("select at least one axis")]
    Empty,
    /// An axis stands twice.
    #[error("axis {0:?} is selected twice")]
    Repeated(Axis),
}

/// The axes that a task is about, in the task's own row order; at least one, none twice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AxisSelection(Vec<Axis>);

impl AxisSelection {
    /// Takes the axes in the given order.
    pub fn new(axes: &[Axis]) -> Result<Self, AxisSelectionError> {
        if axes.is_empty() {
            return Err(AxisSelectionError::Empty);
        }
        match axes.iter().enumerate().find(|(i, axis)| axes[..*i].contains(axis)) {
            Some((_, repeated)) => Err(AxisSelectionError::Repeated(*repeated)),
            None => Ok(Self(axes.to_vec())),
        }
    }

    /// m, the number of rows.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Never true: a selection has at least one axis.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The axes, in row order.
    pub fn axes(&self) -> &[Axis] {
        &self.0
    }

    /// The selected rows of a Jacobian, m × n.
    pub fn rows_of(&self, jacobian: &Jacobian) -> DMatrix<f64> {
        DMatrix::from_fn(self.len(), jacobian.ncols(), |i, j| jacobian[(self.0[i].index(), j)])
    }

    /// A twist or wrench with these entries (m) on the selected axes and zero on the others.
    pub fn spread(&self, entries: &[f64]) -> [f64; 6] {
        let mut six = [0.0; 6];
        self.0.iter().zip(entries).for_each(|(axis, entry)| six[axis.index()] = *entry);
        six
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_follow_the_order_of_the_selection() {
        let jacobian = Jacobian::from_fn(2, |i, j| (10 * i + j) as f64);
        let selection = AxisSelection::new(&[Axis::Rz, Axis::X]).unwrap();
        assert_eq!(selection.rows_of(&jacobian), DMatrix::from_row_slice(2, 2, &[50.0, 51.0, 0.0, 1.0]));
        assert_eq!(selection.spread(&[7.0, 8.0]), [8.0, 0.0, 0.0, 0.0, 0.0, 7.0]);
    }

    #[test]
    fn empty_and_repeated_selections_do_not_exist() {
        assert_eq!(AxisSelection::new(&[]), Err(AxisSelectionError::Empty));
        assert_eq!(AxisSelection::new(&[Axis::Y, Axis::X, Axis::Y]), Err(AxisSelectionError::Repeated(Axis::Y)));
    }
}
