//! Capsules that contain bodies.

mod capsule;
mod mesh_file;
mod split;

use std::f64::consts::PI;
use std::path::PathBuf;

use nalgebra::Vector3;

pub use self::mesh_file::{MeshDirectory, MeshError};
use crate::shape::{LinkCapsule, Segment};
use crate::{BodyForm, LinkBody, RobotModel, UrdfError};

/// Largest number of capsules for one mesh. Each one is watched against all others in every period.
const MOST_PER_MESH: usize = 3;

/// Largest number of capsules for one box.
const MOST_PER_BOX: usize = 4;

/// A triangle of a mesh, m.
pub type Triangle = [Vector3<f64>; 3];

/// A capsule that contains a body, in the frame of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedCapsule {
    /// The segment, m.
    pub core: Segment,
    /// Radius, m.
    pub radius: f64,
}

/// The capsules of a robot that were made from its text.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FittedShapes {
    /// Capsules that contain the bodies of the text.
    pub capsules: Vec<LinkCapsule>,
    /// Links of the text that no capsule covers ([`LinkBodies::uncovered`](crate::LinkBodies::uncovered)).
    pub uncovered: Vec<String>,
}

/// Why a robot gets no capsules from its text.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// The text is wrong.
    #[error(transparent)]
    Urdf(#[from] UrdfError),
    /// A mesh cannot be read.
    #[error("link `{link}`: {source}")]
    Mesh {
        /// The link of the robot.
        link: String,
        /// Why.
        source: MeshError,
    },
    /// The text names meshes, and there is no directory to read them from.
    #[error(
        "link `{link}` has the mesh {file}, and a text that is sent has no files; run `revprio robots fit FILE` where the files are, and \
         send its `shape_list`"
    )]
    NoFiles {
        /// The link of the robot.
        link: String,
        /// The mesh, as in the text.
        file: PathBuf,
    },
    /// No link has a body.
    #[error("no link of the robot has a <collision> element; state its shapes in `shape_list`")]
    NoBodies,
}

impl RobotModel {
    /// Returns capsules that contain the `<collision>` elements of the text that this robot was read from. `meshes`: where the files are
    /// that the text names; `None`: they are refused.
    pub fn fitted_shapes(&self, text: &str, meshes: Option<&MeshDirectory>) -> Result<FittedShapes, FitError> {
        let found = self.link_bodies(text)?;
        if found.bodies.is_empty() {
            return Err(FitError::NoBodies);
        }
        let mut capsules = Vec::new();
        for body in &found.bodies {
            for FittedCapsule { core, radius } in self.fitted(body, meshes)? {
                capsules.push(LinkCapsule { link: body.link, core: core.moved(&body.pose), radius });
            }
        }
        Ok(FittedShapes { capsules, uncovered: found.uncovered })
    }

    fn fitted(&self, body: &LinkBody, meshes: Option<&MeshDirectory>) -> Result<Vec<FittedCapsule>, FitError> {
        let link = || self.links()[body.link.index()].name.clone();
        Ok(match &body.form {
            BodyForm::Sphere(radius) => vec![FittedCapsule { core: Segment::point(Vector3::zeros()), radius: *radius }],
            BodyForm::Cylinder { radius, length } => vec![around_cylinder(*radius, *length)],
            BodyForm::Box(size) => around_box(size),
            BodyForm::Mesh { file, scale } => {
                let Some(meshes) = meshes else {
                    return Err(FitError::NoFiles { link: link(), file: file.into() });
                };
                let triangles = meshes.read(file, scale).map_err(|source| FitError::Mesh { link: link(), source })?;
                split::around_triangles(&triangles, MOST_PER_MESH)
            }
        })
    }
}

/// Returns the smallest capsule along the axis of a cylinder that contains it; the axis is z.
///
/// A core that ends δ before the faces needs the radius √(r² + δ²) to contain their rims.
fn around_cylinder(radius: f64, length: f64) -> FittedCapsule {
    const STEPS: u32 = 64;
    let capsule = |step: u32| {
        let shorter = 0.5 * length * f64::from(step) / f64::from(STEPS);
        let end = Vector3::z() * (0.5 * length - shorter);
        FittedCapsule { core: Segment { from: -end, to: end }, radius: radius.hypot(shorter) }
    };
    let volume = |capsule: &FittedCapsule| capsule.volume();
    (1..=STEPS).map(capsule).fold(capsule(0), |best, next| if volume(&next) < volume(&best) { next } else { best })
}

/// Returns capsules along the longest edge of a box that contain it: as many beside each other as its cross-section is wider than high.
fn around_box(size: &Vector3<f64>) -> Vec<FittedCapsule> {
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| size[*b].total_cmp(&size[*a]));
    let [along, across, up] = axes;
    let fitting = (1..=MOST_PER_BOX).find(|count| size[across] <= 1.5 * *count as f64 * size[up]);
    let count = fitting.unwrap_or(MOST_PER_BOX);
    let width = size[across] / count as f64;
    let FittedCapsule { core, radius } = around_cylinder(0.5 * width.hypot(size[up]), size[along]);
    let capsule = |k: usize| {
        let middle = Vector3::ith(across, width * (k as f64 + 0.5) - 0.5 * size[across]);
        let end = Vector3::ith(along, core.to.z);
        FittedCapsule { core: Segment { from: middle - end, to: middle + end }, radius }
    };
    (0..count).map(capsule).collect()
}

impl FittedCapsule {
    /// Returns its volume, m³.
    fn volume(&self) -> f64 {
        let length = (self.core.to - self.core.from).norm();
        PI * self.radius.powi(2) * (length + 4.0 / 3.0 * self.radius)
    }
}

#[cfg(test)]
mod tests;
