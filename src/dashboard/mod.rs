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
    "arm.js",
    "bars.js",
    "connection.js",
    "controls.js",
    "export.js",
    "figures.js",
    "geometry.js",
    "history.js",
    "main.js",
    "notices.js",
    "plot.js",
    "plots.js",
    "pointer.js",
    "run.js",
    "run_control.js",
    "scene.js",
    "setup.js",
    "shading.js",
    "snippets.js",
    "state.js",
    "svg.js",
    "theme.js",
    "transport.js",
    "watch.js",
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
