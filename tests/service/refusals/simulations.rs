//! `POST /v1/simulations`.

use super::{LEFT_OUT, NO_POINTER, Row, assert_all_refused};
use crate::harness::{Service, example};

pub const ROWS: &[Row] = &[
    ("/scenario", r#""moon""#, 422, "/scenario"),
    ("/scenario", r#""../../etc/passwd""#, 422, "/scenario"),
    ("/scenario", "0", 422, "/scenario"),
    ("/scenario", LEFT_OUT, 422, ""),
    ("/method", r#""fastest""#, 422, "/method"),
    ("/solver", "1", 422, "/solver"),
    ("/seed", "1", 422, "/seed"),
    ("/scenario/name", LEFT_OUT, 422, "/scenario"),
    ("/scenario/duration_s", "0", 422, "/scenario/duration_s"),
    ("/scenario/duration_s", "-1", 422, "/scenario/duration_s"),
    ("/scenario/duration_s", "1e9", 422, "/scenario/duration_s"),
    ("/scenario/duration_s", "101", 422, "/scenario/duration_s"),
    ("/scenario/duration_s", "1e999", 400, NO_POINTER),
    ("/scenario/start_joint_position", "[0]", 422, "/scenario/start_joint_position"),
    ("/scenario/start_joint_position/0", "2e9", 422, "/scenario/start_joint_position/0"),
    ("/scenario/velocity_loop", "[0, 0]", 422, "/scenario/velocity_loop"),
    ("/scenario/velocity_loop/lag_s", "-1", 422, "/scenario/velocity_loop/lag_s"),
    ("/scenario/velocity_loop/lag_s", "1.1e9", 422, "/scenario/velocity_loop/lag_s"),
    ("/scenario/velocity_loop/delay_periods", "10001", 422, "/scenario/velocity_loop/delay_periods"),
    ("/scenario/contacts/0/axis", r#""rx""#, 422, "/scenario/contacts/0/axis"),
    ("/scenario/contacts/0/axis", "0", 422, "/scenario/contacts/0/axis"),
    ("/scenario/contacts/0/kind", r#""floor""#, 422, "/scenario/contacts/0/kind"),
    ("/scenario/contacts/0/offset_m", "-1e300", 422, "/scenario/contacts/0/offset_m"),
    ("/scenario/contacts/0/stiffness", "1e300", 422, "/scenario/contacts/0/stiffness"),
    ("/scenario/contacts/0/damping", "-1", 422, "/scenario/contacts"),
    ("/scenario/contacts/0/mass", "1", 422, "/scenario/contacts/0/mass"),
    ("/scenario/controller/robot", r#""puma""#, 422, "/scenario/controller/robot"),
    ("/scenario/controller/period_s", "0", 422, "/scenario/controller/period_s"),
    ("/scenario/controller/tasks", "[]", 422, "/scenario/controller/tasks"),
];

#[test]
fn runs_that_cannot_be_made_are_refused() {
    assert_all_refused(&Service::start(), "/v1/simulations", &example("simulation_own.json"), ROWS);
}
