//! The page at `/`: a live view of the arm, the wall and the task hierarchy.
//!
//! The page is an ordinary client of the service. Its files are part of the binary. They contain no secret and load nothing
//! from other servers.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::LazyLock;

/// Path of the files that the page loads.
const FOLDER: &str = "/dashboard/";

macro_rules! files {
    ($($name:literal),+ $(,)?) => { [$(($name, include_str!(concat!("page/", $name)))),+] };
}

/// All files, with their texts.
const FILES: &[(&str, &str)] = &files![
    "index.html",
    "style.css",
    "any_model.js",
    "arm.js",
    "arrows.js",
    "bars.js",
    "browser_service.js",
    "browser_worker.js",
    "canvas_scene.js",
    "clearance.js",
    "collada.js",
    "compare.js",
    "connection.js",
    "contact_signs.js",
    "continuation.js",
    "controls.js",
    "drop.js",
    "editing.js",
    "export.js",
    "fields.js",
    "figure_of_eight.js",
    "figures.js",
    "follow.js",
    "force_plot.js",
    "forms.js",
    "framing.js",
    "geometry.js",
    "ghost_curves.js",
    "ghosts.js",
    "ghosts_form.js",
    "gif.js",
    "gif_recorder.js",
    "gltf.js",
    "goals.js",
    "history.js",
    "invite.js",
    "kinematics.js",
    "labels.js",
    "legends.js",
    "limits_plot.js",
    "link.js",
    "link_poses.js",
    "main.js",
    "matrices.js",
    "matrix.js",
    "measures.js",
    "mesh.js",
    "mesh_parts.js",
    "models.js",
    "models_at_zero.js",
    "notices.js",
    "number.js",
    "numbers.js",
    "obstacle_drag.js",
    "obstacles.js",
    "obstacles_form.js",
    "orbit.js",
    "overlay.js",
    "pace.js",
    "planes.js",
    "planes_form.js",
    "playback.js",
    "playground.js",
    "plot.js",
    "plots.js",
    "pointer.js",
    "pose_plot.js",
    "presets.js",
    "press_form.js",
    "profile.js",
    "reason.js",
    "recorder.js",
    "recording.js",
    "recording_file.js",
    "renderer_choice.js",
    "replay.js",
    "robots_form.js",
    "room.js",
    "room_switch.js",
    "rotation.js",
    "run.js",
    "run_control.js",
    "scene.js",
    "sessions_form.js",
    "setup.js",
    "shading.js",
    "shared_robot.js",
    "shared_state.js",
    "signs.js",
    "singular_value.js",
    "snippets.js",
    "solid_meshes.js",
    "solid_scene.js",
    "solids.js",
    "solver_plot.js",
    "start.js",
    "state.js",
    "surroundings.js",
    "svg.js",
    "swing.js",
    "target.js",
    "tasks_form.js",
    "theme.js",
    "time_axis.js",
    "timeline.js",
    "transport.js",
    "urdf.js",
    "view.js",
    "visuals.js",
    "watch.js",
    "webgl.js",
    "webgl_shaders.js",
    "world.js",
    "zip.js",
];

/// Version of the whole page in this build, as an HTTP entity tag.
pub static VERSION: LazyLock<String> = LazyLock::new(|| {
    let mut hasher = DefaultHasher::new();
    FILES.hash(&mut hasher);
    format!("\"{:016x}\"", hasher.finish())
});

/// Returns whether the path belongs to the page. A browser opens these paths before it can send a token.
pub fn is_page(path: &str) -> bool {
    path == "/" || path.starts_with(FOLDER)
}

/// Returns the media type and the text of a file of the page.
pub fn file(name: &str) -> Option<(&'static str, &'static str)> {
    let (_, text) = FILES.iter().find(|(known, _)| *known == name)?;
    let media_type = match name.rsplit('.').next() {
        Some("css") => "text/css; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        _ => "text/html; charset=utf-8",
    };
    Some((media_type, text))
}
