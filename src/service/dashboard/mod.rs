//! The page at `/`: the arm, the wall and the hierarchy live.
//!
//! It is a client like any other and holds no secret: files out of the binary, without any network beyond the service.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::LazyLock;

use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};

use super::problem::Problem;
use super::segment::Segment;

/// Nothing but what the service itself serves. Pictures that the page makes of itself are `blob:`.
const ONLY_SELF: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
                         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The folder of the files that the page loads.
const FOLDER: &str = "/dashboard/";

macro_rules! files {
    ($($name:literal),+ $(,)?) => { [$(($name, include_str!(concat!("page/", $name)))),+] };
}

/// All files with their texts.
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

/// A name for the whole page as it is in this build.
static VERSION: LazyLock<String> = LazyLock::new(|| {
    let mut hasher = DefaultHasher::new();
    FILES.hash(&mut hasher);
    format!("\"{:016x}\"", hasher.finish())
});

/// Whether the path is one of the page's own, which a browser opens before it can show a token.
pub fn is_page(path: &str) -> bool {
    path == "/" || path.starts_with(FOLDER)
}

/// `GET /`
pub async fn home(headers: HeaderMap) -> Result<Response, Problem> {
    answer("index.html", &headers)
}

/// `GET /dashboard/{file}`
pub async fn file(Segment(name): Segment, headers: HeaderMap) -> Result<Response, Problem> {
    answer(&name, &headers)
}

fn answer(name: &str, headers: &HeaderMap) -> Result<Response, Problem> {
    let file = FILES.iter().find(|(known, _)| *known == name);
    let (_, text) = file.ok_or_else(|| Problem::not_found("there is no such page; the dashboard is at /"))?;
    let media_type = match name.rsplit('.').next() {
        Some("css") => "text/css; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        _ => "text/html; charset=utf-8",
    };
    let version = HeaderValue::from_str(&VERSION).map_err(|_| Problem::internal())?;
    let known = headers.get(header::IF_NONE_MATCH) == Some(&version);
    let head: [(HeaderName, HeaderValue); 5] = [
        (header::CONTENT_TYPE, HeaderValue::from_static(media_type)),
        (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(ONLY_SELF)),
        (header::REFERRER_POLICY, HeaderValue::from_static("no-referrer")),
        // Asked for anew each time, sent only after an update.
        (header::CACHE_CONTROL, HeaderValue::from_static("no-cache")),
        (header::ETAG, version),
    ];
    Ok(if known { (StatusCode::NOT_MODIFIED, head).into_response() } else { (head, *text).into_response() })
}
