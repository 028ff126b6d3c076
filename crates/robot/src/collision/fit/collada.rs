//! Triangles of COLLADA files, where the scene of the file places them.
//!
//! Lengths are converted to metres by the unit of the file. The axes of the file are those of the link: like other ROS tools, this
//! reader ignores `up_axis`. What could place a triangle elsewhere and is not read here is refused, because a capsule must contain
//! the whole mesh.

use std::collections::HashMap;

use nalgebra::{Matrix4, Point3, Rotation3, Translation3, Unit, Vector3};
use roxmltree::{Document, Node};

use super::fitted_capsule::{MAX_TRIANGLES, Triangle};

/// Largest depth of nodes inside nodes: a node can name itself as its child.
const MAX_DEPTH: usize = 40;

/// Largest number of nodes that are placed: nodes that name others twice, in a row, are exponentially many.
const MAX_NODES: usize = 100_000;

/// Why a COLLADA file cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ColladaError {
    /// The text is no XML.
    #[error("it is no XML: {0}")]
    Xml(#[from] roxmltree::Error),
    /// The root is another element.
    #[error("its root is <{0}> and not <COLLADA>")]
    Root(String),
    /// A reference names nothing.
    #[error("<{element}> refers to `{name}`, which is not in the file")]
    Reference {
        /// The element with the reference.
        element: String,
        /// The reference.
        name: String,
    },
    /// The element is not supported.
    #[error("its element <{0}> is not supported")]
    Unsupported(String),
    /// A list has other entries than numbers, or too few.
    #[error("<{0}> must contain finite numbers, as many as its kind needs")]
    Numbers(String),
    /// An element has another number of triangles, strips, fans or polygons than it states.
    #[error("<{element}> states count=\"{stated}\" and has {found}, perhaps because the file is cut")]
    Count {
        /// The element.
        element: String,
        /// Its attribute `count`.
        stated: usize,
        /// What it has.
        found: usize,
    },
    /// A triangle has a corner that does not exist.
    #[error("a triangle names the corner {index} of {count}")]
    Corner {
        /// The index.
        index: usize,
        /// The number of points.
        count: usize,
    },
    /// The scene is nested too deeply or has too many nodes or triangles.
    #[error(
        "its scene has more than {MAX_DEPTH} nodes inside each other, {MAX_NODES} nodes, or {MAX_TRIANGLES} triangles"
    )]
    TooLarge,
}

/// Reads the triangles, m.
pub fn read(text: &str) -> Result<Vec<Triangle>, ColladaError> {
    let document = Document::parse(text)?;
    let root = document.root_element();
    if !root.has_tag_name_local("COLLADA") {
        return Err(ColladaError::Root(root.tag_name().name().to_owned()));
    }
    let named = root.descendants().filter_map(|node| Some((node.attribute("id")?, node)));
    let mut reader = Reader { ids: named.collect(), nodes: 0, triangles: Vec::new() };
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit")).and_then(|unit| unit.attribute("meter"));
    let metres = match unit.map(str::parse::<f64>) {
        None => 1.0,
        Some(Ok(metres)) if metres.is_finite() && metres > 0.0 => metres,
        Some(_) => return Err(ColladaError::Numbers("unit".to_owned())),
    };
    let is_local = |node: &Node| node.has_tag_name_local("unit") && node.parent_element() != child(root, "asset");
    if root.descendants().filter(is_local).any(|local| local.attribute("meter") != unit) {
        return Err(ColladaError::Unsupported("unit".to_owned()));
    }
    let to_metres = Matrix4::new_scaling(metres);
    let scene = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    let named = scene.map(|instance| reader.target(instance, "url")).transpose()?;
    let mut scenes = root.descendants().filter(|node| node.has_tag_name_local("visual_scene"));
    // Without a name, the only scene counts.
    let only = scenes.next();
    if named.is_none() && scenes.next().is_some() {
        return Err(ColladaError::Unsupported("visual_scene".to_owned()));
    }
    if let Some(scene) = named.or(only) {
        children(scene, "node").try_for_each(|node| reader.node(node, &to_metres, 0))?;
    } else {
        let mut geometries = root.descendants().filter(|node| node.has_tag_name_local("geometry"));
        geometries.try_for_each(|geometry| reader.geometry(geometry, &to_metres))?;
    }
    Ok(reader.triangles)
}

/// Names of elements, whatever their namespace is: files have that of their version.
trait LocalName {
    fn has_tag_name_local(&self, name: &str) -> bool;
}

impl LocalName for Node<'_, '_> {
    fn has_tag_name_local(&self, name: &str) -> bool {
        self.tag_name().name() == name
    }
}

fn children<'a, 'i: 'a>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name_local(name))
}

fn child<'a, 'i: 'a>(node: Node<'a, 'i>, name: &'static str) -> Option<Node<'a, 'i>> {
    children(node, name).next()
}

