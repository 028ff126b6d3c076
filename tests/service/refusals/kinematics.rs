//! `POST /v1/kinematics`.

use super::{NO_POINTER, OMITTED, Row, assert_all_refused};
use crate::harness::{Service, example};

pub const ROWS: &[Row] = &[
    ("/robot", r#""puma""#, 422, "/robot"),
    ("/robot", "null", 422, "/robot"),
    ("/robot", OMITTED, 422, ""),
    ("/joint_position", "[]", 422, "/joint_position"),
    ("/joint_position", "{}", 422, "/joint_position"),
    ("/joint_position", "null", 422, "/joint_position"),
    ("/joint_position", r#"{"j1": 0, "j1": 0}"#, 422, "/joint_position"),
    ("/joint_position", r#"{"j9": 0}"#, 422, "/joint_position/j9"),
    ("/joint_position", OMITTED, 422, ""),
    ("/joint_position/6", "1e999", 400, NO_POINTER),
    ("/joint_position/6", "2e9", 422, "/joint_position/6"),
    ("/joint_position/6", "true", 422, "/joint_position/6"),
    ("/frame", r#""tool""#, 422, "/frame"),
];

#[test]
fn postures_that_do_not_fit_the_arm_are_refused() {
    assert_all_refused(&Service::start(), "/v1/kinematics", &example("kinematics.json"), ROWS);
}
