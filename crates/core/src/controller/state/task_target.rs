//! What a task demands in one period.

use crate::law::ContactReport;
use crate::linalg::Vector;
use crate::streaming::{Ignored, TargetReport};

/// The targets of a task in one period.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TaskTarget {
    /// ẋ_k, m_k, m/s and rad/s; for a task with bounds the allowed velocity nearest to the achieved one.
    pub velocity: Vector,
    /// F_d per row, N and N·m; `None` on rows that follow no force.
    pub force: Vec<Option<f64>>,
    /// The streamed target; `None` if no target was streamed to this task.
    pub streamed: Option<TargetReport>,
    /// Why the first chunk that came for this task is ignored: it goes on with its own target. `None`: none came, or it is followed.
    pub unused: Option<Ignored>,
    /// The contact of each row; empty for other laws than the contact law.
    pub contact: Vec<ContactReport>,
    /// The task whose retreat from a fault by force releases this one: it asks for nothing. `None`: none does.
    pub released_by: Option<usize>,
    /// Whether its request, before it fades, is more than that of a task that has reached its target; only known while requests fade.
    pub is_short: bool,
}
