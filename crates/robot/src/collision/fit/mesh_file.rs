//! Triangles of the files that a URDF text names.

use std::path::{Path, PathBuf};

use mesh_loader::Loader;
use nalgebra::Vector3;

use super::collada::{self, ColladaError};
use super::fitted_capsule::{MAX_TRIANGLES, Triangle};
use super::stl::{self, StlError};

/// Where the files are that a URDF text names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeshDirectory {
    directory: PathBuf,
    packages: Vec<PathBuf>,
}

/// Why a mesh cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// There is no such file.
    #[error(
        "the mesh {name} is not found; `package://NAME/…` is looked for in directories NAME beside the URDF file and above it, and in \
         ROS_PACKAGE_PATH and AMENT_PREFIX_PATH"
    )]
    NotFound {
        /// The name in the text.
        name: String,
    },
    /// The file is no mesh.
    #[error("cannot read the mesh {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: std::io::Error,
    },
    /// The file is no STL file that this crate reads, or it is cut.
    #[error("cannot read the mesh {path}: {source}")]
    Stl {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: StlError,
    },
    /// The file is no COLLADA file that this crate reads.
    #[error("cannot read the mesh {path}: {source}; convert it to STL, or state capsules for its link in `shape_list`")]
    Collada {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: ColladaError,
    },
    /// The file has another format.
    #[error(
        "the mesh {path} is neither .stl, .obj nor .dae; convert it, or state capsules for its link in `shape_list`"
    )]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// The mesh has no triangle, too many, or a corner that is not finite.
    #[error("the mesh {path} must have 1 to {MAX_TRIANGLES} triangles with finite corners")]
    Triangles {
        /// The file.
        path: PathBuf,
    },
}

impl MeshDirectory {
    /// Returns where the files of a URDF file are: beside it, and in the packages that the environment names.
    pub fn of_urdf(file: &Path) -> Self {
        let directory = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        let directory = directory.parent().unwrap_or(Path::new("/")).to_owned();
        let listed = |name: &str| std::env::var_os(name).map(|value| std::env::split_paths(&value).collect::<Vec<_>>());
        let mut packages: Vec<PathBuf> = directory.ancestors().map(Path::to_owned).collect();
        packages.extend(listed("ROS_PACKAGE_PATH").unwrap_or_default());
        packages.extend(listed("AMENT_PREFIX_PATH").unwrap_or_default().iter().map(|prefix| prefix.join("share")));
        Self { directory, packages }
    }

    /// Reads the triangles of a file, m, with coordinates multiplied by `scale`.
    pub fn read(&self, name: &str, scale: &Vector3<f64>) -> Result<Vec<Triangle>, MeshError> {
        let path = self.find(name).ok_or_else(|| MeshError::NotFound { name: name.to_owned() })?;
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
        let mut triangles = match ending.as_str() {
            "stl" => read_stl(&path)?,
            "obj" => read_obj(&path).map_err(|source| MeshError::Read { path: path.clone(), source })?,
            "dae" => read_collada(&path)?,
            _ => return Err(MeshError::Format { path }),
        };
        for corner in triangles.iter_mut().flatten() {
            corner.component_mul_assign(scale);
        }
        let is_finite = triangles.iter().flatten().all(|point| point.iter().all(|entry| entry.is_finite()));
        let is_sound = is_finite && (1..=MAX_TRIANGLES).contains(&triangles.len());
        if is_sound { Ok(triangles) } else { Err(MeshError::Triangles { path }) }
    }

    /// Returns the file that a name means.
    fn find(&self, name: &str) -> Option<PathBuf> {
        let Some(in_package) = name.strip_prefix("package://").or_else(|| name.strip_prefix("model://")) else {
            let path = self.directory.join(name.strip_prefix("file://").unwrap_or(name));
            return path.is_file().then_some(path);
        };
        let (package, rest) = in_package.split_once('/')?;
        let inside = self.packages.iter().map(|directory| directory.join(package).join(rest));
        // The URDF file may lie inside the package.
        let own = self.packages.iter().filter(|directory| directory.ends_with(package)).map(|own| own.join(rest));
        inside.chain(own).find(|path| path.is_file())
    }
}

fn read_stl(path: &Path) -> Result<Vec<Triangle>, MeshError> {
    let bytes = std::fs::read(path).map_err(|source| MeshError::Read { path: path.to_owned(), source })?;
    stl::read(&bytes).map_err(|source| MeshError::Stl { path: path.to_owned(), source })
}

/// Keywords of curves and surfaces in OBJ files.
const FREE_FORMS: [&[u8]; 3] = [b"curv", b"curv2", b"surf"];

fn read_obj(path: &Path) -> std::io::Result<Vec<Triangle>> {
    let text = std::fs::read(path)?;
    // The loader leaves out lines that begin with a space, and free forms.
    let lines: Vec<_> = text.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii_start).collect();
    let has_free_form =
        |line: &&[u8]| line.split(u8::is_ascii_whitespace).next().is_some_and(|word| FREE_FORMS.contains(&word));
    if lines.iter().any(has_free_form) {
        return Err(std::io::Error::new(
            std::io::ErrorKind::InvalidData,
            "export free-form curves and surfaces as faces",
        ));
    }
    let bytes = lines.join(&b'\n');
    // No other file is opened: a material says nothing about the form.
    let no_material = |_: &Path| Err::<Vec<u8>, _>(std::io::ErrorKind::NotFound.into());
    let scene = Loader::default().load_obj_from_slice_with_reader(&bytes, path, no_material)?;
    let mut triangles = Vec::new();
    for mesh in &scene.meshes {
        for face in &mesh.faces {
            let corners = face.map(|index| usize::try_from(index).ok().and_then(|k| mesh.vertices.get(k)));
            if let [Some(a), Some(b), Some(c)] = corners {
                triangles.push([*a, *b, *c].map(|point| Vector3::from(point.map(f64::from))));
            }
        }
    }
    Ok(triangles)
}

fn read_collada(path: &Path) -> Result<Vec<Triangle>, MeshError> {
    let text = std::fs::read_to_string(path).map_err(|source| MeshError::Read { path: path.to_owned(), source })?;
    collada::read(&text).map_err(|source| MeshError::Collada { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A material says nothing about the form, whatever its file has.
    #[test]
    fn an_obj_file_is_read_without_its_materials() {
        let directory = std::env::temp_dir().join(format!("revprio-obj-{}", std::process::id()));
        std::fs::create_dir_all(&directory).unwrap();
        let path = directory.join("part.obj");
        std::fs::write(directory.join("odd.mtl"), "newmtl glass\nd -halo 0.66\n").unwrap();
        std::fs::write(&path, "mtllib odd.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass\nf 1 2 3\n").unwrap();
        let triangles = read_obj(&path).unwrap();
        assert_eq!(triangles, [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vector3::from)]);
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
