//! Builds the tree of a robot from its description.

use std::collections::{HashMap, HashSet};

use nalgebra::{IsometryMatrix3, Translation3};

use super::tree::{Tree, has_usable_numbers};
use super::tree_description::{JointMotion, Mimic, TreeDescription, TreeJoint, TreeTip};
use super::{Joint, JointLimits, Link, LinkId, ModelError, MovingJoint, Tip};

/// Checks a description and returns its joints with a coordinate (n) and its tree.
///
/// Joints are in depth-first order: those of a subtree are adjacent, and each is behind the joint that it hangs on.
pub fn assemble(description: &TreeDescription) -> Result<(Vec<Joint>, Tree), ModelError> {
    let order = depth_first(description)?;
    check_names(&order)?;
    let coordinates = coordinates(&order)?;
    let mut assembly = Assembly::new(&description.base);
    for joint in &order {
        assembly.add(joint, &coordinates)?;
    }
    if assembly.joints.is_empty() {
        return Err(ModelError::NoJoints);
    }
    restrict_leaders(&mut assembly.joints, &order, &coordinates)?;
    let tips = assembly.tips(&description.tips)?;
    Ok((assembly.joints, Tree::new(assembly.moving, assembly.links, tips)))
}

/// Returns the joints below the base, each behind the joint above it.
fn depth_first(description: &TreeDescription) -> Result<Vec<&TreeJoint>, ModelError> {
    let mut above: HashMap<&str, &TreeJoint> = HashMap::new();
    let mut below: HashMap<&str, Vec<&TreeJoint>> = HashMap::new();
    for joint in &description.joints {
        if let Some(first) = above.insert(&joint.child, joint) {
            let [link, first, second] = [&joint.child, &first.name, &joint.name].map(Clone::clone);
            return Err(ModelError::TwoParents { link, first, second });
        }
        below.entry(&joint.parent).or_default().push(joint);
    }
    if above.contains_key(description.base.as_str()) {
        return Err(ModelError::Cycle { link: description.base.clone() });
    }
    let mut order = Vec::with_capacity(description.joints.len());
    let mut open = vec![description.base.as_str()];
    while let Some(link) = open.pop() {
        order.extend(above.get(link));
        open.extend(below.get(link).into_iter().flatten().rev().map(|joint| joint.child.as_str()));
    }
    if order.len() == description.joints.len() { Ok(order) } else { Err(unreached(&order, description, &above)) }
}

/// Returns why some joints are not below the base.
fn unreached(order: &[&TreeJoint], description: &TreeDescription, above: &HashMap<&str, &TreeJoint>) -> ModelError {
    let reached: HashSet<&str> = order.iter().map(|joint| joint.child.as_str()).collect();
    let mut joint = description.joints.iter().find(|joint| !reached.contains(joint.child.as_str()));
    let mut seen = HashSet::new();
    let mut top = (String::new(), String::new());
    while let Some(TreeJoint { name, parent, .. }) = joint {
        if !seen.insert(parent) {
            return ModelError::Cycle { link: parent.clone() };
        }
        top = (name.clone(), parent.clone());
        joint = above.get(parent.as_str()).copied();
    }
    ModelError::Unconnected { joint: top.0, link: top.1 }
}

/// Refuses two moving joints of the same name.
fn check_names(order: &[&TreeJoint]) -> Result<(), ModelError> {
    let mut seen = HashSet::new();
    let mut names = order.iter().filter(|joint| joint.motion.is_some()).map(|joint| &joint.name);
    match names.find(|name| !seen.insert(*name)) {
        Some(name) => Err(ModelError::DuplicateJoint { name: name.clone() }),
        None => Ok(()),
    }
}

/// Returns the coordinate that moves each moving joint, by its name.
fn coordinates<'a>(order: &[&'a TreeJoint]) -> Result<HashMap<&'a str, usize>, ModelError> {
    let moving = || order.iter().filter_map(|joint| Some((joint, joint.motion.as_ref()?)));
    let own = moving().filter(|(_, motion)| motion.mimic.is_none()).map(|(joint, _)| joint.name.as_str());
    let own: HashMap<&str, usize> = own.zip(0..).collect();
    let mut all = own.clone();
    for (joint, motion) in moving() {
        if let Some(Mimic { leader, .. }) = &motion.mimic {
            let coordinate = own.get(leader.as_str()).ok_or_else(|| wrong_leader(order, &joint.name, leader))?;
            all.insert(&joint.name, *coordinate);
        }
    }
    Ok(all)
}

/// Returns why a joint cannot follow another one.
fn wrong_leader(order: &[&TreeJoint], joint: &str, leader: &str) -> ModelError {
    let (joint, leader) = (joint.to_owned(), leader.to_owned());
    let mut named = order.iter().filter(|candidate| candidate.name == leader);
    match named.next() {
        None => ModelError::UnknownLeader { joint, leader },
        Some(found) if found.motion.is_none() => ModelError::FixedLeader { joint, leader },
        Some(_) => ModelError::MimicChain { joint, leader },
    }
}

