//! `POST /v1/stability`.

use super::{OMITTED, Row, assert_all_refused};
use crate::harness::{Service, example};

const ROWS: [Row; 17] = [
    ("/inertia", "0", 422, "/inertia"),
    ("/inertia", "-15", 422, "/inertia"),
    ("/inertia", "1e-160", 422, "/inertia"),
    ("/inertia", "9.99e-7", 422, "/inertia"),
    ("/inertia", "1e10", 422, "/inertia"),
    ("/inertia", OMITTED, 422, ""),
    ("/damping", "-1", 422, "/damping"),
    ("/damping", "1e10", 422, "/damping"),
    ("/stiffness", "-1", 422, "/stiffness"),
    ("/environment", "1e5", 422, "/environment"),
    ("/environment/stiffness", "-1", 422, "/environment/stiffness"),
    ("/environment/mass", "1", 422, "/environment/mass"),
    ("/period_s", "0", 422, "/period_s"),
    ("/lag_s", "-0.001", 422, "/lag_s"),
    ("/delay_periods", "-1", 422, "/delay_periods"),
    ("/delay_periods", "1.5", 422, "/delay_periods"),
    ("/delay_periods", "65", 422, "/delay_periods"),
];

#[test]
fn wrong_loops_are_refused() {
    assert_all_refused(&Service::start(), "/v1/stability", &example("stability.json"), &ROWS);
}
