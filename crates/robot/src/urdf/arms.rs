//! Finds the arms of a tree of links, and the link of the tool frame of each.
//!
//! Joints of grippers, heads, legs, wheels and sensors are left out, by their names and their place. Each remaining branch
//! that moves like an arm ends at a tip: the fixed link behind its last joint whose name is most like a tool frame.

use super::document::{Edge, Links, Motion};
use super::words::{
    is_arm, is_finger, is_gripper_joint, is_head, is_leg_or_wheel, is_only_fingertip, is_sensor, tool_rank,
    turns_gripper, words,
};
use crate::{LeftOutReason, TipReason};

/// A chain that ends like an arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arm<'a> {
    /// The link of the tool frame.
    pub tip: &'a str,
    /// Why this link.
    pub reason: TipReason,
    /// Number of joints between base and tip.
    pub joints: usize,
}

/// Minimum number of joints of an arm before a gripper, or beside other branches.
const MIN_JOINTS: usize = 2;

/// A link below the base.
pub struct Node<'a> {
    pub link: &'a str,
    /// The joint above the link; `None` for the base.
    pub edge: Option<Edge<'a>>,
    parent: usize,
    /// Why the link is no part of an arm.
    pub left_out: Option<LeftOutReason>,
    /// Number of moving joints between the base and the link.
    joints: usize,
    /// The node that the last moving joint above moves.
    moved: usize,
    /// Number of fixed joints since then.
    depth: usize,
    /// Whether the link or one of those above it, up to the last moving joint, has the name of a tool frame.
    is_tool: bool,
}

impl Node<'_> {
    /// Returns whether a joint below the base moves the link.
    pub fn is_moved(&self) -> bool {
        self.joints > 0
    }
}

/// Returns the links from the base down, each after its parent.
pub fn survey<'a>(links: &Links<'a>, base: &'a str) -> Vec<Node<'a>> {
    let start =
        Node { link: base, edge: None, parent: 0, left_out: None, joints: 0, moved: 0, depth: 0, is_tool: false };
    let mut nodes = vec![start];
    let mut next = 0;
    while next < nodes.len() {
        for edge in links.below(nodes[next].link).iter().filter(|edge| edge.child != base) {
            let parent = &nodes[next];
            let left_out = parent.left_out.or_else(|| left_out(links, parent, edge));
            let node = Node { left_out, ..child(parent, next, *edge, nodes.len()) };
            nodes.push(node);
        }
        next += 1;
    }
    nodes
}

fn child<'a>(parent: &Node<'a>, parent_index: usize, edge: Edge<'a>, index: usize) -> Node<'a> {
    let moves = edge.motion() != Motion::Fixed;
    Node {
        link: edge.child,
        edge: Some(edge),
        parent: parent_index,
        left_out: None,
        joints: parent.joints + usize::from(moves),
        moved: if moves { index } else { parent.moved },
        depth: if moves { 0 } else { parent.depth + 1 },
        is_tool: (parent.is_tool && !moves) || tool_rank(&words(edge.child)).is_some(),
    }
}

fn left_out(links: &Links, parent: &Node, edge: &Edge) -> Option<LeftOutReason> {
    let (joint, link) = (words(edge.name), words(edge.child));
    let both: Vec<String> = joint.iter().chain(&link).cloned().collect();
    if is_head(&both) {
        return Some(LeftOutReason::Head);
    }
    if is_leg_or_wheel(&both) {
        return Some(LeftOutReason::LegOrWheel);
    }
    if edge.motion() == Motion::Fixed {
        return None;
    }
    let behind_hand = parent.is_tool && !is_arm(&both) && !turns_gripper(&joint);
    let closes_with_another = links.leads_neighbour(edge);
    if closes(edge) || (parent.joints >= MIN_JOINTS && (behind_hand || closes_with_another)) {
        return Some(LeftOutReason::Gripper);
    }
    if is_sensor(&both) {
        return Some(LeftOutReason::Sensor);
    }
    (edge.motion() == Motion::Unsupported).then_some(LeftOutReason::Unsupported)
}

/// Whether a moving joint closes a gripper, by its name and that of its link.
fn closes(edge: &Edge) -> bool {
    let is_finger = |link: &str| is_finger(&words(link));
    edge.is_mimic() || is_gripper_joint(&words(edge.name)) || is_finger(edge.child) || is_finger(edge.parent)
}

/// Returns the arms below the base: those with more joints first, and equal ones in the order of the text.
pub fn arms<'a>(nodes: &[Node<'a>]) -> Vec<Arm<'a>> {
    let arms = arm_ends(nodes).into_iter().map(|end| arm(nodes, end));
    let mut arms: Vec<Arm> = arms.filter(|arm| arm.joints >= MIN_JOINTS).collect();
    arms.sort_by_key(|arm| std::cmp::Reverse(arm.joints));
    arms
}

