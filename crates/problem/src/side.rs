//! The sides of a bound, and sets of active bounds.

use smallvec::SmallVec;

/// Lower or upper bound of a joint or of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The lower bound.
    Lower,
    /// The upper bound.
    Upper,
}

impl Side {
    /// Returns −1 for the lower and 1 for the upper bound.
    #[inline]
    pub fn sign(self) -> f64 {
        match self {
            Self::Lower => -1.0,
            Self::Upper => 1.0,
        }
    }
}

/// The active bounds of one problem in ascending order, with their sides. Indices count the joints from 0, then the hard
/// inequalities, then the rows of the tasks.
pub type ActiveSet = SmallVec<[(usize, Side); 8]>;
