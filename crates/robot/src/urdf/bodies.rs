//! Reads the bodies that a text gives to links for collisions.

use std::collections::HashMap;

use nalgebra::{IsometryMatrix3, Vector3};
use roxmltree::Node;

use super::UrdfError;
use super::document::{Links, Motion, child, numbers, parse, pose, robot};
use super::joint::origin;
use crate::{LinkId, RobotModel};

/// A body that a link carries.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkBody {
    /// The link of the text.
    pub name: String,
    /// The link of the robot that carries it: its own link, or one that fixed joints connect with it.
    pub link: LinkId,
    /// Its pose in the frame of the link, m.
    pub pose: IsometryMatrix3<f64>,
    /// Its form.
    pub form: BodyForm,
}

/// The form of a body, about the origin of its frame.
#[derive(Debug, Clone, PartialEq)]
pub enum BodyForm {
    /// A box with these edges along its axes, m.
    Box(Vector3<f64>),
    /// A cylinder along z.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Length, m.
        length: f64,
    },
    /// A capsule along z: a cylinder with a half ball at each end.
    Capsule {
        /// Radius, m.
        radius: f64,
        /// Length without the balls, m.
        length: f64,
    },
    /// A sphere with this radius, m.
    Sphere(f64),
    /// Triangles of a file.
    Mesh {
        /// Name of the file, as in the text.
        file: String,
        /// Factors of its coordinates.
        scale: Vector3<f64>,
    },
}

/// The bodies of a robot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LinkBodies {
    /// All bodies that move with a link of the robot.
    pub bodies: Vec<LinkBody>,
    /// Links of the text that have a form, but no body that moves with a link of the robot: they have `<visual>` and no `<collision>`,
    /// or they are no part of the robot, such as the fingers beyond the tip of an arm.
    pub uncovered: Vec<String>,
    /// Links of the text with a body that cannot be read, and the link of the robot with which each moves.
    pub unreadable: Vec<(String, LinkId)>,
}

impl RobotModel {
    /// Returns the link of the robot with which each link of the text moves that this robot was read from: its own link, or one that fixed
    /// joints connect with it. Links that move otherwise are left out.
    pub fn carrying_links(&self, text: &str) -> Result<HashMap<String, LinkId>, UrdfError> {
        let document = parse(text)?;
        let links = Links::read(robot(&document)?)?;
        Ok(carriers(self, &links)?.into_iter().map(|(name, (carrier, _))| (name.to_owned(), carrier)).collect())
    }

    /// Reads the `<collision>` elements of the text that this robot was read from. No file that it names is opened.
    ///
    /// A link that is no part of the robot, but that fixed joints connect with one that is, moves with that one: the pedestal below the
    /// base, the hand beyond the tip.
    pub fn link_bodies(&self, text: &str) -> Result<LinkBodies, UrdfError> {
        self.bodies_of(text, false)
    }

    /// Does the same as [`RobotModel::link_bodies`], but lists what it cannot read.
    pub fn readable_link_bodies(&self, text: &str) -> Result<LinkBodies, UrdfError> {
        self.bodies_of(text, true)
    }

    fn bodies_of(&self, text: &str, lists_unreadable: bool) -> Result<LinkBodies, UrdfError> {
        let document = parse(text)?;
        let element = robot(&document)?;
        let links = Links::read(element)?;
        let carriers = carriers(self, &links)?;
        let mut found = LinkBodies::default();
        for link in element.children().filter(|node| node.has_tag_name("link")) {
            let name = link.attribute("name").unwrap_or_default();
            let collisions: Vec<Node> = link.children().filter(|node| node.has_tag_name("collision")).collect();
            match carriers.get(name) {
                Some((carrier, placement)) if !collisions.is_empty() => {
                    for collision in collisions {
                        let name = name.to_owned();
                        match body(&name, collision) {
                            Ok((pose, form)) => {
                                found.bodies.push(LinkBody { name, link: *carrier, pose: placement * pose, form });
                            }
                            Err(_) if lists_unreadable => found.unreadable.push((name, *carrier)),
                            Err(error) => return Err(error),
                        }
                    }
                }
                _ if !collisions.is_empty() || child(link, "visual").is_some() => found.uncovered.push(name.to_owned()),
                _ => {}
            }
        }
        Ok(found)
    }
}

