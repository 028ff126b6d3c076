//! From text to a graph of links.

use std::collections::{HashMap, HashSet};

use roxmltree::{Document, Node, ParsingOptions};

use super::UrdfError;

/// Bounds of a text. The reader compares every attribute with all others of its element, and every prefix with all
/// namespaces in force, so that the text's length alone would not bound its time. It does not recurse, and without
/// document type definitions it knows no entities but those of XML.
const LARGEST_TEXT: usize = 1 << 20;
const MOST_ATTRIBUTES: usize = 256;
const MOST_NAMESPACES: usize = 64;
const MOST_NODES: u32 = 100_000;

/// Longest name of a link or joint, bytes: names stand in every answer.
const LONGEST_NAME: usize = 256;

/// Reads XML, in time that a bad text cannot stretch.
pub fn parse(text: &str) -> Result<Document<'_>, UrdfError> {
    let quotes = |element: &str| element.bytes().filter(|byte| matches!(byte, b'"' | b'\'')).count();
    let bounded = text.len() <= LARGEST_TEXT
        && text.split('<').all(|element| quotes(element) <= 2 * MOST_ATTRIBUTES)
        && text.matches("xmlns").count() <= MOST_NAMESPACES;
    if !bounded {
        let (text, attributes, namespaces) = (LARGEST_TEXT, MOST_ATTRIBUTES, MOST_NAMESPACES);
        return Err(UrdfError::TooLarge { text, attributes, namespaces });
    }
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    Ok(Document::parse_with_options(text, options)?)
}

/// The outermost element.
pub fn robot<'a>(document: &'a Document) -> Result<Node<'a, 'a>, UrdfError> {
    let root = document.root_element();
    let name = root.tag_name().name();
    if name == "robot" { Ok(root) } else { Err(UrdfError::NotRobot { root: name.to_owned() }) }
}

/// A joint as an edge of the graph.
#[derive(Clone, Copy)]
pub struct Edge<'a> {
    pub name: &'a str,
    pub parent: &'a str,
    pub child: &'a str,
    pub element: Node<'a, 'a>,
}

/// All links, each with the joint that it hangs on, in the order of the text.
pub struct Links<'a> {
    pub names: Vec<&'a str>,
    /// By child link.
    pub joint_above: HashMap<&'a str, Edge<'a>>,
}

impl<'a> Links<'a> {
    /// Reads links and joints.
    pub fn read(robot: Node<'a, 'a>) -> Result<Self, UrdfError> {
        let links = named(robot, "link")?;
        let known: HashMap<&str, Node> = links.iter().copied().collect();
        let mut joint_above: HashMap<&str, Edge> = HashMap::new();
        for (name, element) in named(robot, "joint")? {
            let edge = edge(name, element)?;
            if let Some(link) = [edge.parent, edge.child].into_iter().find(|link| !known.contains_key(link)) {
                return Err(UrdfError::UnknownLink { joint: name.to_owned(), link: link.to_owned() });
            }
            if let Some(first) = joint_above.insert(edge.child, edge) {
                let [link, first, second] = [edge.child, first.name, name].map(str::to_owned);
                return Err(UrdfError::TwoParents { link, first, second });
            }
        }
        Ok(Self { names: links.iter().map(|(name, _)| *name).collect(), joint_above })
    }

    /// Links that hang on nothing.
    pub fn roots(&self) -> Vec<&'a str> {
        self.names.iter().copied().filter(|link| !self.joint_above.contains_key(link)).collect()
    }
}

/// The elements of that kind, each with a name of its own.
fn named<'a>(robot: Node<'a, 'a>, element: &'static str) -> Result<Vec<(&'a str, Node<'a, 'a>)>, UrdfError> {
    let mut seen = HashSet::new();
    let mut found = Vec::new();
    for (i, node) in robot.children().filter(|node| node.has_tag_name(element)).enumerate() {
        let name = node.attribute("name").filter(|name| (1..=LONGEST_NAME).contains(&name.len()));
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

/// The first child of that name.
pub fn child<'a>(node: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|child| child.has_tag_name(tag))
}