/// Returns the arm before the gripper, if the only chain ends in one.
pub fn before_gripper<'a>(nodes: &[Node<'a>]) -> Option<Arm<'a>> {
    let first = nodes.iter().find(|node| node.left_out.is_some())?;
    let is_gripper = first.left_out == Some(LeftOutReason::Gripper) && first.edge.is_some_and(|edge| closes(&edge));
    (is_gripper && first.joints > MIN_JOINTS).then(|| arm(nodes, nodes[first.parent].moved))
}

/// The branch from the last link that several arms share to the end of one.
#[derive(Clone, Copy)]
struct Branch {
    end: usize,
    joints: usize,
    is_arm: bool,
}

/// Returns the nodes that the last joints of arms move.
fn arm_ends(nodes: &[Node]) -> Vec<usize> {
    let mut branches_below = vec![0_usize; nodes.len()];
    for node in moved(nodes).map(|i| &nodes[i]) {
        branches_below[nodes[node.parent].moved] += 1;
    }
    let ends = moved(nodes).filter(|i| branches_below[*i] == 0);
    let branches: Vec<Branch> = ends.map(|end| branch(nodes, &branches_below, end)).collect();
    let some_are_arms = branches.iter().any(|branch| branch.is_arm);
    let arms: Vec<Branch> = branches.into_iter().filter(|branch| branch.is_arm || !some_are_arms).collect();
    let most = arms.iter().map(|branch| branch.joints).max().unwrap_or(0);
    arms.iter().filter(|branch| 2 * branch.joints >= most).map(|branch| branch.end).collect()
}

/// Returns the nodes that a joint of an arm moves.
fn moved<'n>(nodes: &'n [Node]) -> impl Iterator<Item = usize> + 'n {
    (1..nodes.len()).filter(|i| nodes[*i].left_out.is_none() && nodes[*i].moved == *i)
}

fn branch(nodes: &[Node], branches_below: &[usize], end: usize) -> Branch {
    let mut branch = Branch { end, joints: 0, is_arm: has_tool(nodes, end) };
    let mut at = end;
    loop {
        let Some(edge) = nodes[at].edge else { return branch };
        branch.joints += 1;
        branch.is_arm |= is_arm(&words(edge.name)) || is_arm(&words(edge.child));
        at = nodes[nodes[at].parent].moved;
        if branches_below[at] > 1 {
            return branch;
        }
    }
}

/// Returns the nodes that move together with the end and can be a tip.
fn tips<'n, 'a>(nodes: &'n [Node<'a>], end: usize) -> impl Iterator<Item = &'n Node<'a>> {
    let is_frame = |node: &&Node| {
        let words = words(node.link);
        (!is_finger(&words) || is_only_fingertip(&words)) && !is_sensor(&words)
    };
    nodes[end..].iter().filter(move |node| node.moved == end && node.left_out.is_none()).filter(is_frame)
}

fn rank(node: &Node) -> Option<usize> {
    let joint = node.edge.filter(|edge| edge.motion() == Motion::Fixed).and_then(|edge| tool_rank(&words(edge.name)));
    [tool_rank(&words(node.link)), joint].into_iter().flatten().min()
}

fn has_tool(nodes: &[Node], end: usize) -> bool {
    tips(nodes, end).any(|node| rank(node).is_some())
}

fn arm<'a>(nodes: &[Node<'a>], end: usize) -> Arm<'a> {
    let joints = nodes[end].joints;
    // The best name; among equals the frame that is furthest out, and the first of those.
    let named = tips(nodes, end).filter_map(|node| Some((rank(node)?, node)));
    let named = named.min_by_key(|(rank, node)| (*rank, std::cmp::Reverse(node.depth)));
    let found = |node: &Node<'a>, reason| Arm { tip: node.link, reason, joints };
    if let Some((_, node)) = named {
        return found(node, TipReason::ToolName);
    }
    let before_gripper =
        |node: &&Node| node.left_out == Some(LeftOutReason::Gripper) && nodes[node.parent].moved == end;
    if let Some(gripper) = nodes[end..].iter().find(before_gripper) {
        let mut last = gripper.parent;
        while last != end && is_finger(&words(nodes[last].link)) {
            last = nodes[last].parent;
        }
        return found(&nodes[last], TipReason::BeforeGripper);
    }
    let last = tips(nodes, end).min_by_key(|node| std::cmp::Reverse(node.depth));
    found(last.unwrap_or(&nodes[end]), TipReason::LastLink)
}