/// Returns the numbers of an element's text.
fn numbers<T: std::str::FromStr>(node: Node) -> Result<Vec<T>, ColladaError> {
    // A comment divides a text into several nodes.
    let text: String = node.children().filter(Node::is_text).filter_map(|part| part.text()).collect();
    text.split_ascii_whitespace().map(|word| word.parse().map_err(|_| wrong_numbers(node))).collect()
}

fn wrong_numbers(node: Node) -> ColladaError {
    ColladaError::Numbers(node.tag_name().name().to_owned())
}

/// Returns a number of an attribute, or `default`.
fn index(node: Node, attribute: &str, default: usize) -> Result<usize, ColladaError> {
    node.attribute(attribute).map_or(Ok(default), |text| text.trim().parse().map_err(|_| wrong_numbers(node)))
}

struct Reader<'a, 'i> {
    ids: HashMap<&'a str, Node<'a, 'i>>,
    nodes: usize,
    triangles: Vec<Triangle>,
}

impl<'a, 'i: 'a> Reader<'a, 'i> {
    /// Returns the element that an attribute such as `#base` names.
    fn target(&self, node: Node<'a, 'i>, attribute: &str) -> Result<Node<'a, 'i>, ColladaError> {
        let name = node.attribute(attribute).unwrap_or_default();
        let found = name.strip_prefix('#').and_then(|id| self.ids.get(id));
        let element = || node.tag_name().name().to_owned();
        found.copied().ok_or_else(|| ColladaError::Reference { element: element(), name: name.to_owned() })
    }

    /// Reads a node of the scene with those inside it; `before` is the transform of the node that contains it.
    fn node(&mut self, node: Node<'a, 'i>, before: &Matrix4<f64>, depth: usize) -> Result<(), ColladaError> {
        self.nodes += 1;
        if depth > MAX_DEPTH || self.nodes > MAX_NODES {
            return Err(ColladaError::TooLarge);
        }
        let mut placed = *before;
        for part in node.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "instance_geometry" => {
                    let geometry = self.target(part, "url")?;
                    self.geometry(geometry, &placed)?;
                }
                "node" => self.node(part, &placed, depth + 1)?,
                "instance_node" => {
                    let other = self.target(part, "url")?;
                    self.node(other, &placed, depth + 1)?;
                }
                "instance_camera" | "instance_light" | "asset" | "extra" => {}
                // Transforms stand before the rest.
                _ => placed *= transform(part)?,
            }
        }
        Ok(())
    }

    /// Adds the triangles of a geometry.
    fn geometry(&mut self, geometry: Node<'a, 'i>, placed: &Matrix4<f64>) -> Result<(), ColladaError> {
        let Some(mesh) = child(geometry, "mesh") else {
            let kind = geometry.first_element_child().map_or("geometry", |kind| kind.tag_name().name());
            return Err(ColladaError::Unsupported(kind.to_owned()));
        };
        for primitive in mesh.children().filter(Node::is_element) {
            let corners: fn(usize) -> [usize; 3] = match primitive.tag_name().name() {
                "triangles" => |k| [3 * k, 3 * k + 1, 3 * k + 2],
                "tristrips" => |k| [k, k + 1, k + 2],
                "trifans" | "polylist" | "polygons" => |k| [0, k + 1, k + 2],
                _ => continue,
            };
            let points = self.points(primitive)?;
            let loops = loops(primitive)?;
            check_count(primitive, &loops)?;
            for corner_list in loops {
                let is_list = primitive.has_tag_name_local("triangles");
                let count = if is_list { corner_list.len() / 3 } else { corner_list.len().saturating_sub(2) };
                for k in 0..count {
                    self.add(corners(k).map(|at| corner_list[at]), &points, placed)?;
                }
            }
        }
        Ok(())
    }

    fn add(&mut self, corners: [usize; 3], points: &[Point3<f64>], placed: &Matrix4<f64>) -> Result<(), ColladaError> {
        if self.triangles.len() >= MAX_TRIANGLES {
            return Err(ColladaError::TooLarge);
        }
        let corner = |index: usize| -> Result<Vector3<f64>, ColladaError> {
            let point = points.get(index).ok_or(ColladaError::Corner { index, count: points.len() })?;
            Ok(placed.transform_point(point).coords)
        };
        let [a, b, c] = corners.map(corner);
        self.triangles.push([a?, b?, c?]);
        Ok(())
    }

    /// Returns the points that a primitive uses.
    fn points(&self, primitive: Node<'a, 'i>) -> Result<Vec<Point3<f64>>, ColladaError> {
        let missing = || ColladaError::Unsupported(format!("{} without positions", primitive.tag_name().name()));
        let with = |node: Node<'a, 'i>, semantic: &str| {
            children(node, "input").find(|input| input.attribute("semantic") == Some(semantic))
        };
        let vertices = self.target(with(primitive, "VERTEX").ok_or_else(missing)?, "source")?;
        let source = self.target(with(vertices, "POSITION").ok_or_else(missing)?, "source")?;
        let list = child(source, "float_array").ok_or_else(missing)?;
        let accessor = child(source, "technique_common").and_then(|common| child(common, "accessor"));
        let (stride, offset, [x, y, z]) = match accessor {
            Some(accessor) => {
                (index(accessor, "stride", 1)?.max(3), index(accessor, "offset", 0)?, coordinates(accessor)?)
            }
            None => (3, 0, [0, 1, 2]),
        };
        let values: Vec<f64> = numbers(list)?;
        let points = values.get(offset..).unwrap_or_default().chunks(stride);
        let point = |entries: &[f64]| Some(Point3::new(*entries.get(x)?, *entries.get(y)?, *entries.get(z)?));
        Ok(points.map_while(point).collect())
    }
}

