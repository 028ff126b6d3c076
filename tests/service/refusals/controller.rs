//! `POST /v1/controllers`, and the same object inside `POST /v1/step`.

use serde_json::{Value, json};

use super::{NO_POINTER, OMITTED, Row, assert_all_refused};
use crate::harness::{Service, example};

const CONTROLLER: &[Row] = &[
    ("/robot", OMITTED, 422, ""),
    ("/robot", r#""puma""#, 422, "/robot"),
    ("/robot", "null", 422, "/robot"),
    ("/period_s", OMITTED, 422, ""),
    ("/period_s", "0", 422, "/period_s"),
    ("/period_s", "-0.0", 422, "/period_s"),
    ("/period_s", "-0.001", 422, "/period_s"),
    ("/period_s", "1e-9", 422, "/period_s"),
    ("/period_s", "3600", 422, "/period_s"),
    ("/period_s", "1e308", 422, "/period_s"),
    ("/period_s", "1e999", 400, NO_POINTER),
    ("/period_s", "NaN", 400, NO_POINTER),
    ("/period_s", "true", 422, "/period_s"),
    ("/method", r#""fastest""#, 422, "/method"),
    ("/solver", r#""qpoases""#, 422, "/solver"),
    ("/limits", r#""some""#, 422, "/limits"),
    ("/limits", r#"{"lower": [], "upper": []}"#, 422, "/limits/lower"),
    ("/limits", r#"{"lower": [1, 0, 0, 0, 0, 0, 0], "upper": [0, 0, 0, 0, 0, 0, 0]}"#, 422, "/limits/lower/0"),
    ("/limits", r#"{"lower": [0, 0, 0, 0, 0, 0, 0], "upper": [0, 0, 0, 0, 0, 0]}"#, 422, "/limits/upper"),
    ("/limits", r#"{"lower": [0, 0, 0, 0, 0, 0, 0], "upper": [0, 0, 0, 0, 0, 0, "0"]}"#, 422, "/limits/upper/6"),
    ("/drive", "0.03", 422, "/drive"),
    ("/drive", r#"{"lag_s": -0.001}"#, 422, "/drive/lag_s"),
    ("/drive", r#"{"lag_s": 2}"#, 422, "/drive/lag_s"),
    ("/drive", r#"{"delay_periods": 65}"#, 422, "/drive/delay_periods"),
    ("/drive", r#"{"delay_periods": 0.5}"#, 422, "/drive/delay_periods"),
    ("/drive", r#"{"delay_s": 0.5}"#, 422, "/drive/delay_s"),
    ("/wrench_convention", r#""on_table""#, 422, "/wrench_convention"),
    ("/damping", "[0.05, 0.1]", 422, "/damping"),
    ("/damping", r#"{"threshold": -1, "max_factor": 0.1}"#, 422, "/damping"),
    ("/damping", r#"{"threshold": 1}"#, 422, "/damping"),
    ("/damping", r#"{"threshold": 1, "max_factor": 0.1, "kind": "svd"}"#, 422, "/damping/kind"),
    ("/gain", "1", 422, "/gain"),
    ("/environment", "1e5", 422, "/environment"),
    ("/environment", "[]", 422, "/environment"),
    ("/environment", r#"{"w": {"stiffness": 1}}"#, 422, "/environment/w"),
    ("/environment", r#"{"x": 1e5}"#, 422, "/environment/x"),
    ("/environment", r#"{"x": {}}"#, 422, "/environment/x"),
    ("/environment", r#"{"x": {"stiffness": 1}, "x": {"stiffness": 2}}"#, 422, "/environment"),
    ("/environment", r#"{"x": {"stiffness": -1}}"#, 422, "/environment/x/stiffness"),
    ("/environment", r#"{"y": {"stiffness": 1e308}}"#, 422, "/environment/y/stiffness"),
    ("/environment", r#"{"z": {"stiffness": 1, "damping": -1}}"#, 422, "/environment/z/damping"),
    ("/environment", r#"{"rz": {"stiffness": 1, "inertia": -1}}"#, 422, "/environment/rz/inertia"),
    ("/environment", r#"{"rx": {"stiffness": 1, "mass": 1}}"#, 422, "/environment/rx/mass"),
    ("/environment", r#"{"lag_s": -0.001}"#, 422, "/environment/lag_s"),
    ("/environment", r#"{"delay_periods": 9}"#, 422, "/environment/delay_periods"),
    ("/environment", r#"{"delay_periods": 1.5}"#, 422, "/environment/delay_periods"),
    ("/environment", r#"{"velocity_measured": "yes"}"#, 422, "/environment/velocity_measured"),
    ("/tasks", OMITTED, 422, ""),
    ("/tasks", "[]", 422, "/tasks"),
    ("/tasks/1/name", r#""push""#, 422, "/tasks/1/name"),
    ("/tasks/0/name", OMITTED, 422, "/tasks/0"),
    ("/tasks/0/axes", "[]", 422, "/tasks/0/axes"),
    ("/tasks/0/axes", r#"["x", "x"]"#, 422, "/tasks/0/axes"),
    ("/tasks/0/axes", r#"["x", "y"]"#, 422, "/tasks/0/law/inertia"),
    ("/tasks/0/jacobian", "[[1, 0, 0, 0, 0, 0, 0]]", 422, "/tasks/0"),
    ("/tasks/0/streaming", "[]", 422, "/tasks/0/streaming"),
    ("/tasks/0/streaming", r#"{"horizon_s": 1}"#, 422, "/tasks/0/streaming/horizon_s"),
    ("/tasks/0/streaming", r#"{"hold_after_s": -1}"#, 422, "/tasks/0/streaming/hold_after_s"),
    ("/tasks/0/streaming", r#"{"brake_after_s": 0.01}"#, 422, "/tasks/0/streaming/brake_after_s"),
    ("/tasks/0/streaming", r#"{"delay_s": 11}"#, 422, "/tasks/0/streaming/delay_s"),
    ("/tasks/0/streaming", r#"{"smoothing_s": 1e308}"#, 422, "/tasks/0/streaming/smoothing_s"),
    ("/tasks/0/streaming", r#"{"max_velocity": 0}"#, 422, "/tasks/0/streaming/max_velocity"),
    ("/tasks/0/streaming", r#"{"max_velocity": 1e308}"#, 422, "/tasks/0/streaming/max_velocity"),
    ("/tasks/0/streaming", r#"{"max_acceleration": [1, 2]}"#, 422, "/tasks/0/streaming/max_acceleration"),
    ("/tasks/0/lower", "[0]", 422, "/tasks/0"),
    ("/tasks/0/upper", "[null]", 422, "/tasks/0"),
    ("/tasks/0", BOUNDS_AND_SCALE, 422, "/tasks/0/scale"),
    ("/tasks/0", BOUNDS_CROSSED, 422, "/tasks/0/lower/1"),
    ("/tasks/0", BOUNDS_TOO_FEW, 422, "/tasks/0/upper"),
    ("/tasks/0", BOUNDS_TOO_LARGE, 422, "/tasks/0/upper/0"),
    ("/tasks/0", r#"{"name": "b", "lower": [0]}"#, 422, "/tasks/0/axes"),
    ("/tasks/0", r#"{"name": "b", "axes": ["x"]}"#, 422, "/tasks/0"),
    ("/tasks/0", r#"{"name": "b", "axes": [], "lower": []}"#, 422, "/tasks/0/axes"),
    ("/tasks/0", POSTURE_WITH_BOUNDS, 422, "/tasks/0/lower"),
    ("/tasks/0", POSTURE_WITH_ROWS, 422, "/tasks/0/jacobian"),
    ("/tasks/0", r#"{"name": "r", "jacobian": [[1, 0, 0, 0, 0, 0, 0]]}"#, 422, "/tasks/0"),
    ("/tasks/0", r#"{"name": "r", "jacobian": [], "lower": []}"#, 422, "/tasks/0/jacobian"),
    ("/tasks/0", r#"{"name": "r", "jacobian": [[1, 0]], "lower": [0]}"#, 422, "/tasks/0/jacobian"),
    ("/tasks/0", ROWS_OF_TWO_LENGTHS, 422, "/tasks/0/jacobian/1"),
    ("/tasks/0", ROWS_IN_FRAME, 422, "/tasks/0/frame"),
    ("/tasks/0", ROWS_AT_POINT, 422, "/tasks/0/reference_point"),
    ("/tasks/0", ROWS_WITH_POSE, 422, "/tasks/0/law/kind"),
    ("/tasks/0", ROWS_WITH_FORCE, 422, "/tasks/0/law/kind"),
    ("/tasks/0", ROWS_WITH_LONG_VELOCITY, 422, "/tasks/0/law/target_velocity/value"),
    ("/tasks/0/law", OMITTED, 422, "/tasks/0"),
    ("/tasks/0/law", "null", 422, "/tasks/0"),
    ("/tasks/0/law", "{}", 422, "/tasks/0/law"),
    ("/tasks/0/law", r#""force""#, 422, "/tasks/0/law"),
    ("/tasks/0/law/kind", r#""magic""#, 422, "/tasks/0/law/kind"),
    ("/tasks/0/law/kind", r#""impedance""#, 422, "/tasks/0/law"),
    ("/tasks/0/law/stiffness", "[1]", 422, "/tasks/0/law"),
    ("/tasks/0/law/inertia", OMITTED, 422, "/tasks/0/law"),
    ("/tasks/0/law/inertia", r#""15""#, 422, "/tasks/0/law"),
    ("/tasks/0/law/inertia", r#"["15"]"#, 422, "/tasks/0/law"),
    ("/tasks/0/law/inertia", "null", 422, "/tasks/0/law"),
    ("/tasks/0/law/inertia", "0", 422, "/tasks/0/law/inertia"),
    ("/tasks/0/law/inertia", "-15", 422, "/tasks/0/law/inertia"),
    ("/tasks/0/law/inertia", "1e308", 422, "/tasks/0/law/inertia"),
    ("/tasks/0/law/inertia", "9.99e-7", 422, "/tasks/0/law/inertia"),
    ("/tasks/0/law/inertia", "[1e-200]", 422, "/tasks/0/law/inertia/0"),
    ("/tasks/0/law/inertia", "1e999", 400, NO_POINTER),
    ("/tasks/0/law/inertia", "[]", 422, "/tasks/0/law/inertia"),
    ("/tasks/0/law/inertia", "[15, 15]", 422, "/tasks/0/law/inertia"),
    ("/tasks/0/law/inertia", "[0]", 422, "/tasks/0/law/inertia/0"),
    ("/tasks/0/law/inertia", "[-15]", 422, "/tasks/0/law/inertia/0"),
    ("/tasks/0/law/inertia", "[1e308]", 422, "/tasks/0/law/inertia/0"),
    ("/tasks/0/law/inertia", "[1e999]", 400, NO_POINTER),
    ("/tasks/0/law/inertia", "[NaN]", 400, NO_POINTER),
    ("/tasks/0/law/damping", "[-1]", 422, "/tasks/0/law/damping/0"),
    ("/tasks/0/law/damping", "[]", 422, "/tasks/0/law/damping"),
    ("/tasks/1/law/stiffness/4", "-1", 422, "/tasks/1/law/stiffness/4"),
    ("/tasks/1/law/stiffness/4", "1e10", 422, "/tasks/1/law/stiffness/4"),
    ("/tasks/1/law/stiffness", "[1, 1]", 422, "/tasks/1/law/stiffness"),
    ("/tasks/0/law/target_force", "30", 422, "/tasks/0/law"),
    ("/tasks/0/law/target_force/kind", r#""square""#, 422, "/tasks/0/law"),
    ("/tasks/0/law/target_force/value", "[]", 422, "/tasks/0/law/target_force/value"),
    ("/tasks/0/law/target_force/value", "[30, 30]", 422, "/tasks/0/law/target_force/value"),
    ("/tasks/0/law/target_force/value", "[1e300]", 422, "/tasks/0/law/target_force/value/0"),
    ("/tasks/0/law/target_force", r#"{"kind": "sine", "offset": [1], "amplitude": [1]}"#, 422, "/tasks/0/law"),
    ("/tasks/0/law/target_force", SHORT_AMPLITUDE, 422, "/tasks/0/law/target_force/amplitude"),
    ("/tasks/0/law/target_force", FAST_SINE, 422, "/tasks/0/law/target_force/angular_frequency_rad_s"),
    ("/tasks/0/law/target_force/value", "1e300", 422, "/tasks/0/law/target_force/value"),
    ("/tasks/0/law/target_force", r#"{"kind": "ramp", "start": 0, "end": 1}"#, 422, "/tasks/0/law"),
    ("/tasks/0/law/target_force", NO_RAMP, 422, "/tasks/0/law/target_force/duration_s"),
    ("/tasks/0/law/target_force", r#"{"kind": "steps", "points": []}"#, 422, "/tasks/0/law/target_force/points"),
    ("/tasks/0/law/target_force", r#"{"kind": "steps", "points": [[0, 1]]}"#, 422, "/tasks/0/law"),
    ("/tasks/0/law/target_force", SAME_TIME, 422, "/tasks/0/law/target_force/points/1/time_s"),
    ("/tasks/0/law/target_force", BACK_IN_TIME, 422, "/tasks/0/law/target_force/points/2/time_s"),
    ("/tasks/0/law/target_force", LONG_POINT, 422, "/tasks/0/law/target_force/points/1/value"),
    ("/tasks/0/law/target_force", FAR_POINT, 422, "/tasks/0/law/target_force/points/1/value/0"),
    ("/tasks/0/law/target_force", LATE_POINT, 422, "/tasks/0/law/target_force/points/1/time_s"),
    ("/tasks/0/law", SHORT_SELECTION, 422, "/tasks/0/law/position_controlled"),
    ("/tasks/0/law", LONG_VELOCITY, 422, "/tasks/0/law/target_velocity/value"),
    ("/tasks/1/law/target_pose", r#""here""#, 422, "/tasks/1/law"),
    ("/tasks/1/law/target_pose", r#"{"position": [0, 0, 0]}"#, 422, "/tasks/1/law"),
    ("/tasks/1/law/target_pose", SHORT_POSITION, 422, "/tasks/1/law"),
    ("/tasks/1/law/target_pose", FAR_POSITION, 422, "/tasks/1/law/target_pose/position/1"),
    ("/tasks/1/law/target_pose", ZERO_QUATERNION, 422, "/tasks/1/law/target_pose/orientation"),
    ("/tasks/1/law/target_pose", LONG_QUATERNION, 422, "/tasks/1/law/target_pose/orientation"),
    ("/tasks/1/law/target_pose", HUGE_QUATERNION, 422, "/tasks/1/law/target_pose/orientation"),
    ("/tasks/1/law/target_pose", LIST_QUATERNION, 422, "/tasks/1/law"),
    ("/tasks/1/law/target_pose", "null", 422, "/tasks/1/law"),
    ("/tasks/1/law/target_pose/x", "1", 422, "/tasks/1/law"),
    ("/tasks/1/law/target_displacement", r#"{"kind": "constant", "value": [1]}"#, 422, DISPLACEMENT_VALUE),
    ("/tasks/1/law/target_displacement", r#"{"kind": "constant", "value": 1e300}"#, 422, DISPLACEMENT_VALUE),
    ("/tasks/1/law/target_displacement", "0.1", 422, "/tasks/1/law"),
    ("/tasks/0/law/target_displacement", r#"{"kind": "constant", "value": 0}"#, 422, "/tasks/0/law"),
    ("/tasks/0/axes", OMITTED, 422, "/tasks/0/axes"),
    ("/tasks/0/axes", "null", 422, "/tasks/0/axes"),
    ("/tasks/0/frame", r#""wall""#, 422, "/tasks/0/frame"),
    ("/tasks/0/frame", "null", 422, "/tasks/0/frame"),
    ("/tasks/0/frame", r#"{"position": [0, 0, 0]}"#, 422, "/tasks/0/frame"),
    ("/tasks/0/frame", ZERO_QUATERNION, 422, "/tasks/0/frame/orientation"),
    ("/tasks/0/frame", FAR_POSITION, 422, "/tasks/0/frame/position/1"),
    ("/tasks/0/reference_point", "[0, 0]", 422, "/tasks/0/reference_point"),
    ("/tasks/0/reference_point", "[0, 0, 1e300]", 422, "/tasks/0/reference_point/2"),
    ("/tasks/0/reference_point", r#"{"x": 1}"#, 422, "/tasks/0/reference_point"),
    ("/tool_offset", ZERO_QUATERNION, 422, "/tool_offset/orientation"),
    ("/tool_offset", FAR_POSITION, 422, "/tool_offset/position/1"),
    ("/tool_offset", "[0, 0, 0.1]", 422, "/tool_offset"),
    ("/tool_offset", r#""initial""#, 422, "/tool_offset"),
    ("/wrench_frame", r#""world""#, 422, "/wrench_frame"),
    ("/null_space_velocity", "[1, 2]", 422, "/null_space_velocity"),
    ("/null_space_velocity", "3", 422, "/null_space_velocity"),
    ("/null_space_velocity", r#"{"elbow": 1}"#, 422, "/null_space_velocity/elbow"),
    ("/null_space_velocity", r#"{"kind": "joint_limits"}"#, 422, "/null_space_velocity"),
    ("/null_space_velocity", r#"{"kind": "singularities", "gain": 1}"#, 422, "/null_space_velocity"),
    ("/null_space_velocity", r#"{"kind": "joint_limits", "gain": -1}"#, 422, "/null_space_velocity/gain"),
    ("/null_space_velocity", r#"{"kind": "joint_limits", "gain": 1e9}"#, 422, "/null_space_velocity/gain"),
    ("/null_space_velocity", r#"{"kind": "joint_limits", "gain": 1, "n": 7}"#, 422, "/null_space_velocity"),
    ("/null_space_velocity", r#"["joint_limits", 1]"#, 422, "/null_space_velocity"),
    ("/null_space_velocity", SHORT_POSTURE, 422, "/null_space_velocity/joint_position"),
    ("/tasks/0", POSTURE_WITH_AXES, 422, "/tasks/0/axes"),
    ("/tasks/0", POSTURE_IN_FRAME, 422, "/tasks/0/frame"),
    ("/tasks/0", POSTURE_AT_POINT, 422, "/tasks/0/reference_point"),
    ("/tasks/0", POSTURE_OF_NO_JOINT, 422, "/tasks/0/law/joints"),
    ("/tasks/0", POSTURE_OF_UNKNOWN, 422, "/tasks/0/law/joints/1"),
    ("/tasks/0", POSTURE_OF_TWINS, 422, "/tasks/0/law/joints"),
    ("/tasks/0", SHORT_TARGET, 422, "/tasks/0/law/target_position/value"),
    ("/tasks/0", NEGATIVE_GAIN, 422, "/tasks/0/law/gain"),
    ("/tasks/0", HARD_GAIN, 422, "/tasks/0/law/gain"),
    (
        "/tasks/0",
        r#"{"name": "p", "law": {"kind": "posture", "gain": 1, "target_position": "home"}}"#,
        422,
        "/tasks/0/law",
    ),
    ("/tasks/0", r#"{"name": "p", "law": {"kind": "pose", "gain": 1}}"#, 422, "/tasks/0/axes"),
    ("/tasks/0/law", r#"{"kind": "pose"}"#, 422, "/tasks/0/law"),
    ("/tasks/0/law", r#"{"kind": "pose", "gain": [1, 2]}"#, 422, "/tasks/0/law/gain"),
    ("/tasks/0/law", r#"{"kind": "pose", "gain": [-1]}"#, 422, "/tasks/0/law/gain/0"),
    ("/tasks/0/law", r#"{"kind": "pose", "gain": 2000}"#, 422, "/tasks/0/law/gain"),
    ("/tasks/0/law", r#"{"kind": "pose", "gain": 1, "stiffness": 1}"#, 422, "/tasks/0/law"),
    ("/tasks/0/law", r#"{"kind": "pose", "gain": 1, "max_acceleration": 0}"#, 422, "/tasks/0/law/max_acceleration"),
    (
        "/tasks/0/law",
        r#"{"kind": "pose", "gain": 1, "max_acceleration": [-1]}"#,
        422,
        "/tasks/0/law/max_acceleration/0",
    ),
    (
        "/tasks/0/law",
        r#"{"kind": "pose", "gain": 1, "max_acceleration": [1, 2]}"#,
        422,
        "/tasks/0/law/max_acceleration",
    ),
    ("/tasks/0/law", CONTRADICTORY_BRAKING, 422, "/tasks/0/law/max_acceleration"),
    ("/tasks/0/law", r#"{"kind": "pose", "gain": 1, "braking": 1}"#, 422, "/tasks/0/law"),
    ("/anti_windup", r#""never""#, 422, "/anti_windup"),
    ("/anti_windup", "true", 422, "/anti_windup"),
];

const CONTRADICTORY_BRAKING: &str = r#"{"kind": "pose", "gain": 1, "max_acceleration": 1, "braking": false}"#;
const BOUNDS_AND_SCALE: &str = r#"{"name": "b", "axes": ["x"], "upper": [1], "scale": true}"#;
const BOUNDS_CROSSED: &str = r#"{"name": "b", "axes": ["x", "y"], "lower": [0, 0.2], "upper": [null, 0.1]}"#;
const BOUNDS_TOO_FEW: &str = r#"{"name": "b", "axes": ["x", "y"], "lower": [0, 0], "upper": [1]}"#;
const BOUNDS_TOO_LARGE: &str = r#"{"name": "b", "axes": ["x", "y"], "upper": [1e10, 1]}"#;
const POSTURE_WITH_BOUNDS: &str =
    r#"{"name": "p", "lower": [0], "law": {"kind": "posture", "gain": 1, "target_position": "mid_range"}}"#;
const POSTURE_WITH_ROWS: &str = r#"{"name": "p", "jacobian": [[1, 0, 0, 0, 0, 0, 0]],
    "law": {"kind": "posture", "gain": 1, "target_position": "mid_range"}}"#;
const ROWS_OF_TWO_LENGTHS: &str = r#"{"name": "r", "jacobian": [[1, 0, 0, 0, 0, 0, 0], [1]], "lower": [0, 0]}"#;
const ROWS_IN_FRAME: &str = r#"{"name": "r", "jacobian": [[1, 0, 0, 0, 0, 0, 0]], "frame": "tool", "lower": [0]}"#;
const ROWS_AT_POINT: &str =
    r#"{"name": "r", "jacobian": [[1, 0, 0, 0, 0, 0, 0]], "reference_point": [0, 0, 1], "lower": [0]}"#;
const ROWS_WITH_POSE: &str =
    r#"{"name": "r", "jacobian": [[1, 0, 0, 0, 0, 0, 0]], "law": {"kind": "pose", "gain": 1}}"#;
const ROWS_WITH_FORCE: &str = r#"{"name": "r", "jacobian": [[1, 0, 0, 0, 0, 0, 0]], "law": {"kind": "force",
    "inertia": 1, "damping": 1, "target_force": {"kind": "constant", "value": 1}}}"#;
const ROWS_WITH_LONG_VELOCITY: &str = r#"{"name": "r", "jacobian": [[1, 0, 0, 0, 0, 0, 0]],
    "law": {"kind": "velocity", "target_velocity": {"kind": "constant", "value": [1, 2]}}}"#;
const DISPLACEMENT_VALUE: &str = "/tasks/1/law/target_displacement/value";
const NO_RAMP: &str = r#"{"kind": "ramp", "start": 0, "end": 1, "duration_s": 0}"#;
const SAME_TIME: &str = r#"{"kind": "waypoints", "points": [{"time_s": 1, "value": 1}, {"time_s": 1, "value": 2}]}"#;
const BACK_IN_TIME: &str = r#"{"kind": "steps", "points": [{"time_s": 1, "value": 1}, {"time_s": 2, "value": 1},
    {"time_s": 1.5, "value": 1}]}"#;
const LONG_POINT: &str = r#"{"kind": "steps", "points": [{"time_s": 1, "value": 1}, {"time_s": 2, "value": [1, 2]}]}"#;
const FAR_POINT: &str =
    r#"{"kind": "waypoints", "points": [{"time_s": 1, "value": 1}, {"time_s": 2, "value": [1e10]}]}"#;
const LATE_POINT: &str = r#"{"kind": "steps", "points": [{"time_s": 1, "value": 1}, {"time_s": 1e10, "value": 1}]}"#;
const SHORT_POSTURE: &str = r#"{"kind": "posture", "joint_position": [1, 2], "gain": 1}"#;
const POSTURE_WITH_AXES: &str =
    r#"{"name": "p", "axes": ["x"], "law": {"kind": "posture", "gain": 1, "target_position": "mid_range"}}"#;
const POSTURE_IN_FRAME: &str =
    r#"{"name": "p", "frame": "tool", "law": {"kind": "posture", "gain": 1, "target_position": "mid_range"}}"#;
const POSTURE_AT_POINT: &str = r#"{"name": "p", "reference_point": [0, 0, 1],
    "law": {"kind": "posture", "gain": 1, "target_position": "mid_range"}}"#;
const POSTURE_OF_NO_JOINT: &str =
    r#"{"name": "p", "law": {"kind": "posture", "joints": [], "gain": 1, "target_position": "mid_range"}}"#;
const POSTURE_OF_UNKNOWN: &str =
    r#"{"name": "p", "law": {"kind": "posture", "joints": ["j1", "j9"], "gain": 1, "target_position": "mid_range"}}"#;
const POSTURE_OF_TWINS: &str =
    r#"{"name": "p", "law": {"kind": "posture", "joints": ["j1", "j1"], "gain": 1, "target_position": "mid_range"}}"#;
const SHORT_TARGET: &str = r#"{"name": "p", "law": {"kind": "posture", "joints": ["j1", "j2"], "gain": 1,
    "target_position": {"kind": "constant", "value": [1]}}}"#;
const NEGATIVE_GAIN: &str = r#"{"name": "p", "law": {"kind": "posture", "gain": -1, "target_position": "mid_range"}}"#;
const HARD_GAIN: &str = r#"{"name": "p", "law": {"kind": "posture", "joints": ["j2"], "gain": 2000,
    "target_position": {"kind": "constant", "value": 0}}}"#;

const SHORT_AMPLITUDE: &str = r#"{"kind": "sine", "offset": [1], "amplitude": [], "angular_frequency_rad_s": 1}"#;
const FAST_SINE: &str = r#"{"kind": "sine", "offset": [1], "amplitude": [1], "angular_frequency_rad_s": 1e300}"#;
const SHORT_SELECTION: &str = r#"{"kind": "hybrid", "inertia": [1], "damping": [1], "stiffness": [1],
    "position_controlled": [], "target_force": {"kind": "constant", "value": [1]}}"#;
const LONG_VELOCITY: &str = r#"{"kind": "velocity", "target_velocity": {"kind": "constant", "value": [1, 2]}}"#;
const SHORT_POSITION: &str = r#"{"position": [0, 0], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}"#;
const FAR_POSITION: &str = r#"{"position": [0, 1e300, 0], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}"#;
const ZERO_QUATERNION: &str = r#"{"position": [0, 0, 0], "orientation": {"w": 0, "x": 0, "y": 0, "z": 0}}"#;
const LONG_QUATERNION: &str = r#"{"position": [0, 0, 0], "orientation": {"w": 1, "x": 0.1, "y": 0, "z": 0}}"#;
const HUGE_QUATERNION: &str = r#"{"position": [0, 0, 0], "orientation": {"w": 1e300, "x": 1e300, "y": 0, "z": 0}}"#;
const LIST_QUATERNION: &str = r#"{"position": [0, 0, 0], "orientation": [1, 0, 0, 0]}"#;

/// Returns the example controller, with a pose to change.
fn controller() -> Value {
    let mut controller = example("controller.json");
    controller["tasks"][1]["law"]["target_pose"] =
        json!({"position": [0.6, 0.1, 0.3], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}});
    controller
}

#[test]
fn wrong_controllers_are_refused() {
    assert_all_refused(&Service::start(), "/v1/controllers", &controller(), CONTROLLER);
}

#[test]
fn wrong_controllers_are_refused_in_a_step_with_the_whole_pointer() {
    let mut step = example("step.json");
    step["controller"] = controller();
    let service = Service::start();
    let inside = |text: &'static str| -> &'static str {
        if text == NO_POINTER { text } else { format!("/controller{text}").leak() }
    };
    let rows: Vec<Row> =
        CONTROLLER.iter().map(|&(at, text, status, to)| (inside(at), text, status, inside(to))).collect();
    assert_all_refused(&service, "/v1/step", &step, &rows);
}

#[test]
fn a_controller_has_at_most_64_tasks() {
    let service = Service::start();
    let law = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": [0.01]}});
    let task = |k: usize| json!({"name": format!("task {k}"), "axes": ["x"], "law": law});
    let with = |tasks: usize| {
        let tasks: Vec<_> = (0..tasks).map(task).collect();
        json!({"robot": "sawyer_dh", "period_s": 0.001, "tasks": tasks}).to_string()
    };
    service.post("/v1/controllers", &with(65)).assert_refused(422, Some("/tasks"));
    service.post("/v1/controllers", &with(64)).accepted();
}

#[test]
fn a_controller_has_at_most_512_rows() {
    let service = Service::start();
    let with = |rows: usize| {
        let task = json!({"name": "rows", "jacobian": vec![vec![1; 7]; rows], "upper": vec![1; rows]});
        json!({"robot": "sawyer_dh", "period_s": 0.001, "tasks": [task]}).to_string()
    };
    service.post("/v1/controllers", &with(513)).assert_refused(422, Some("/tasks"));
    service.post("/v1/controllers", &with(512)).accepted();
}

#[test]
fn sessions_above_the_maximum_are_refused() {
    let service = Service::start();
    let body = example("controller.json").to_string();
    for _ in 0..1024 {
        service.post("/v1/controllers", &body).accepted();
    }
    service.post("/v1/controllers", &body).assert_refused(503, None);
    service.assert_alive();
}
