//! Capsules that contain bodies.

mod capsule;
mod collada;
mod fitted_capsule;
mod mesh_file;
mod primitive;
mod split;
mod stl;

use std::path::PathBuf;

use nalgebra::Vector3;

pub use self::collada::ColladaError;
pub use self::fitted_capsule::{FittedCapsule, Triangle};
pub use self::mesh_file::{MeshDirectory, MeshError};
pub use self::stl::StlError;
use crate::shape::{LinkCapsule, Segment};
use crate::{BodyForm, LinkBody, RobotModel, UrdfError};

/// Largest number of capsules for one mesh. Each one is watched against all others in every period.
const MOST_PER_MESH: usize = 3;

/// The capsules of a robot that were made from its text.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FittedShapes {
    /// Capsules that contain the bodies of the text.
    pub capsules: Vec<LinkCapsule>,
    /// The link of the text that each capsule belongs to. It is not the link that carries it where fixed joints connect both.
    pub names: Vec<String>,
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
    /// that the text names; `None`: they are refused. `stated`: links with other shapes, which are left out.
    pub fn fitted_shapes(
        &self,
        text: &str,
        meshes: Option<&MeshDirectory>,
        stated: &[String],
    ) -> Result<FittedShapes, FitError> {
        let found = self.link_bodies(text)?;
        if found.bodies.is_empty() {
            return Err(FitError::NoBodies);
        }
        let (mut capsules, mut names) = (Vec::new(), Vec::new());
        for body in found.bodies.iter().filter(|body| !stated.contains(&body.name)) {
            for FittedCapsule { core, radius } in self.fitted(body, meshes)? {
                capsules.push(LinkCapsule { link: body.link, core: core.moved(&body.pose), radius });
                names.push(body.name.clone());
            }
        }
        Ok(FittedShapes { capsules, names, uncovered: found.uncovered })
    }

    fn fitted(&self, body: &LinkBody, meshes: Option<&MeshDirectory>) -> Result<Vec<FittedCapsule>, FitError> {
        let link = || self.links()[body.link.index()].name.clone();
        Ok(match &body.form {
            BodyForm::Sphere(radius) => vec![FittedCapsule { core: Segment::point(Vector3::zeros()), radius: *radius }],
            BodyForm::Capsule { radius, length } => {
                let end = Vector3::z() * (0.5 * length);
                vec![FittedCapsule { core: Segment { from: -end, to: end }, radius: *radius }]
            }
            BodyForm::Cylinder { radius, length } => vec![primitive::around_cylinder(*radius, *length)],
            BodyForm::Box(size) => primitive::around_box(size),
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

#[cfg(test)]
mod tests;