/// The link of the robot with which each link of the text moves, and the pose of the latter in the frame of the former, m.
type Carriers<'a> = HashMap<&'a str, (LinkId, IsometryMatrix3<f64>)>;

fn carriers<'a>(robot: &RobotModel, links: &Links<'a>) -> Result<Carriers<'a>, UrdfError> {
    let mut carriers = Carriers::new();
    let mut reached: Vec<&str> = links.names.iter().copied().filter(|name| robot.link(name).is_some()).collect();
    for name in &reached {
        if let Some(id) = robot.link(name) {
            carriers.insert(name, (id, IsometryMatrix3::identity()));
        }
    }
    while let Some(name) = reached.pop() {
        let (id, placement) = carriers[name];
        let joints = links.joint_above.get(name).into_iter().chain(links.below(name));
        for joint in joints.filter(|joint| joint.motion() == Motion::Fixed) {
            let placement_in_parent = origin(joint)?;
            let (next, relative) = if joint.child == name {
                (joint.parent, placement_in_parent.inverse())
            } else {
                (joint.child, placement_in_parent)
            };
            if !carriers.contains_key(next) {
                carriers.insert(next, (id, placement * relative));
                reached.push(next);
            }
        }
    }
    Ok(carriers)
}

/// Reads a `<collision>` element: the pose in the frame of its link (m), and the form.
fn body<'a>(link: &str, collision: Node<'a, 'a>) -> Result<(IsometryMatrix3<f64>, BodyForm), UrdfError> {
    let wrong = |what: String| UrdfError::Body { link: link.to_owned(), what };
    let three = |node: Option<Node>, field: &str, default: f64| match node.and_then(|node| node.attribute(field)) {
        Some(text) => numbers(text).ok_or_else(|| wrong(format!("{field}=\"{text:.40}\" is not three numbers"))),
        None => Ok([default; 3]),
    };
    let frame = child(collision, "origin");
    if frame.is_some_and(|frame| frame.has_attribute("quat_xyzw")) {
        return Err(wrong("`quat_xyzw` of <origin> is not supported; state `rpy`".to_owned()));
    }
    let pose = pose(three(frame, "xyz", 0.0)?, three(frame, "rpy", 0.0)?);
    let geometry = child(collision, "geometry").and_then(|node| node.children().find(Node::is_element));
    let geometry = geometry.ok_or_else(|| wrong("<collision> needs <geometry>".to_owned()))?;
    let length = |field: &str| {
        let given = geometry.attribute(field).and_then(numbers).map(|[length]: [f64; 1]| length);
        given.filter(|length| *length > 0.0).ok_or_else(|| wrong(format!("`{field}` must be a positive number")))
    };
    let form = match geometry.tag_name().name() {
        "sphere" => BodyForm::Sphere(length("radius")?),
        "cylinder" => BodyForm::Cylinder { radius: length("radius")?, length: length("length")? },
        "capsule" => BodyForm::Capsule { radius: length("radius")?, length: length("length")? },
        "box" => {
            let size = three(Some(geometry), "size", 0.0)?;
            if size.iter().any(|edge| *edge <= 0.0) {
                return Err(wrong("`size` must be three positive numbers".to_owned()));
            }
            BodyForm::Box(size.into())
        }
        "mesh" => {
            let file = geometry.attribute("filename").ok_or_else(|| wrong("<mesh> needs a `filename`".to_owned()))?;
            BodyForm::Mesh { file: file.to_owned(), scale: three(Some(geometry), "scale", 1.0)?.into() }
        }
        other => return Err(wrong(format!("<{other:.40}> is none of box, capsule, cylinder, sphere and mesh"))),
    };
    Ok((pose, form))
}
