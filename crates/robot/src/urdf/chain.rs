//! The chain of joints from base to tip.

use std::collections::{HashMap, HashSet};

use super::UrdfError;
use super::arms::{Arm, arms, before_gripper, survey};
use super::document::{Edge, Links, Motion};
use crate::{ChainSelection, LeftOut, LeftOutReason, ModelError, TipReason};

/// The joints between two links.
pub struct Chain<'a> {
    pub base: &'a str,
    pub tip: &'a str,
    reason: TipReason,
    /// The joints, base first.
    pub joints: Vec<Edge<'a>>,
}

impl<'a> Chain<'a> {
    /// Finds the chain. A base that is not named must be unique; a tip that is not named is found if there is one arm.
    pub fn find(links: &Links<'a>, base: Option<&str>, tip: Option<&str>) -> Result<Self, UrdfError> {
        let base = find_base(links, base)?;
        let Some(name) = tip else {
            let Arm { tip, reason, .. } = find_arm(links, base)?;
            let joints = path(links, base, tip)?.unwrap_or_default();
            return Ok(Self { base, tip, reason, joints });
        };
        let found = links.names.iter().copied().find(|link| *link == name);
        let joints = found.map(|tip| path(links, base, tip)).transpose()?.flatten();
        let reason = TipReason::Request;
        found.zip(joints).map(|(tip, joints)| Self { base, tip, reason, joints }).ok_or_else(|| {
            let leaves = owned(&leaves(links, base));
            UrdfError::UnknownTip { base: base.to_owned(), tip: name.to_owned(), leaves }
        })
    }

    /// Describes the chain and the moving joints that are no part of it.
    pub fn selection(&self, links: &Links<'a>) -> ChainSelection {
        let inside: HashSet<&str> = self.joints.iter().map(|joint| joint.name).collect();
        let reasons = self.reasons(links);
        let edges = links.names.iter().filter_map(|link| links.joint_above.get(link));
        let outside = edges.filter(|edge| edge.motion() != Motion::Fixed && !inside.contains(edge.name));
        let left_out = outside.map(|edge| LeftOut {
            joint: edge.name.to_owned(),
            reason: reasons.get(edge.child).copied().unwrap_or(LeftOutReason::NotBelowBase),
        });
        ChainSelection {
            base: self.base.to_owned(),
            tip: self.tip.to_owned(),
            reason: self.reason,
            left_out: left_out.take(ChainSelection::MAX_LEFT_OUT).collect(),
        }
    }

    /// Returns why a joint below the base is no part of the chain, by the link below the joint.
    fn reasons(&self, links: &Links<'a>) -> HashMap<&'a str, LeftOutReason> {
        let (mut reasons, mut beyond) = (HashMap::new(), HashSet::new());
        for node in survey(links, self.base) {
            let Some(edge) = node.edge else { continue };
            let mut place = LeftOutReason::OtherBranch;
            if edge.parent == self.tip || beyond.contains(edge.parent) {
                beyond.insert(edge.child);
                place = LeftOutReason::BeyondTip;
            }
            reasons.insert(edge.child, node.left_out.unwrap_or(place));
        }
        reasons
    }
}

/// Returns the only arm below the base.
fn find_arm<'a>(links: &Links<'a>, base: &'a str) -> Result<Arm<'a>, UrdfError> {
    let (nodes, leaves) = (survey(links, base), leaves(links, base));
    if let [leaf] = leaves[..] {
        let only = Arm { tip: leaf, reason: TipReason::OnlyEnd, joints: 0 };
        return Ok(before_gripper(&nodes).unwrap_or(only));
    }
    let base = base.to_owned();
    match &arms(&nodes)[..] {
        [arm] => Ok(*arm),
        [] => Err(UrdfError::Tip { base, leaves: owned(&leaves) }),
        several => Err(UrdfError::Arms { base, tips: several.iter().map(|arm| arm.tip.to_owned()).collect() }),
    }
}

/// Finds the base. If it is not named, it must be the only link without parent.
pub fn find_base<'a>(links: &Links<'a>, base: Option<&str>) -> Result<&'a str, UrdfError> {
    let roots = links.roots();
    if let Some(name) = base {
        let found = links.names.iter().copied().find(|link| *link == name);
        return found.ok_or_else(|| UrdfError::UnknownBase { link: name.to_owned(), roots: owned(&roots) });
    }
    match (&roots[..], links.names.first()) {
        ([root], _) => Ok(root),
        // Every link has a parent.
        ([], Some(link)) => Err(ModelError::Cycle { link: (*link).to_owned() }.into()),
        _ => Err(UrdfError::Base { links: owned(&roots) }),
    }
}

/// Returns the link at the end of each arm below the base; the moving ends of all branches if none is known as an arm.
pub fn end_links(links: &Links, base: &str) -> Vec<String> {
    let nodes = survey(links, base);
    let moves = |link: &&String| nodes.iter().any(|node| node.link == **link && node.is_moved());
    match find_arm(links, base) {
        Ok(arm) => vec![arm.tip.to_owned()],
        Err(error) => error.candidates().iter().filter(moves).cloned().collect(),
    }
}

/// Returns the joints from `upper` down to `lower`; `None` if `upper` is not an ancestor of `lower`.
fn path<'a>(links: &Links<'a>, upper: &str, lower: &'a str) -> Result<Option<Vec<Edge<'a>>>, UrdfError> {
    let (mut link, mut joints) = (lower, Vec::new());
    while link != upper {
        let Some(edge) = links.joint_above.get(link) else { return Ok(None) };
        joints.push(*edge);
        if joints.len() > links.joint_above.len() {
            return Err(ModelError::Cycle { link: link.to_owned() }.into());
        }
        link = edge.parent;
    }
    joints.reverse();
    Ok(Some(joints))
}

/// Returns the links without children below the base, in the order of the text; the base itself if it has no children.
fn leaves<'a>(links: &Links<'a>, base: &'a str) -> Vec<&'a str> {
    let below: HashSet<&str> = survey(links, base).iter().map(|node| node.link).collect();
    let is_leaf = |link: &&str| below.contains(link) && links.below(link).is_empty();
    links.names.iter().copied().filter(is_leaf).collect()
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}
