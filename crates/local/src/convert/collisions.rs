//! Shapes and obstacles.

use std::collections::{HashMap, HashSet};

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_api::wire;
use revprio_core::collision::{
    CollisionAvoidance, CollisionReport, MAX_OBSTACLES, Obstacle, ObstacleShape, ObstacleState, PairReport,
};
use revprio_robot::collision::{
    CollisionError, CollisionModel, FitError, FittedShapes, LinkCapsule, MAX_CAPSULES, MeshDirectory, OrientedBox,
    PairReason, Segment, StatedPair,
};
use revprio_robot::{LinkId, RobotModel, Srdf};

use super::checks::{Inside, Refused, Result, check, check_name, each};
use super::numbers::{check_numbers, number};
use super::pose::pose;
use crate::error::ApiError;

/// Smallest and largest rate at which distances shrink, 1/s.
pub const RATE_PER_S: (f64, f64) = (0.01, 1e4);

/// Reads what a controller keeps clear of.
pub fn avoidance(collisions: &wire::Collisions, robot: &RobotModel) -> Result<CollisionAvoidance> {
    let wire::Collisions { min_distance_m, rate_per_s, own_links, obstacles } = collisions;
    check(obstacles.len() <= MAX_OBSTACLES, "/obstacles", format_args!("give at most {MAX_OBSTACLES} obstacles"))?;
    let min_distance_m = number(*min_distance_m, "/min_distance_m")?;
    check((0.0..=1.0).contains(&min_distance_m), "/min_distance_m", "give 0 to 1 m")?;
    let rate_per_s = number(*rate_per_s, "/rate_per_s")?;
    let (least, most) = RATE_PER_S;
    check((least..=most).contains(&rate_per_s), "/rate_per_s", format_args!("give {least} to {most} 1/s"))?;
    let obstacles: Vec<Obstacle> = each("/obstacles", obstacles, |_, found| obstacle(found))?;
    for (i, later) in obstacles.iter().enumerate() {
        let is_new = !obstacles[..i].iter().any(|earlier| earlier.name == later.name);
        let detail = format_args!("two obstacles are named `{}`; give each its own name", later.name);
        check(is_new, &format!("/obstacles/{i}/name"), detail)?;
        let detail = format_args!("`{}` is the name of a link; give another", later.name);
        check(robot.link(&later.name).is_none(), &format!("/obstacles/{i}/name"), detail)?;
    }
    Ok(CollisionAvoidance { min_distance_m, rate_per_s, own: *own_links, obstacles })
}

fn obstacle(obstacle: &wire::RoomObstacle) -> Result<Obstacle> {
    let wire::RoomObstacle { name, sphere, capsule, cuboid, half_space, moves } = obstacle;
    check_name(name, "/name")?;
    let (field, shape) = match (sphere, capsule, cuboid, half_space) {
        (Some(sphere), None, None, None) => ("/sphere", sphere_core(sphere).inside("/sphere").map(capsule_shape)?),
        (None, Some(capsule), None, None) => ("/capsule", capsule_core(capsule).inside("/capsule").map(capsule_shape)?),
        (None, None, Some(cuboid), None) => ("/box", box_shape(cuboid).inside("/box")?),
        (None, None, None, Some(half_space)) => ("/half_space", half_space_shape(half_space).inside("/half_space")?),
        _ => return Err(ApiError::invalid("", "give exactly one of `sphere`, `capsule`, `box` and `half_space`")),
    };
    Obstacle::new(name.as_str(), shape, *moves).at(field)
}

fn capsule_shape((core, radius): (Segment, f64)) -> ObstacleShape {
    ObstacleShape::Capsule { core, radius }
}

fn sphere_core(sphere: &wire::Sphere) -> Result<(Segment, f64)> {
    check_numbers(&sphere.center, "/center")?;
    Ok((Segment::point(sphere.center.into()), number(sphere.radius, "/radius")?))
}

fn capsule_core(capsule: &wire::Capsule) -> Result<(Segment, f64)> {
    check_numbers(&capsule.start, "/start")?;
    check_numbers(&capsule.end, "/end")?;
    Ok((Segment { from: capsule.start.into(), to: capsule.end.into() }, number(capsule.radius, "/radius")?))
}

fn box_shape(cuboid: &wire::Cuboid) -> Result<ObstacleShape> {
    check_numbers(&cuboid.size, "/size")?;
    let pose: IsometryMatrix3<f64> = pose(&cuboid.pose).inside("/pose")?;
    Ok(ObstacleShape::Box(OrientedBox { pose, half: Vector3::from(cuboid.size) * 0.5 }))
}

fn half_space_shape(half_space: &wire::HalfSpace) -> Result<ObstacleShape> {
    check_numbers(&half_space.normal, "/normal")?;
    let offset = number(half_space.offset_m, "/offset_m")?;
    Ok(ObstacleShape::HalfSpace { normal: half_space.normal.into(), offset })
}