/// Restricts the limits of joints so that the joints that follow them keep their own limits.
fn restrict_leaders(
    joints: &mut [Joint],
    order: &[&TreeJoint],
    coordinates: &HashMap<&str, usize>,
) -> Result<(), ModelError> {
    for joint in order {
        let Some(JointMotion { limits, mimic: Some(mimic), .. }) = &joint.motion else { continue };
        let leader = &mut joints[coordinates[joint.name.as_str()]];
        leader.limits = leader.limits.restricted_by(limits, mimic.multiplier, mimic.offset);
        if !leader.limits.is_valid() {
            return Err(ModelError::MimicRange { joint: joint.name.clone(), leader: mimic.leader.clone() });
        }
    }
    Ok(())
}

/// The parts of a tree that are known so far.
struct Assembly {
    joints: Vec<Joint>,
    moving: Vec<MovingJoint>,
    links: Vec<Link>,
    by_name: HashMap<String, LinkId>,
}

impl Assembly {
    /// Starts with the base.
    fn new(base: &str) -> Self {
        let link = Link { name: base.to_owned(), parent: None, joint: None, placement: IsometryMatrix3::identity() };
        let by_name = [(base.to_owned(), LinkId::BASE)].into();
        Self { joints: Vec::new(), moving: Vec::new(), links: vec![link], by_name }
    }

    /// Adds a joint whose parent link is known, and its child link.
    fn add(&mut self, joint: &TreeJoint, coordinates: &HashMap<&str, usize>) -> Result<(), ModelError> {
        let parent = self.by_name[&joint.parent];
        let above = &self.links[parent.index()];
        let (carrier, placement) = match &joint.motion {
            None => (above.joint, above.placement * joint.origin),
            Some(motion) => {
                let to_axis = joint.rotation_to_axis(motion)?;
                let placement = above.placement * (joint.origin * to_axis);
                let parent = above.joint;
                self.move_along(joint, motion, parent, placement, coordinates[joint.name.as_str()])?;
                let after = IsometryMatrix3::from_parts(Translation3::identity(), to_axis.inverse());
                (Some(self.moving.len() - 1), after)
            }
        };
        if !has_usable_numbers(&placement) {
            return Err(ModelError::NotFinite { joint: joint.name.clone() });
        }
        self.by_name.insert(joint.child.clone(), LinkId(self.links.len()));
        self.links.push(Link { name: joint.child.clone(), parent: Some(parent), joint: carrier, placement });
        Ok(())
    }

    /// Adds the moving part of a joint.
    fn move_along(
        &mut self,
        joint: &TreeJoint,
        motion: &JointMotion,
        parent: Option<usize>,
        placement: IsometryMatrix3<f64>,
        coordinate: usize,
    ) -> Result<(), ModelError> {
        let (multiplier, offset) = motion.mimic.as_ref().map_or((1.0, 0.0), |mimic| (mimic.multiplier, mimic.offset));
        if !(has_usable_numbers(&placement) && multiplier.is_finite() && offset.is_finite()) {
            return Err(ModelError::NotFinite { joint: joint.name.clone() });
        }
        if !motion.limits.is_valid() {
            return Err(ModelError::Limits { joint: joint.name.clone() });
        }
        let (name, kind, is_mimic) = (joint.name.clone(), motion.kind, motion.mimic.is_some());
        if !is_mimic {
            self.joints.push(free_joint(&name, kind, placement, motion.limits));
        }
        self.moving.push(MovingJoint { name, kind, parent, placement, coordinate, is_mimic, multiplier, offset });
        Ok(())
    }

    /// Finds the links of the tips.
    fn tips(&self, described: &[TreeTip]) -> Result<Vec<Tip>, ModelError> {
        let mut tips: Vec<Tip> = Vec::with_capacity(described.len());
        for TreeTip { name, link, offset } in described {
            let tip = || name.clone();
            if tips.iter().any(|earlier| earlier.name == *name) {
                return Err(ModelError::DuplicateTip { tip: tip() });
            }
            let Some(&id) = self.by_name.get(link) else {
                return Err(ModelError::UnknownTip { tip: tip(), link: link.clone() });
            };
            if self.links[id.index()].joint.is_none() {
                return Err(ModelError::FixedTip { tip: tip(), link: link.clone() });
            }
            if !has_usable_numbers(offset) {
                return Err(ModelError::TipNotFinite { tip: tip() });
            }
            tips.push(Tip { name: tip(), link: id, offset: *offset });
        }
        if tips.is_empty() { Err(ModelError::NoTip) } else { Ok(tips) }
    }
}

fn free_joint(name: &str, kind: super::JointKind, placement: IsometryMatrix3<f64>, limits: JointLimits) -> Joint {
    Joint { name: name.to_owned(), kind, placement, limits, published_range: None, denavit_hartenberg: None }
}
