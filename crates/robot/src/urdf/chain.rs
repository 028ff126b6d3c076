//! The way from base to tip.

use std::collections::{HashMap, HashSet};

use super::UrdfError;
use super::document::{Edge, Links};

/// A chain of joints.
pub struct Chain<'a> {
    pub base: &'a str,
    pub tip: &'a str,
    /// Base first.
    pub joints: Vec<Edge<'a>>,
}

impl<'a> Chain<'a> {
    /// Finds the chain; what is not named must be the only possibility.
    pub fn find(links: &Links<'a>, base: Option<&str>, tip: Option<&str>) -> Result<Self, UrdfError> {
        let base = find_base(links, base)?;
        let leaves = leaves(links, base);
        let found = match (tip, &leaves[..]) {
            (Some(name), _) => links.names.iter().copied().find(|link| *link == name),
            (None, [leaf]) => Some(*leaf),
            (None, _) => return Err(UrdfError::Tip { base: base.to_owned(), leaves: owned(&leaves) }),
        };
        let joints = found.map(|tip| way(links, base, tip)).transpose()?.flatten();
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
        // Every link hangs on another.
        ([], Some(link)) => Err(UrdfError::Cycle { link: (*link).to_owned() }),
        _ => Err(UrdfError::Base { links: owned(&roots) }),
    }
}

/// The joints between two links, upper first; `None` if the upper one is not above the lower one.
fn way<'a>(links: &Links<'a>, upper: &str, lower: &'a str) -> Result<Option<Vec<Edge<'a>>>, UrdfError> {
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

/// The links below the base that nothing hangs on, in the order of the text; the base itself if it stands alone.
fn leaves<'a>(links: &Links<'a>, base: &'a str) -> Vec<&'a str> {
    let mut children: HashMap<&str, Vec<&'a str>> = HashMap::new();
    for (child, edge) in &links.joint_above {
        children.entry(edge.parent).or_default().push(child);
    }
    let (mut below, mut waiting) = (HashSet::new(), vec![base]);
    while let Some(link) = waiting.pop() {
        // Only a cycle through the base comes by twice.
        if below.insert(link) {
            waiting.extend(children.get(link).into_iter().flatten());
        }
    }
    let is_leaf = |link: &&str| below.contains(link) && !children.contains_key(link);
    links.names.iter().copied().filter(is_leaf).collect()
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}