/// Reads where obstacles are.
pub fn obstacle_states(states: &[wire::ObstacleState]) -> Result<Vec<ObstacleState>> {
    check(states.len() <= MAX_OBSTACLES, "/obstacles", format_args!("give at most {MAX_OBSTACLES} obstacles"))?;
    each("/obstacles", states, |_, state| {
        check_numbers(&state.position, "/position")?;
        check_numbers(&state.velocity, "/velocity")?;
        let (position, velocity) = (state.position.into(), state.velocity.into());
        Ok(ObstacleState { name: state.name.as_str().into(), position, velocity })
    })
}

/// Returns the same robot with the shapes of a registration. `meshes`: where the files are that its text names; `None`: it was sent.
pub fn with_shapes(
    robot: RobotModel,
    request: &wire::RobotRegistration,
    meshes: Option<&MeshDirectory>,
) -> Result<RobotModel> {
    let disabled = srdf(request)?.disabled;
    if request.shapes.is_none() && request.shape_list.is_none() {
        check(request.collision_pairs.is_none(), "/collision_pairs", "give `shapes` or `shape_list` too")?;
        return Ok(robot);
    }
    let listed = listed_shapes(&robot, request)?;
    let stated = stated_pairs(&robot, request)?;
    let fitted = match request.shapes {
        Some(wire::ShapeSource::Fit) => {
            robot.fitted_shapes(&request.urdf, meshes, &listed.names).map_err(|error| fit_error(&error))?
        }
        None => FittedShapes::default(),
    };
    let listed_count = listed.capsules.len();
    let mut shapes = listed;
    shapes.capsules.extend(fitted.capsules);
    shapes.names.extend(fitted.names);
    shapes.uncovered = uncovered(&robot, request, &shapes);
    let names = shapes.names.clone();
    robot.with_fitted(shapes, &stated, &disabled).map_err(|error| shape_error(&error, &names, listed_count))
}

/// Reads the shapes that a registration lists.
fn listed_shapes(robot: &RobotModel, request: &wire::RobotRegistration) -> Result<FittedShapes> {
    let listed = request.shape_list.as_deref().unwrap_or_default();
    check(listed.len() <= MAX_CAPSULES, "/shape_list", format_args!("give at most {MAX_CAPSULES} shapes"))?;
    let capsules: Vec<LinkCapsule> = each("/shape_list", listed, |_, shape| link_capsule(robot, shape))?;
    let names = covered_links(robot, request, &capsules)?;
    Ok(FittedShapes { capsules, names, uncovered: Vec::new() })
}

/// Returns the link of the text that each listed shape covers.
fn covered_links(
    robot: &RobotModel,
    request: &wire::RobotRegistration,
    capsules: &[LinkCapsule],
) -> Result<Vec<String>> {
    let listed = request.shape_list.as_deref().unwrap_or_default();
    let has_bodies = listed.iter().any(|shape| shape.body.is_some());
    let carriers = has_bodies.then(|| robot.carrying_links(&request.urdf)).transpose();
    let carriers = carriers.map_err(|error| ApiError::invalid("/urdf", error))?.unwrap_or_default();
    each("/shape_list", listed, |k, shape| {
        let Some(body) = &shape.body else { return Ok(shape.link.clone()) };
        let joint = |link: LinkId| robot.links()[link.index()].joint;
        let moves_with_it = carriers.get(body).is_some_and(|carrier| joint(*carrier) == joint(capsules[k].link));
        let detail = format_args!("no fixed joints connect a link `{body}` with `{}`", shape.link);
        check(moves_with_it, "/body", detail)?;
        Ok(body.clone())
    })
}

/// Names the shape that is refused; `names`: the links of all shapes, the listed ones first.
fn shape_error(error: &CollisionError, names: &[String], listed: usize) -> ApiError {
    match *error {
        CollisionError::Capsule { index } if index < listed => ApiError::invalid(format!("/shape_list/{index}"), error),
        CollisionError::Capsule { index } => {
            let link = &names[index];
            let detail =
                format!("the <collision> of link `{link}` is too large, or has no size; are its lengths in m?");
            ApiError::invalid("/urdf", detail)
        }
        CollisionError::TooMany { .. } if listed == 0 => ApiError::invalid("/urdf", error),
        CollisionError::TooMany { .. } => ApiError::invalid("/shape_list", error),
    }
}

/// Returns the links of the text that have a form and that no shape covers; none if the text has no bodies that can be read.
///
/// A shape of a link covers what fixed joints connect with it too, unless it names another body.
fn uncovered(robot: &RobotModel, request: &wire::RobotRegistration, shapes: &FittedShapes) -> Vec<String> {
    let Ok(found) = robot.readable_link_bodies(&request.urdf) else { return Vec::new() };
    let is_named = |name: &String| shapes.names.contains(name);
    let covers_all = |link: LinkId| is_named(&robot.links()[link.index()].name);
    let is_stated = |name: &String| is_named(name) || robot.link(name).is_some_and(covers_all);
    let mut uncovered: Vec<String> = found.uncovered.into_iter().filter(|name| !is_stated(name)).collect();
    let bodies = found.bodies.into_iter().map(|body| (body.name, body.link));
    let bare = bodies.chain(found.unreadable).filter(|(name, link)| !is_named(name) && !covers_all(*link));
    uncovered.extend(bare.map(|(name, _)| name));
    let mut known = HashSet::new();
    uncovered.retain(|name| known.insert(name.clone()));
    uncovered
}

