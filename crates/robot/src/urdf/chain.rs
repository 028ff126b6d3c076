//! The chain of joints from base to tip.

use std::collections::{HashMap, HashSet};

use super::UrdfError;
use super::document::{Edge, Links};

/// The joints between two links.
pub struct Chain<'a> {
    pub base: &'a str,
    pub tip: &'a str,
    /// The joints, base first.
    pub joints: Vec<Edge<'a>>,
}

impl<'a> Chain<'a> {
    /// Finds the chain. A base or tip that is not named must be unique.
    pub fn find(links: &Links<'a>, base: Option<&str>, tip: Option<&str>) -> Result<Self, UrdfError> {
        let base = find_base(links, base)?;
        let leaves = leaves(links, base);
        let found = match (tip, &leaves[..]) {
            (Some(name), _) => links.names.iter().copied().find(|link| *link == name),
            (None, [leaf]) => Some(*leaf),
            (None, _) => return Err(UrdfError::Tip { base: base.to_owned(), leaves: owned(&leaves) }),
        };
        let joints = found.map(|tip| path(links, base, tip)).transpose()?.flatten();
        found.zip(joints).map(|(tip, joints)| Self { base, tip, joints }).ok_or_else(|| {
            let (base, tip) = (base.to_owned(), tip.unwrap_or_default().to_owned());
            UrdfError::UnknownTip { base, tip, leaves: owned(&leaves) }
        })
    }
}

fn find_base<'a>(links: &Links<'a>, base: Option<&str>) -> Result<&'a str, UrdfError> {
    let roots = links.roots();
    if let Some(name) = base {
        let found = links.names.iter().copied().find(|link| *link == name);
        return found.ok_or_else(|| UrdfError::UnknownBase { link: name.to_owned(), roots: owned(&roots) });
    }
    match (&roots[..], links.names.first()) {
        ([root], _) => Ok(root),
        // Every link has a parent.
        ([], Some(link)) => Err(UrdfError::Cycle { link: (*link).to_owned() }),
        _ => Err(UrdfError::Base { links: owned(&roots) }),
    }
}

/// Returns the joints from `upper` down to `lower`; `None` if `upper` is not an ancestor of `lower`.
fn path<'a>(links: &Links<'a>, upper: &str, lower: &'a str) -> Result<Option<Vec<Edge<'a>>>, UrdfError> {
    let (mut link, mut joints) = (lower, Vec::new());
    while link != upper {
        let Some(edge) = links.joint_above.get(link) else { return Ok(None) };
        joints.push(*edge);
        if joints.len() > links.joint_above.len() {
            return Err(UrdfError::Cycle { link: link.to_owned() });
        }
        link = edge.parent;
    }
    joints.reverse();
    Ok(Some(joints))
}

/// Returns the links without children below the base, in the order of the text; the base itself if it has no children.
fn leaves<'a>(links: &Links<'a>, base: &'a str) -> Vec<&'a str> {
    let mut children: HashMap<&str, Vec<&'a str>> = HashMap::new();
    for (child, edge) in &links.joint_above {
        children.entry(edge.parent).or_default().push(child);
    }
    let (mut below, mut pending) = (HashSet::new(), vec![base]);
    while let Some(link) = pending.pop() {
        // Only a cycle through the base visits a link twice.
        if below.insert(link) {
            pending.extend(children.get(link).into_iter().flatten());
        }
    }
    let is_leaf = |link: &&str| below.contains(link) && !children.contains_key(link);
    links.names.iter().copied().filter(is_leaf).collect()
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}
