//! Control of redundant robot arms by task priority: measured state in, joint velocities out, once per control period.
//!
//! A redundant arm has more joints than its main task needs, so it can do several Cartesian tasks at once: push with 30
//! N along x, hold the rest. The tasks have an order of priority. In each control period this crate computes the joint
//! velocities and explains them: which task gave way, which limits are active, whether the solution is certified
//! optimal. It has no server and no async runtime. This dependency is enough: the robot models are in [`robot`].
//!
//! | to | see |
//! |---|---|
//! | control an arm period by period | [`controller::Stepper`] |
//! | resolve tasks at one posture | the example below, [`resolution::resolve`] |
//! | choose a law for a task (velocity, pose, force, impedance, hybrid) | [`law`] |
//! | bound the velocity of a task, at its own priority | [`task::Task::between`], [`law::VelocityBounds`] |
//! | choose a method and a solver | [`resolution::Method`], [`resolution::Solver`] |
//! | know how sure an answer is | [`resolution::SolverReport`], [`resolution::Status`] |
//! | choose what a task measures (axes of the tool, joints, constant rows) | [`rows`] |
//! | keep joint limits | [`limits`] |
//! | keep virtual walls and other inequalities | [`constraint`] |
//! | compute the stability margins of one axis in contact | [`controller::ContactLoop`] |
//! | describe an arm (built-in, URDF, Denavit-Hartenberg) | [`robot`] |
//! | understand the method | [what reverse priority is](#what-reverse-priority-is) |
//!
//! # A control period
//!
//! ```text
//! measurement ─→ configuration ─→ law ────────────→ resolution ────────→ command
//! q, q̇, F_e      tool pose, J      ẋ_k of each task  q̇ within limits      q̇ and its explanation
//! ```
//!
//! [`robot::kinematics`] computes the configuration, [`law`] the task velocities, [`resolution`] with [`limits`] the joint
//! velocities. [`controller::Stepper`] runs all of these steps.
//!
//! # Example
//!
//! Two tasks at one posture, inside the position and velocity limits of the robot:
//!
//! ```
//! use revprio_core::controller::Limits;
//! use revprio_core::limits::{JointMotion, LimitKind};
//! use revprio_core::linalg::Vector;
//! use revprio_core::resolution::{Problem, resolve};
//! use revprio_core::robot::built_in;
//! use revprio_core::robot::kinematics::{Axis, AxisSelection, Configuration};
//! use revprio_core::task::{Task, TaskStack};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let sawyer = &built_in()[0];
//! let posture = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2]; // rad
//! let configuration = Configuration::new(sawyer, &posture)?;
//! let task = |name: &str, axes: &[Axis], velocity: Vec<f64>| {
//!     let jacobian = AxisSelection::new(axes)?.rows_of(configuration.jacobian());
//!     Ok::<_, Box<dyn std::error::Error>>(Task::new(name, jacobian, Vector::from_vec(velocity)))
//! };
//! let push = task("push", &[Axis::X], vec![0.05])?; // m/s
//! let hold = task("hold", &[Axis::Y, Axis::Z], vec![0.0, 0.0])?;
//! let tasks = TaskStack::new(vec![push, hold])?; // highest priority first
//! let at_rest = JointMotion { position: &posture, distance_to_rest: &[], last_command: &[0.0; 7], last_acceleration: &[] };
//! let limits = Limits::Robot(LimitKind::PositionVelocity).at(sawyer, at_rest, 0.001).velocity_box;
//! let problem = Problem { limits, ..Problem::new(tasks) };
//! let answer = resolve(&problem, &[])?;
//! assert!((answer.tasks[0].achieved[0] - 0.05).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```
//!
//! Do not use [`resolution::Solver::ClosedForm`] on a real arm. It ignores joint limits. The default solver keeps them: it
//! solves all priority levels within the limits by an active-set method and evaluates the optimality conditions of each
//! answer. `docs/solver.md` in the repository explains it.
//!
//! # What reverse priority is
//!
//! Classical task priority starts with the most important task and lets each further task move in the null space of the
//! tasks above it. *Reverse* priority starts with the least important task: q̇_{l+1} = 0, and stage k = l, …, 1 adds to
//! q̇_{k+1} the correction that reaches task k and disturbs the lower tasks least. The most important task comes last,
//! so no later stage disturbs it. Stage k solves
//!
//! > minimise ‖J_{k+1}^RP (q̇ − q̇_{k+1})‖², then ‖q̇ − q̇_{k+1}‖², subject to J_k q̇ = the reachable part of ẋ_k,
//!
//! which is Eq. (29) of the paper, q̇_k = q̇_{k+1} + T_k (J_k T_k)⁺ (ẋ_k − J_k q̇_{k+1}).
//!
//! What it does not do:
//!
//! - With *two* tasks and exact inverses it gives the same vector as classical task priority and as the lexicographic
//!   least-squares solution, even if rows are dependent. If Σ m_k ≤ n and all rows are independent, all of them equal J⁺ẋ.
//!   It is better than damped least squares over one stack only where damping acts, a limit is active or tasks conflict.
//! - With *three or more* tasks the recursion is strict for the top task only. For J_1 = b + c, J_2 = b, J_3 = c and
//!   ẋ = (1, 0, 0) it leaves the residuals (0, ½, ½); the strict hierarchy leaves (0, 0, 1).
//!   [`resolution::Method::StrictReversePriority`] is strict for any number of tasks.
//! - Without damping it does not bound q̇ near a conflict: the rows a and a + ε b give |q̇| ≈ 1/ε. Two dampings per stage
//!   bound it, one for the singularity of task k itself and one for its conflict with lower tasks. The second one adds no
//!   error to task k.
//!
//! # Notation
//!
//! | symbol | meaning | shape, unit |
//! |---|---|---|
//! | n | joints of the arm | |
//! | q, q̇ | joint position, joint velocity (the command) | n; rad, rad/s |
//! | l, k | number of tasks; task index, **k = 1 is the highest priority** and comes first in every list | |
//! | J_k, ẋ_k | Jacobian and desired velocity of task k | m_k × n; m_k, m/s for linear rows, rad/s for angular rows |
//! | lower, upper | bounds of J_k q̇ of an inequality task | m_k, as ẋ_k |
//! | J_k^RP | [J_k; J_{k+1}; …; J_l] stacked, Eq. (23) | Σ m × n |
//! | T_k | first m_k columns of (J_k^RP)⁺, Eq. (25) | n × m_k |
//! | A⁺ | Moore-Penrose inverse, rank decided at [a relative tolerance](linalg::RANK_TOLERANCE) | |
//! | A^# | Aᵀ(A Aᵀ + λ² I)⁻¹, damped inverse | |
//! | μ_k, λ_k | damping of task k's own singularity; of its conflict with lower tasks | |
//! | ζ̇ | null-space velocity | n, rad/s |
//! | H | [joint-limit index](robot::kinematics::joint_limit_index), 0 with all joints in the middle, ½ with all at a limit | |
//! | X, X_d, ΔX | pose of the tool (or joints of a posture), its target, X − X_d | m, rad |
//! | K | gain of the pose and the posture law | diagonal, 1/s |
//! | F_e | wrench that the tool exerts **on the environment**: pressing on a wall at +x gives F_e,x > 0 | 6; N, N·m |
//! | M_d, B_d, K_d | inertia, damping, stiffness that a law makes the tool feel like | diagonal |
//! | M_e, B_e, K_e | inertia, damping, stiffness of the environment | diagonal |
//! | T | control period | s |
//!
//! Rows are linear x y z, then angular x y z, along the base axes, at the tool point, unless a task names [another
//! frame or point](robot::kinematics::TaskFrame). The orientation error is the rotation vector log(R R_dᵀ), with the
//! sign of X − X_d. Denavit-Hartenberg parameters are the standard ones.
//!
//! # Index from equations to code
//!
//! The paper is Su, Liu, Li, Xue, Liu, Li, Lin, Wu: "Research on Hybrid Force Control of Redundant Manipulator with
//! Reverse Task Priority", *Materials* 2022, 15, 6611.
//!
//! | equations | subject | place |
//! |---|---|---|
//! | (1)-(5) | pseudo-inverse with null-space velocity | [`resolution::Method::Pseudoinverse`] |
//! | (6), (7), (14), (15) | damped least squares | [`resolution::Method::DampedLeastSquares`] |
//! | (8) | joint-limit index and its gradient | [`robot::kinematics::joint_limit_index`], [`robot::kinematics::joint_limit_gradient`] |
//! | (9)-(11) | classical task priority | [`resolution::Method::TaskPriority`] |
//! | (12) | algorithmic singularity | [`resolution::Singularity`] |
//! | (13) | singularity-robust task priority | [`resolution::Method::SingularityRobust`] |
//! | (16), (17) | singular value decomposition | [`linalg`] |
//! | (18), (19) | variable damping factor | [`linalg::Damping`] |
//! | (20)-(32) | reverse priority | [`resolution::Method::ReversePriority`] |
//! | (35), (38)-(42) | force law | [`law::ForceLaw`] |
//! | (36), (37) | environment | `revprio_lab::simulator::Environment` |
//! | (43)-(47) | impedance law | [`law::ImpedanceLaw`] |
//! | (48)-(53) | hybrid law | [`law::HybridLaw`] |
//! | (54), Table 1 | experiments, arm | `fixtures/scenarios`, `fixtures/robots` in the repository |
//!
//! Eqs. (33) and (34) are dynamics with joint torques. On a velocity-controlled arm they belong to its inner loop.
//!
//! # Errata of the paper
//!
//! | place | printed | used |
//! |---|---|---|
//! | (4) | (JᵀJ)⁻¹Jᵀ, singular for n > m | J⁺ |
//! | (7) | projector I − (JᵀJ + λ)⁻¹(JᵀJ + λ), identically zero | I − J^# J, which is I − J⁺J where nothing is damped |
//! | (8) | Σ (θ − θ_mid)/(θ_mid − θ_max), linear and unbounded below | squared, H = 1/(2n) Σ ((q − mid)/(mid − max))² |
//! | (11) | N_2 = N_1 (I − J̄_2⁺ J_2), which moves task 2 | N_1 (I − J̄_2⁺ J̄_2) |
//! | (18), (19) | the factor is squared twice | λ² = (1 − (σ_min/δ)²) λ_max² |
//! | (20), (31) | J̌ J without ⁺ | J̌⁺ J̌ |
//! | (21), (23) | stack ends with J_1, the highest task | ends with J_l, the lowest |
//! | (26) | H_k from (J_k^RP)⁺, which has too many columns | H_k = (J_{k+1}^RP)⁺ − T_k J_k (J_{k+1}^RP)⁺ |
//! | (29) | ẋ without index | ẋ_k |
//! | (36) | K_e X | K_e (X − X_0), X_0 the surface |
//! | (47) | no J_1 J_2⁺ before the secondary velocity | Eq. (32) with each task's own velocity |
//! | (53) | ẋ_{k+1} where ẋ_k belongs, J_{k+1}⁺ẋ_{k+1} where q̇_{k+1} belongs | Eq. (29) with each task's own velocity |
//! | Table 1, row 5 | "_pi/2" | −π/2 |
//! | section 5.1 | M_d and B_d with five entries for six axes | diag(15 15 15 80 80 80), diag(150 150 150 280 280 280) |
//! | section 5.2 | K_d not printed; "case 3" never introduced | K_d as each scenario states it; two cases |
//! | after (30) | "primary task ẋ_2" | ẋ_1 is the primary task |

mod arm_state;
pub mod channel;
pub mod collision;
pub mod constraint;
pub mod controller;
pub mod law;
pub mod limits;
pub mod linalg;
pub mod payload;
pub mod resolution;
pub mod rows;
pub mod streaming;
pub mod surface;
pub mod tolerances;
pub mod wrench;

pub use revprio_problem as problem;
pub use revprio_robot as robot;

/// Tasks in their order of priority.
pub mod task {
    pub use revprio_problem::{Task, TaskError, TaskStack};
}
