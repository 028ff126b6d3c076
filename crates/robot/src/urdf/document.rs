//! Parses the XML text into a graph of links and joints.

use std::collections::{HashMap, HashSet};

use nalgebra::{IsometryMatrix3, Rotation3, Translation3};
use roxmltree::{Document, Node, ParsingOptions};

use super::UrdfError;
use crate::ModelError;

// Bounds that keep the parsing time short. The parser compares every attribute with all others of its element, and
// every prefix with all namespaces in scope, so a bound on the length of the text is not enough. The parser does not
// recurse. Document type definitions are refused, so there are no entities except those of XML.
const MAX_TEXT_BYTES: usize = 1 << 20;
const MAX_ATTRIBUTES: usize = 256;
const MAX_NAMESPACES: usize = 64;
const MAX_NODES: u32 = 100_000;

/// Maximum length of the name of a link or joint, bytes. Every answer repeats the names of the joints.
pub const MAX_NAME_BYTES: usize = 256;

/// Parses XML in bounded time.
pub fn parse(text: &str) -> Result<Document<'_>, UrdfError> {
    let quotes = |element: &str| element.bytes().filter(|byte| matches!(byte, b'"' | b'\'')).count();
    let bounded = text.len() <= MAX_TEXT_BYTES
        && text.split('<').all(|element| quotes(element) <= 2 * MAX_ATTRIBUTES)
        && text.matches("xmlns").count() <= MAX_NAMESPACES;
    if !bounded {
        let (text, attributes, namespaces) = (MAX_TEXT_BYTES, MAX_ATTRIBUTES, MAX_NAMESPACES);
        return Err(UrdfError::TooLarge { text, attributes, namespaces });
    }
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    Ok(Document::parse_with_options(text, options)?)
}

/// Returns the root element, which must be `<robot>`.
pub fn robot<'a>(document: &'a Document) -> Result<Node<'a, 'a>, UrdfError> {
    let root = document.root_element();
    let name = root.tag_name().name();
    let is_xacro = |node: &Node| node.tag_name().namespace().is_some_and(|namespace| namespace.ends_with("xacro"));
    match (name, root.descendants().find(is_xacro)) {
        ("robot", None) => Ok(root),
        ("robot", Some(element)) => Err(UrdfError::Xacro { element: element.tag_name().name().to_owned() }),
        ("mujoco", _) => Err(UrdfError::Mjcf),
        _ => Err(UrdfError::NotRobot { root: name.to_owned() }),
    }
}

/// A joint as an edge of the graph of links.
#[derive(Clone, Copy)]
pub struct Edge<'a> {
    pub name: &'a str,
    pub parent: &'a str,
    pub child: &'a str,
    pub element: Node<'a, 'a>,
}

/// How a joint moves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    Fixed,
    /// As a joint of an arm can.
    Moving,
    /// In another way.
    Unsupported,
}

impl<'a> Edge<'a> {
    pub fn motion(&self) -> Motion {
        match self.element.attribute("type") {
            Some("fixed") => Motion::Fixed,
            Some("revolute" | "continuous" | "prismatic") => Motion::Moving,
            _ => Motion::Unsupported,
        }
    }

    /// Whether the joint follows another one.
    pub fn is_mimic(&self) -> bool {
        child(self.element, "mimic").is_some()
    }

    /// Returns the name of the joint that this one follows.
    fn leader(&self) -> Option<&'a str> {
        child(self.element, "mimic")?.attribute("joint")
    }
}

/// All links in the order of the text, with the joint above each.
pub struct Links<'a> {
    pub names: Vec<&'a str>,
    /// The joint above a link, by the name of that link.
    pub joint_above: HashMap<&'a str, Edge<'a>>,
    /// The joints below a link, by the name of that link.
    joints_below: HashMap<&'a str, Vec<Edge<'a>>>,
    /// The joints that others follow, with the link above the others.
    leaders: HashSet<(&'a str, &'a str)>,
}

