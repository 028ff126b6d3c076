//! Trees of links: poses, Jacobians and twists of all links, and descriptions that are refused.

mod allocations;
mod any_tree;
mod kinematics;
mod refusals;
mod task_body;