/// Returns where X, Y and Z stand in each entry of an accessor: its parameters name the values in their order.
fn coordinates(accessor: Node) -> Result<[usize; 3], ColladaError> {
    let names: Vec<_> = children(accessor, "param").map(|param| param.attribute("name").unwrap_or_default()).collect();
    if names.is_empty() {
        return Ok([0, 1, 2]);
    }
    let place = |name: &str| names.iter().position(|other| other.eq_ignore_ascii_case(name));
    let unsupported = || ColladaError::Unsupported("accessor without X, Y and Z".to_owned());
    match (place("X"), place("Y"), place("Z")) {
        (Some(x), Some(y), Some(z)) => Ok([x, y, z]),
        _ => Err(unsupported()),
    }
}

/// Refuses a primitive whose data are more or fewer than it states.
fn check_count(primitive: Node, loops: &[Vec<usize>]) -> Result<(), ColladaError> {
    let is_list = primitive.has_tag_name_local("triangles");
    let corners: usize = loops.iter().map(Vec::len).sum();
    if is_list && !corners.is_multiple_of(3) {
        return Err(wrong_numbers(primitive));
    }
    let found = if is_list { corners / 3 } else { loops.len() };
    let stated = index(primitive, "count", found)?;
    let element = || primitive.tag_name().name().to_owned();
    if stated == found { Ok(()) } else { Err(ColladaError::Count { element: element(), stated, found }) }
}

/// Returns the transform of an element of a node.
fn transform(part: Node) -> Result<Matrix4<f64>, ColladaError> {
    let values: Vec<f64> = match part.tag_name().name() {
        "matrix" | "translate" | "rotate" | "scale" => numbers(part)?,
        other => return Err(ColladaError::Unsupported(other.to_owned())),
    };
    match (part.tag_name().name(), values.as_slice()) {
        ("matrix", entries) if entries.len() == 16 => Ok(Matrix4::from_row_slice(entries)),
        ("translate", &[x, y, z]) => Ok(Translation3::new(x, y, z).to_homogeneous()),
        ("scale", &[x, y, z]) => Ok(Matrix4::new_nonuniform_scaling(&Vector3::new(x, y, z))),
        ("rotate", &[x, y, z, degrees]) => {
            let axis = Unit::try_new(Vector3::new(x, y, z), 0.0).ok_or_else(|| wrong_numbers(part))?;
            Ok(Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous())
        }
        _ => Err(wrong_numbers(part)),
    }
}

/// Returns the indices of points of each loop: all triangles, or one strip, fan or polygon.
fn loops(primitive: Node) -> Result<Vec<Vec<usize>>, ColladaError> {
    let (mut stride, mut at) = (1, 0);
    for input in children(primitive, "input") {
        let offset = index(input, "offset", 0)?;
        stride = stride.max(offset.saturating_add(1));
        at = if input.attribute("semantic") == Some("VERTEX") { offset } else { at };
    }
    // A polygon with holes keeps its outline in <ph>.
    let lists = primitive.descendants().filter(|node| node.has_tag_name_local("p"));
    let list = |node: Node| -> Result<Vec<usize>, ColladaError> {
        let indices: Vec<usize> = numbers(node)?;
        let is_whole = indices.len().is_multiple_of(stride);
        if is_whole { Ok(indices.into_iter().skip(at).step_by(stride).collect()) } else { Err(wrong_numbers(node)) }
    };
    let lists = lists.map(list).collect::<Result<Vec<_>, _>>()?;
    let Some(sizes) = child(primitive, "vcount").filter(|_| primitive.has_tag_name_local("polylist")) else {
        return Ok(lists);
    };
    let all = lists.concat();
    let mut rest = all.as_slice();
    let polygon = |size: usize| -> Result<Vec<usize>, ColladaError> {
        let (own, after) = rest.split_at_checked(size).ok_or_else(|| wrong_numbers(sizes))?;
        rest = after;
        Ok(own.to_vec())
    };
    let polygons = numbers(sizes)?.into_iter().map(polygon).collect::<Result<_, _>>()?;
    if rest.is_empty() { Ok(polygons) } else { Err(wrong_numbers(sizes)) }
}

#[cfg(test)]
mod tests;