impl<'a> Links<'a> {
    /// Reads the links and joints of a robot.
    pub fn read(robot: Node<'a, 'a>) -> Result<Self, UrdfError> {
        let links = named(robot, "link")?;
        let known: HashMap<&str, Node> = links.iter().copied().collect();
        let mut joint_above: HashMap<&str, Edge> = HashMap::new();
        let mut joints_below: HashMap<&str, Vec<Edge>> = HashMap::new();
        for (name, element) in named(robot, "joint")? {
            let edge = edge(name, element)?;
            if let Some(link) = [edge.parent, edge.child].into_iter().find(|link| !known.contains_key(link)) {
                return Err(UrdfError::UnknownLink { joint: name.to_owned(), link: link.to_owned() });
            }
            if let Some(first) = joint_above.insert(edge.child, edge) {
                let [link, first, second] = [edge.child, first.name, name].map(str::to_owned);
                return Err(ModelError::TwoParents { link, first, second }.into());
            }
            joints_below.entry(edge.parent).or_default().push(edge);
        }
        let leaders = joint_above.values().filter_map(|edge| Some((edge.leader()?, edge.parent))).collect();
        Ok(Self { names: links.iter().map(|(name, _)| *name).collect(), joint_above, joints_below, leaders })
    }

    /// Returns the joints below a link, in the order of the text.
    pub fn below(&self, link: &str) -> &[Edge<'a>] {
        self.joints_below.get(link).map_or(&[], Vec::as_slice)
    }

    /// Whether a joint on the same link follows this joint, and no joint moves on the link below it.
    pub fn leads_neighbour(&self, edge: &Edge) -> bool {
        self.leaders.contains(&(edge.name, edge.parent))
            && self.below(edge.child).iter().all(|next| next.motion() == Motion::Fixed)
    }

    /// Returns the links without parent.
    pub fn roots(&self) -> Vec<&'a str> {
        self.names.iter().copied().filter(|link| !self.joint_above.contains_key(link)).collect()
    }
}

/// Returns the elements of one kind with their names, which must be unique.
fn named<'a>(robot: Node<'a, 'a>, element: &'static str) -> Result<Vec<(&'a str, Node<'a, 'a>)>, UrdfError> {
    let mut seen = HashSet::new();
    let mut found = Vec::new();
    for (i, node) in children(robot, element).enumerate() {
        let name = node.attribute("name").filter(|name| (1..=MAX_NAME_BYTES).contains(&name.len()));
        let name = name.ok_or(UrdfError::Unnamed { element, place: i + 1 })?;
        if !seen.insert(name) {
            return Err(UrdfError::Duplicate { element, name: name.to_owned() });
        }
        found.push((name, node));
    }
    Ok(found)
}

fn edge<'a>(name: &'a str, element: Node<'a, 'a>) -> Result<Edge<'a>, UrdfError> {
    let link = |tag: &str, what: &'static str| {
        child(element, tag)
            .and_then(|node| node.attribute("link"))
            .ok_or_else(|| UrdfError::Missing { joint: name.to_owned(), what })
    };
    let parent = link("parent", "<parent link=\"…\"/>")?;
    Ok(Edge { name, parent, child: link("child", "<child link=\"…\"/>")?, element })
}

/// Maximum absolute value of a number, m or rad.
const MAX_NUMBER: f64 = 1e9;

/// Reads the numbers of an attribute; `None` if it has others than `N` of at most 1e9.
pub fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let number = |word: &str| word.parse().ok().filter(|value: &f64| value.abs() <= MAX_NUMBER);
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
    <[f64; N]>::try_from(numbers?).ok()
}

/// Returns a pose from its position and its angles about fixed axes: roll, pitch, yaw.
pub fn pose(position: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> IsometryMatrix3<f64> {
    IsometryMatrix3::from_parts(Translation3::from(position), Rotation3::from_euler_angles(roll, pitch, yaw))
}

/// Returns the first child with this tag.
pub fn child<'a>(node: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    children(node, tag).next()
}

/// Returns the children with this tag. Elements of another namespace, such as those of a simulator, have their own meaning.
fn children<'a>(node: Node<'a, 'a>, tag: &str) -> impl Iterator<Item = Node<'a, 'a>> {
    let is_own = move |child: &Node| child.tag_name().namespace() == node.tag_name().namespace();
    node.children().filter(move |child| child.has_tag_name(tag) && is_own(child))
}