fn fit_error(error: &FitError) -> ApiError {
    let pointer = match error {
        FitError::NoFiles { .. } | FitError::NoBodies => "/shapes",
        FitError::Urdf(_) | FitError::Mesh { .. } => "/urdf",
    };
    ApiError::invalid(pointer, error)
}

/// Reason of pairs that a registration leaves out without saying why.
const STATED: &str = "stated";

/// Reads the pairs that a registration leaves out.
fn stated_pairs(robot: &RobotModel, request: &wire::RobotRegistration) -> Result<Vec<StatedPair>> {
    let leave_out = request.collision_pairs.as_ref().map_or(&[][..], |pairs| &pairs.leave_out);
    if leave_out.is_empty() {
        return Ok(Vec::new());
    }
    let ids: HashMap<&str, LinkId> =
        robot.links().iter().filter_map(|link| Some((link.name.as_str(), robot.link(&link.name)?))).collect();
    let find = |name: &str, at: &str| ids.get(name).copied().map_or_else(|| link(robot, name, at), Ok);
    let mut stated = Vec::new();
    for (i, names) in leave_out.iter().enumerate() {
        let at = |side: usize| format!("/collision_pairs/leave_out/{i}/{side}");
        let links = [find(&names[0], &at(0))?, find(&names[1], &at(1))?];
        stated.push(StatedPair { links, reason: STATED.to_owned() });
    }
    Ok(stated)
}

/// Reads the SRDF text of a registration; empty without one.
pub fn srdf(request: &wire::RobotRegistration) -> Result<Srdf> {
    request.srdf.as_ref().map_or_else(|| Ok(Srdf::default()), |text| Srdf::read(text).at("/srdf"))
}

fn link_capsule(robot: &RobotModel, shape: &wire::LinkShape) -> Result<LinkCapsule> {
    let link = link(robot, &shape.link, "/link")?;
    let (core, radius) = match (&shape.capsule, &shape.sphere) {
        (Some(capsule), None) => capsule_core(capsule).inside("/capsule")?,
        (None, Some(sphere)) => sphere_core(sphere).inside("/sphere")?,
        _ => return Err(ApiError::invalid("", "give either `capsule` or `sphere`")),
    };
    Ok(LinkCapsule { link, core, radius })
}

fn link(robot: &RobotModel, name: &str, pointer: &str) -> Result<LinkId> {
    robot.link(name).ok_or_else(|| {
        let names: Vec<String> = robot.links().iter().map(|link| link.name.clone()).collect();
        let detail = format!("`{}` has no link `{name}`; give one of {}", robot.name(), names.join(", "));
        ApiError::invalid(pointer, detail).with_candidates(&names)
    })
}

/// Returns the shapes of a robot; `None`: it has none.
pub fn shapes_answer(robot: &RobotModel) -> Option<wire::RobotShapes> {
    let model = robot.collision()?;
    let name = |link: LinkId| robot.links()[link.index()].name.clone();
    let shape = |(capsule, body): (&LinkCapsule, &String)| {
        let (Segment { from, to }, radius) = (capsule.core, capsule.radius);
        let (link, is_sphere) = (name(capsule.link), from == to);
        wire::LinkShape {
            body: Some(body.clone()).filter(|body| *body != link),
            link,
            capsule: (!is_sphere).then(|| wire::Capsule { start: from.into(), end: to.into(), radius }),
            sphere: is_sphere.then(|| wire::Sphere { center: from.into(), radius }),
        }
    };
    Some(wire::RobotShapes {
        shape_list: model.capsules().iter().zip(model.names()).map(shape).collect(),
        watched_pairs: model.pairs().len(),
        left_out: left_out_answer(model),
        uncovered_links: model.uncovered().to_vec(),
    })
}

fn left_out_answer(model: &CollisionModel) -> Vec<wire::LeftOutPair> {
    let pairs = model.left_out().iter().map(|pair| wire::LeftOutPair {
        links: pair.links.each_ref().map(ToString::to_string),
        reason: match &pair.reason {
            PairReason::Neighbours => "neighbours".to_owned(),
            PairReason::AlwaysTouch => "always_touch".to_owned(),
            PairReason::Stated(reason) => reason.clone(),
        },
    });
    pairs.collect()
}

/// Returns the report of a period.
pub fn report_answer(report: &CollisionReport) -> wire::CollisionReport {
    let pair = |pair: &PairReport| wire::PairDistance {
        a: pair.link.to_string(),
        b: pair.other.to_string(),
        distance_m: pair.distance_m,
        points: pair.points.map(Into::into),
    };
    let [made, left] = report.rows;
    wire::CollisionReport {
        least_distance_m: Some(report.least_distance_m).filter(|distance| distance.is_finite()),
        pairs: report.pairs.iter().map(pair).collect(),
        rows: wire::CollisionRows { made, left },
        share: report.share,
        stop_in_s: report.stop_s,
        violated: report.is_violated,
    }
}
