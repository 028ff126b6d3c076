//! `POST` and `DELETE` on `/v1/robots`.

use serde_json::json;

use super::{NO_POINTER, OMITTED, Row, difference};
use crate::harness::Service;
use crate::robots::{CRANK, registration};

/// Returns a URDF as a JSON string, changed in one place.
macro_rules! urdf {
    ($text:literal) => {
        concat!("\"<robot name='r'><link name='a'/><link name='b'/>", $text, "</robot>\"")
    };
}

const ROWS: [Row; 36] = [
    ("/name", OMITTED, 422, ""),
    ("/name", "7", 422, "/name"),
    ("/name", r#""""#, 422, "/name"),
    ("/name", r#""..""#, 422, "/name"),
    ("/name", r#""a/b""#, 422, "/name"),
    ("/name", r#""two words""#, 422, "/name"),
    ("/name", r#""é""#, 422, "/name"),
    ("/name", r#""a\u0000""#, 422, "/name"),
    ("/name", r#""sawyer_dh""#, 409, "/name"),
    ("/name", r#""panda""#, 409, "/name"),
    ("/file", r#""/etc/passwd""#, 422, "/file"),
    ("/base", "1", 422, "/base"),
    ("/base", r#""""#, 422, "/base"),
    ("/base", r#""nowhere""#, 422, "/base"),
    ("/tip", r#""nowhere""#, 422, "/tip"),
    ("/tip", r#""base""#, 422, "/urdf"),
    ("/urdf", OMITTED, 422, ""),
    ("/urdf", "null", 422, "/urdf"),
    ("/urdf", "{}", 422, "/urdf"),
    ("/urdf", r#""""#, 422, "/urdf"),
    ("/urdf", r#""crank.urdf""#, 422, "/urdf"),
    ("/urdf", r#""<robot>""#, 422, "/urdf"),
    ("/urdf", r#""<sdf/>""#, 422, "/urdf"),
    ("/urdf", r#""<robot/>""#, 422, "/base"),
    ("/urdf", r#""<robot>\u0000</robot>""#, 422, "/urdf"),
    ("/urdf", r#""<!DOCTYPE r [<!ENTITY a 'aa'>]><robot>&a;</robot>""#, 422, "/urdf"),
    ("/urdf", r#""<robot>&#x0;</robot>""#, 422, "/urdf"),
    ("/urdf", urdf!(""), 422, "/base"),
    ("/urdf", urdf!("<joint name='j' type='fixed'><parent link='a'/></joint>"), 422, "/urdf"),
    ("/urdf", urdf!("<joint name='j' type='fixed'><parent link='a'/><child link='c'/></joint>"), 422, "/urdf"),
    ("/urdf", urdf!("<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>"), 422, "/urdf"),
    ("/urdf", urdf!("<joint name='j' type='floating'><parent link='a'/><child link='b'/></joint>"), 422, "/urdf"),
    ("/urdf", urdf!("<joint name='j' type='revolute'><parent link='a'/><child link='b'/></joint>"), 422, "/urdf"),
    (
        "/urdf",
        urdf!("<joint name='j' type='continuous'><axis xyz='0 0 0'/><parent link='a'/><child link='b'/></joint>"),
        422,
        "/urdf",
    ),
    (
        "/urdf",
        urdf!("<joint name='j' type='continuous'><origin xyz='0 0 1e308'/><parent link='a'/><child link='b'/></joint>"),
        422,
        "/urdf",
    ),
    ("/urdf", "1e999", 400, NO_POINTER),
];

#[test]
fn wrong_robots_are_refused() {
    let service = Service::start();
    let body = registration("crank", CRANK);
    let differences: Vec<String> =
        ROWS.iter().filter_map(|row| difference(&service, "/v1/robots", &body, row)).collect();
    assert!(differences.is_empty(), "{}", differences.join("\n"));
    assert_eq!(service.post("/v1/robots", &body.to_string()).status, 201);
    service.post("/v1/robots", &body.to_string()).assert_refused(409, Some("/name"));
}

#[test]
fn the_error_for_a_branching_tree_lists_its_leaves() {
    let joint = |name: &str, child: &str| {
        format!("<joint name='{name}' type='continuous'><parent link='a'/><child link='{child}'/></joint>")
    };
    let text = format!(
        "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>{}{}</robot>",
        joint("j", "b"),
        joint("k", "c")
    );
    let answer = Service::start().post("/v1/robots", &registration("tree", &text).to_string());
    answer.assert_refused(422, Some("/tip"));
    assert!(answer.text.contains("`b`, `c`"), "{}", answer.text);
}

#[test]
fn built_in_robots_cannot_be_deleted() {
    let service = Service::start();
    for name in ["sawyer_dh", "sawyer", "ur5e", "panda", "planar_3r", "so101", "fr3", "xarm7", "iiwa14", "gen3"] {
        service.delete(&format!("/v1/robots/{name}")).assert_refused(403, None);
        service.get(&format!("/v1/robots/{name}")).accepted();
    }
    service.delete("/v1/robots/puma").assert_refused(404, None);
}

#[test]
fn robots_above_the_maximum_are_refused() {
    let service = Service::start();
    for i in 0..64 {
        service.post("/v1/robots", &registration(&format!("crank{i}"), CRANK).to_string()).accepted();
    }
    let more = registration("crank", CRANK).to_string();
    service.post("/v1/robots", &more).assert_refused(503, None);
    assert_eq!(service.delete("/v1/robots/crank7").status, 204);
    service.post("/v1/robots", &more).accepted();
}

#[test]
fn a_chain_of_129_joints_and_a_text_of_a_megabyte_are_too_much() {
    let service = Service::start();
    let snake = |joints: usize| {
        let links = (0..=joints).map(|i| format!("<link name='{i}'/>")).collect::<Vec<_>>().concat();
        let joint = |i: usize| {
            format!("<joint name='{i}' type='continuous'><parent link='{i}'/><child link='{}'/></joint>", i + 1)
        };
        let text = format!("<robot name='r'>{links}{}</robot>", (0..joints).map(joint).collect::<Vec<_>>().concat());
        registration(&format!("snake{joints}"), &text).to_string()
    };
    service.post("/v1/robots", &snake(128)).accepted();
    service.post("/v1/robots", &snake(129)).assert_refused(422, Some("/urdf"));
    let large = json!({"name": "large", "urdf": "<a>".repeat(1_500_000)}).to_string();
    service.post("/v1/robots", &large).assert_refused(413, None);
    let deep = json!({"name": "deep", "urdf": "<a>".repeat(400_000)}).to_string();
    service.post("/v1/robots", &deep).assert_refused(422, Some("/urdf"));
    service.assert_alive();
}
