//! `POST /v1/simulations`.

use serde_json::json;

use super::{NO_POINTER, OMITTED, Row, assert_all_refused};
use crate::harness::{Service, example};

pub const ROWS: &[Row] = &[
    ("/scenario", r#""moon""#, 422, "/scenario"),
    ("/scenario", r#""../../etc/passwd""#, 422, "/scenario"),
    ("/scenario", "0", 422, "/scenario"),
    ("/scenario", OMITTED, 422, ""),
    ("/method", r#""fastest""#, 422, "/method"),
    ("/solver", "1", 422, "/solver"),
    ("/seed", "1", 422, "/seed"),
    ("/interactive", "true", 422, "/interactive"),
    ("/interactive", "[1, false]", 422, "/interactive"),
    ("/interactive", r#"{"speed": 0}"#, 422, "/interactive/speed"),
    ("/interactive", r#"{"speed": 1e308}"#, 422, "/interactive/speed"),
    ("/interactive", r#"{"speed": "fast"}"#, 422, "/interactive/speed"),
    ("/interactive", r#"{"pause": true}"#, 422, "/interactive/pause"),
    ("/scenario/name", OMITTED, 422, "/scenario"),
    ("/scenario/name", r#""../../evil""#, 422, "/scenario/name"),
    ("/scenario/name", r#""""#, 422, "/scenario/name"),
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
    ("/scenario/contacts/0/damping", "-1", 422, "/scenario/contacts/0/damping"),
    ("/scenario/contacts/0/normal", "[1, 0, 0]", 422, "/scenario/contacts/0/normal"),
    ("/scenario/contacts/0/kind", r#""plane""#, 422, "/scenario/contacts/0/axis"),
    ("/scenario/contacts/0/axis", OMITTED, 422, "/scenario/contacts/0/axis"),
    ("/scenario/contacts/0/radius_m", "0.1", 422, "/scenario/contacts/0/radius_m"),
    ("/scenario/contacts/0/hinge", r#"{"friction": 1}"#, 422, "/scenario/contacts/0/hinge"),
    (
        "/scenario/contacts/0/hole",
        r#"{"center": [0, 0, 0], "clearance_m": 1e-3, "depth_m": 0.02}"#,
        422,
        "/scenario/contacts/0/hole",
    ),
    (
        "/scenario/target_programs",
        r#"[{"kind": "spiral_search", "task": "none", "pitch_m": 1e-3, "speed": 0.01, "inserted_m": 3e-3}]"#,
        422,
        "/scenario/target_programs/0/task",
    ),
    ("/scenario/contacts/0/friction", r#"{"coulomb": -1}"#, 422, "/scenario/contacts/0/friction/coulomb"),
    (
        "/scenario/contacts/0/friction",
        r#"{"sticking_speed_m_s": 0}"#,
        422,
        "/scenario/contacts/0/friction/sticking_speed_m_s",
    ),
    ("/scenario/contacts/0/motion", r#"{"kind": "steps", "points": []}"#, 422, "/scenario/contacts/0/motion/points"),
    (
        "/scenario/contacts/0/motion",
        r#"{"kind": "constant", "value": [1, 2]}"#,
        422,
        "/scenario/contacts/0/motion/value",
    ),
    ("/scenario/external_wrench", r#"{"kind": "constant", "value": [1, 2]}"#, 422, "/scenario/external_wrench/value"),
    ("/scenario/sensors", r#"{"force": {"noise": -1}}"#, 422, "/scenario/sensors/force/noise"),
    ("/scenario/sensors", r#"{"force": {"bias": [1]}}"#, 422, "/scenario/sensors/force/bias"),
    ("/scenario/sensors", r#"{"wrench_filter_s": -1}"#, 422, "/scenario/sensors/wrench_filter_s"),
    ("/scenario/faults", r#"{"dropped": 0.6, "reordered": 0.6}"#, 422, "/scenario/faults"),
    ("/scenario/faults", r#"{"late": 0.1}"#, 422, "/scenario/faults/late_periods"),
    (
        "/scenario/faults",
        r#"{"outages": [{"start_s": 0, "duration_s": 1}]}"#,
        422,
        "/scenario/faults/outages/0/start_s",
    ),
    ("/scenario/seed", "-1", 422, "/scenario/seed"),
    ("/scenario/seed", "1e300", 422, "/scenario/seed"),
    ("/scenario/substeps", "0", 422, "/scenario/substeps"),
    ("/scenario/contacts/0/mass", "1", 422, "/scenario/contacts/0/mass"),
    ("/scenario/controller/robot", r#""puma""#, 422, "/scenario/controller/robot"),
    ("/scenario/controller/period_s", "0", 422, "/scenario/controller/period_s"),
    ("/scenario/controller/tasks", "[]", 422, "/scenario/controller/tasks"),
];

const COMMANDS: &[Row] = &[
    ("/paused", "1", 422, "/paused"),
    ("/speed", "-1", 422, "/speed"),
    ("/speed", "1001", 422, "/speed"),
    ("/speed", "1e999", 400, NO_POINTER),
    ("/step", "0", 422, "/step"),
    ("/step", "-1", 422, "/step"),
    ("/step", "1.5", 422, "/step"),
    ("/step", "100001", 422, "/step"),
    ("/external_force", "[0, 0]", 422, "/external_force"),
    ("/external_force", "[0, 0, 2e9]", 422, "/external_force/2"),
    ("/external_force", r#"{"x": 1}"#, 422, "/external_force"),
    ("/method", r#""magic""#, 422, "/method"),
    ("/solver", "null_", 400, NO_POINTER),
    ("/controller", "[]", 422, "/controller"),
    ("/controller", "{}", 422, "/controller"),
    ("/targets", "[]", 422, "/targets"),
    ("/targets", r#"{"pull": {"force": [1]}}"#, 422, "/targets/pull"),
    ("/targets", r#"{"hold": {"velocity": [1]}}"#, 422, "/targets/hold/velocity"),
    ("/targets", r#"{"hold": {"time_s": 1, "force": [1]}}"#, 422, "/targets/hold/time_s"),
    ("/push", "[0, 0, 1]", 422, "/push"),
];

/// Changes that a run does not allow, because the command would jump.
const CONTROLLERS: &[Row] = &[
    ("/controller/robot", r#""ur5e""#, 422, "/controller/robot"),
    ("/controller/robot", r#""sawyer""#, 422, "/controller/robot"),
    ("/controller/period_s", "0.002", 422, "/controller/period_s"),
    ("/controller/limits", r#""none""#, 422, "/controller/limits"),
    ("/controller/damping", "null", 422, "/controller/damping"),
    ("/controller/tasks/0/name", r#""pull""#, 422, "/controller/tasks/0/name"),
    ("/controller/tasks/0/axes", r#"["y"]"#, 422, "/controller/tasks/0/axes/0"),
    ("/controller/tasks/0/law/kind", r#""magic""#, 422, "/controller/tasks/0/law/kind"),
    ("/controller/tasks/0/law/inertia", "[0]", 422, "/controller/tasks/0/law/inertia/0"),
    (
        "/controller/tasks/1",
        r#"{"name": "a", "axes": ["y"], "law": {"kind": "pose", "gain": 1}}"#,
        422,
        "/controller/tasks/1/axes",
    ),
];

#[test]
fn wrong_commands_are_refused() {
    let service = Service::start();
    let scenario = service.get("/v1/scenarios/stiff_wall").accepted();
    let request = json!({"scenario": "stiff_wall", "interactive": {"paused": true}});
    let run = service.post("/v1/simulations", &request.to_string()).location.unwrap();
    let address = format!("{run}/control");
    assert_all_refused(&service, &address, &json!({}), COMMANDS);
    assert_all_refused(&service, &address, &json!({"controller": scenario["controller"]}), CONTROLLERS);
    service.post(&address, r#"{"step": 3, "paused": false}"#).assert_refused(422, Some("/step"));

    service.post("/v1/simulations/none/control", "{}").assert_refused(404, None);
    service.get("/v1/simulations/none/live").assert_refused(404, None);
    let plain = service.post("/v1/simulations", r#"{"scenario": "stiff_wall"}"#).location.unwrap();
    for run in [&plain, &run] {
        service.delete(run);
        service.post(&format!("{run}/control"), "{}").assert_refused(409, None);
        service.get(&format!("{run}/live")).assert_refused(409, None);
    }
}

#[test]
fn wrong_simulations_are_refused_with_a_pointer() {
    assert_all_refused(&Service::start(), "/v1/simulations", &example("simulation_own.json"), ROWS);
}
