//! The six axes of a twist or a wrench, and selections of them.

use nalgebra::DMatrix;

use super::Jacobian;

/// One row of a twist, wrench or Jacobian.
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
    /// All six axes in the order of a twist: linear, then angular.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::Rx, Self::Ry, Self::Rz];

    /// Returns the row of a twist, wrench or Jacobian, 0 … 5.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// Why a selection is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum AxisSelectionError {
    /// No axis is selected.
    #[error("select at least one axis")]
    Empty,
    /// An axis is selected twice.
    #[error("axis {0:?} is selected twice")]
    Repeated(Axis),
}

/// The axes of a task in the order of its rows; at least one, none twice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AxisSelection(Vec<Axis>);

impl AxisSelection {
    /// Selects the axes in the given order.
    pub fn new(axes: &[Axis]) -> Result<Self, AxisSelectionError> {
        if axes.is_empty() {
            return Err(AxisSelectionError::Empty);
        }
        match axes.iter().enumerate().find(|(i, axis)| axes[..*i].contains(axis)) {
            Some((_, repeated)) => Err(AxisSelectionError::Repeated(*repeated)),
            None => Ok(Self(axes.to_vec())),
        }
    }

    /// Returns m, the number of rows.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns false: a selection has at least one axis.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the axes in row order.
    pub fn axes(&self) -> &[Axis] {
        &self.0
    }

    /// Returns the selected rows of a Jacobian, m × n.
    pub fn rows_of(&self, jacobian: &Jacobian) -> DMatrix<f64> {
        DMatrix::from_fn(self.len(), jacobian.ncols(), |i, j| jacobian[(self.0[i].index(), j)])
    }

    /// Returns a twist or wrench with these entries (m) on the selected axes and zero on the others.
    pub fn scatter(&self, entries: &[f64]) -> [f64; 6] {
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
        assert_eq!(selection.scatter(&[7.0, 8.0]), [8.0, 0.0, 0.0, 0.0, 0.0, 7.0]);
    }

    #[test]
    fn empty_and_repeated_selections_are_refused() {
        assert_eq!(AxisSelection::new(&[]), Err(AxisSelectionError::Empty));
        assert_eq!(AxisSelection::new(&[Axis::Y, Axis::X, Axis::Y]), Err(AxisSelectionError::Repeated(Axis::Y)));
    }
}
