//! How often each way to a working set was needed: a count, so that none is kept that nothing needs.

use std::ops::{Add, Index, IndexMut};

/// A way to a working set, in the order in which they are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rung {
    /// The set of the call before, or the empty one.
    Start,
    /// The same, with everything corrected that was wrong.
    StartCorrected,
    /// The proposal of the search with weights.
    Search,
    /// The proposal of the cascade.
    Cascade,
    /// One change at a time.
    LastResort,
    /// All of them once more, from the empty set, because a guess met an uncertain rank.
    WithoutGuess,
    /// All of them once more, from the empty set, with another tolerance for ranks.
    LargerRankTolerance,
}

impl Rung {
    /// All of them, in order.
    pub const ALL: [Self; 7] = [
        Self::Start,
        Self::StartCorrected,
        Self::Search,
        Self::Cascade,
        Self::LastResort,
        Self::WithoutGuess,
        Self::LargerRankTolerance,
    ];
}

/// Counts of one way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RungCount {
    /// Working sets that it proposed.
    pub tried: u64,
    /// Problems whose optimality conditions held on one of them.
    pub answered: u64,
}

/// Counts of all ways, over all problems of a solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Rungs([RungCount; 7]);

impl Index<Rung> for Rungs {
    type Output = RungCount;

    fn index(&self, rung: Rung) -> &RungCount {
        &self.0[rung as usize]
    }
}

impl IndexMut<Rung> for Rungs {
    fn index_mut(&mut self, rung: Rung) -> &mut RungCount {
        &mut self.0[rung as usize]
    }
}

impl Add for Rungs {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        for (own, other) in self.0.iter_mut().zip(other.0) {
            own.tried += other.tried;
            own.answered += other.answered;
        }
        self
    }
}
