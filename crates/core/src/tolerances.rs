//! All numbers of the solver that stand for a judgement: what counts as zero, as dependent, as proved.
//!
//! Each entry says what it measures, relative to what, and why it has this value. `tools/mutants/tolerances` multiplies and
//! divides each one by ten, and lists the tests that then fail.

/// The tolerances of the solver and of its linear algebra. All are dimensionless unless stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    // What an answer needs.
    /// Largest relative optimality residual of an answer with the status `optimal`. Exact answers of task size stay below
    /// 1e-12, a wrong active set is off by orders of magnitude more than this.
    pub certified: f64,
    /// A number below this fraction of the terms whose sum it is counts as zero: bounds that are met, signs of multipliers.
    /// Sums of some hundred terms of double precision err by up to 1e-14.
    pub rounding: f64,

    // Ranks.
    /// Singular values below this fraction of a matrix's Frobenius norm count as zero. Jacobians are known to about 1e-9 of
    /// their size, and rounding reaches 1e-15; the value lies between.
    pub rank: f64,
    /// The same where rounding may decide a rank and no certain answer is found with [`Self::rank`]; tried in this order.
    pub uncertain_rank: [f64; 2],
    /// Rows that depend on each other up to this fraction of ‖A_k‖, but not to rounding, have an uncertain rank, and rows whose
    /// smallest singular value is above it are certainly independent.
    pub certain_rank: f64,
    /// A pivot below this fraction of ‖A_k‖ makes the singular values decide the rank: pivots are larger than the smallest
    /// singular value, but seldom a hundred times.
    pub suspicious_pivot: f64,
    /// Fraction of ‖J‖ from which on all methods that agree in exact arithmetic agree to nearly all digits: their errors grow
    /// with the square of the condition number.
    pub well_conditioned: f64,
    /// Relative rounding of bounds of singular values, which sums of squares over an arm's Jacobian bring.
    pub singular_value_margin: f64,

    // Errors of single operations.
    /// Error of a row of length one after reflections, and after projections off orthonormal directions: some ten roundings.
    pub reflection_error: f64,
    /// A squared length that was kept up to date by subtraction is summed again below this fraction of the last sum.
    pub trusted_square: f64,
    /// Error of the square of a singular value, relative to the square of the damping threshold, at which the search for it ends:
    /// far below what an answer shows, and far above rounding, which would make it go on.
    pub secant: f64,
    /// Cosine of the angle between two rows that counts as rounding in Jacobi's rotations.
    pub orthogonal: f64,

    // Proposals of working sets. The optimality conditions judge each of them.
    /// Ratio of the weights of adjacent levels in the search: small enough to separate levels, and large enough for three of them
    /// in double precision.
    pub search_spacing: f64,
    /// The smallest weight of a level in the search relative to the last objective.
    pub search_least_weight: f64,
    /// Fraction of a diagonal entry below which nothing but rounding is left of it in the search.
    pub search_lost_pivot: f64,
    /// Relative size below which a residual, a gradient or a multiplier is zero in the cascade.
    pub cascade_zero: f64,
    /// A direction that bounds or rows leave free is dependent on them below this fraction of its length.
    pub cascade_dependent: f64,
    /// A pivot of the second derivatives below this fraction of the largest one is rounding: its direction has no curvature.
    pub cascade_flat: f64,
    /// Bounds that are met within this distance of each other, relative to the speeds, are met at once.
    pub cascade_at_once: f64,
    /// Relative sizes that count as rounding, the next one where working sets repeat in the last resort. The first one is
    /// [`Self::rounding`]. Then a smaller one where rows nearly depend on each other, so that multipliers are small, and larger
    /// ones where several sets describe the same corner.
    pub roundings: [f64; 6],

    // Explanations.
    /// A weight of a proof of contradiction below this fraction of the largest one is rounding. So is what a level misses, below
    /// this fraction of its size.
    pub proof_weight: f64,
    /// Residual, relative to the speed of a scaled task, up to which its direction counts as kept.
    pub scaled_direction: f64,
    /// Residual, relative to the requested speed, that is rounding where a scaled task comes to rest.
    pub scaled_rest: f64,
    /// Chains of the damped strict hierarchy with less weight are left out.
    pub chain_weight: f64,
}

/// The values that the solver uses.
pub const TOLERANCES: Tolerances = Tolerances {
    certified: 1e-9,
    rounding: 1e-13,
    rank: 1e-10,
    uncertain_rank: [1e-8, 1e-6],
    certain_rank: 1e-6,
    suspicious_pivot: 1e-4,
    well_conditioned: 1e-3,
    singular_value_margin: 1e-9,
    reflection_error: 4e-15,
    trusted_square: 0.1,
    secant: 1e-13,
    orthogonal: 1e-15,
    search_spacing: 1e-6,
    search_least_weight: 1e-40,
    search_lost_pivot: 1e-13,
    cascade_zero: 1e-12,
    cascade_dependent: 1e-10,
    cascade_flat: 1e-15,
    cascade_at_once: 1e-13,
    roundings: [1e-13, 5e-15, 1e-12, 1e-11, 1e-10, 1e-9],
    proof_weight: 1e-9,
    scaled_direction: 1e-11,
    scaled_rest: 1e-14,
    chain_weight: 1e-9,
};
