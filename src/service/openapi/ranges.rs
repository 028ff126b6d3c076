//! The ranges of fields in the schemas, from the constants that the service checks.

use std::collections::BTreeSet;

use revprio_api::wire;
use revprio_core::channel::{MAX_CHANNEL_TARGETS, MAX_CHANNELS};
use revprio_core::collision::MAX_OBSTACLES;
use revprio_core::controller::{LINE_INTERVALS, MAX_DELAY_PERIODS, TIMES_AHEAD};
use revprio_core::law::{ContactLaw, ContactSettings};
use revprio_core::limits::MAX_DRIVE_DELAY;
use revprio_core::payload::MIN_POSTURES;
use revprio_core::streaming::{
    MAX_ACTIONS, MAX_FORESIGHT, MAX_KEPT_ACTIONS, MAX_STREAMING_TIME, MAX_TARGETS_AHEAD, MIN_INTERVAL,
};
use revprio_core::surface::SurfaceSettings;
use revprio_core::wrench::MIN_TARE_READINGS;
use revprio_lab::simulator::{
    Contact, Edge, Faults, Friction, Hinge, Hole, Outage, Scenario, Sensor, Sensors, TargetProgram, VelocityLoop,
    name_pattern,
};
use revprio_robot::collision::MAX_CAPSULES;
use serde_json::{Value, json};

use super::schemas::{references, schema_name, variants, visit};
use crate::service::convert::{
    CHARACTERISTIC_LENGTH_M, MAX_ENVIRONMENT_DELAY, MAX_FILTER_S, MAX_INEQUALITIES, MAX_LAG_S, MAX_MAGNITUDE,
    MAX_PAYLOAD_KG, MAX_PERIOD_S, MAX_POINTS, MAX_READINGS, MAX_REMEMBERED, MAX_ROWS, MAX_SEQUENCE, MAX_SPEED,
    MAX_STEPS, MAX_TASKS, MAX_TIME_S, MAX_TIPS, MAX_VALID_FOR_MS, MIN_INERTIA, MIN_PERIOD_S, MIN_SPEED, RATE_PER_S,
};
use crate::service::robots::{MAX_JOINTS, MAX_NAME};
use crate::service::step::MAX_ITEMS;

/// The range of a field.
enum Range {
    /// Numbers above zero.
    Positive,
    /// Numbers above zero, up to the bound.
    PositiveUpTo(f64),
    /// Numbers from zero.
    NotNegative,
    /// Numbers from the first to the second bound.
    Between(f64, f64),
    /// Whole numbers from zero to the bound.
    UpTo(usize),
    /// Minimum and maximum number of items.
    Items(usize, usize),
    /// Minimum and maximum number of items, without repetitions.
    UniqueItems(usize, usize),
    /// Allowed number of rows, and allowed number of columns.
    Rows([usize; 2], [usize; 2]),
    /// Texts that match the regular expression.
    Pattern(String),
}

use Range::{Between, Items, NotNegative, Pattern, Positive, PositiveUpTo, Rows, UniqueItems, UpTo};

/// The range of one field of a schema.
struct FieldRange {
    /// Name of the schema.
    schema: String,
    /// Name of the field, in the schema itself or in some of its variants.
    field: &'static str,
    range: Range,
}

/// Defines the list of ranges.
///
/// `Type { field: range, … }` is about the fields of a struct. `Type as Type::Variant { field: range, … }` is about the
/// fields of these names in all variants of an enum; the variant is any one that has them. The expansion matches each field
/// by a pattern, so a misspelt type, variant or field does not compile.
macro_rules! field_ranges {
    (@check $type:ty { $($field:ident)+ }) => {
        let _ = |value: &$type| { $(let _ = &value.$field;)+ };
    };
    (@check $type:ty, $variant:path { $($field:ident)+ }) => {
        let _ = |value: &$type| matches!(value, $variant { $($field: _,)+ .. });
    };
    ($($type:ty $(as $variant:path)? { $($field:ident: $range:expr),+ $(,)? })+) => {{
        $(field_ranges!(@check $type $(, $variant)? { $($field)+ });)+
        vec![$($(
            FieldRange { schema: schema_name::<$type>(), field: stringify!($field), range: $range },
        )+)+]
    }};
}

/// Maximum magnitude of a component of a unit quaternion.
const UNIT: f64 = 1.0 + revprio_robot::kinematics::UNIT_LENGTH_TOLERANCE;

/// Returns the ranges of fields of requests.
fn request_ranges() -> Vec<FieldRange> {
    field_ranges! {
        wire::BatchRequest { items: Items(0, MAX_ITEMS) }
        wire::Controller {
            period_s: Between(MIN_PERIOD_S, MAX_PERIOD_S),
            characteristic_length_m: Between(CHARACTERISTIC_LENGTH_M.0, CHARACTERISTIC_LENGTH_M.1),
            tasks: Items(1, MAX_TASKS),
            channels: Items(0, MAX_CHANNELS),
            inequalities: Items(0, MAX_INEQUALITIES),
            valid_for_ms: Between(1.0, MAX_VALID_FOR_MS as f64),
        }
        wire::JointDrive { lag_s: Between(0.0, MAX_LAG_S), delay_periods: UpTo(MAX_DRIVE_DELAY) }
        wire::StateChecks { position_tolerance: NotNegative, max_force_n: NotNegative, max_torque_nm: NotNegative }
        wire::ControllerTask {
            axes: UniqueItems(1, 6),
            reference_point: Items(3, 3),
            jacobian: Rows([1, MAX_ROWS], [1, MAX_JOINTS]),
            lower: Items(1, MAX_ROWS),
            upper: Items(1, MAX_ROWS),
        }
        wire::Pose { position: Items(3, 3) }
        wire::FramePose { position: Items(3, 3), rotation: Rows([3, 3], [3, 3]) }
        wire::Wrench { force: Items(3, 3), torque: Items(3, 3) }
        wire::ResolveRequest {
            period_s: Between(MIN_PERIOD_S, MAX_PERIOD_S),
            tasks: Items(1, MAX_ROWS),
            inequalities: Items(0, MAX_INEQUALITIES),
        }
        wire::ResolveTask {
            axes: UniqueItems(1, 6),
            reference_point: Items(3, 3),
            jacobian: Rows([1, MAX_ROWS], [1, MAX_JOINTS]),
            velocity: Items(1, MAX_ROWS),
            lower: Items(1, MAX_ROWS),
            upper: Items(1, MAX_ROWS),
        }
        wire::Limits as wire::Limits::Box { lower: Items(1, MAX_JOINTS), upper: Items(1, MAX_JOINTS) }
        wire::Profile as wire::Profile::Ramp { duration_s: Between(1e-6, MAX_MAGNITUDE) }
        wire::Profile as wire::Profile::Steps { points: Items(1, MAX_POINTS) }
        wire::Inequality as wire::Inequality::Joints { coefficients: Items(1, MAX_JOINTS) }
        wire::Inequality as wire::Inequality::Plane { normal: Items(3, 3), rate_per_s: Positive }
        wire::Damping { threshold: Positive, max_factor: NotNegative }
        wire::NullSpaceMotion as wire::NullSpaceMotion::Posture { gain: NotNegative }
        wire::Orientation {
            w: Between(-UNIT, UNIT),
            x: Between(-UNIT, UNIT),
            y: Between(-UNIT, UNIT),
            z: Between(-UNIT, UNIT),
        }
        wire::Environment { lag_s: NotNegative, delay_periods: UpTo(MAX_ENVIRONMENT_DELAY) }
        wire::EnvironmentAxis { stiffness: NotNegative, damping: NotNegative, inertia: NotNegative }
        wire::StabilityRequest {
            inertia: Between(MIN_INERTIA, MAX_MAGNITUDE),
            damping: NotNegative,
            stiffness: NotNegative,
            period_s: Between(MIN_PERIOD_S, MAX_PERIOD_S),
            lag_s: NotNegative,
            delay_periods: UpTo(MAX_DELAY_PERIODS),
        }
        wire::State { time_s: Between(-MAX_TIME_S, MAX_TIME_S) }
        wire::Collisions { min_distance_m: Between(0.0, 1.0), rate_per_s: Between(RATE_PER_S.0, RATE_PER_S.1), obstacles: Items(0, MAX_OBSTACLES) }
        wire::Sphere { center: Items(3, 3), radius: Positive }
        wire::Capsule { start: Items(3, 3), end: Items(3, 3), radius: Positive }
        wire::Cuboid { size: Items(3, 3) }
        wire::HalfSpace { normal: Items(3, 3) }
        wire::ObstacleState { position: Items(3, 3), velocity: Items(3, 3) }
        wire::RobotRegistration { shape_list: Items(0, MAX_CAPSULES), tips: Items(1, MAX_TIPS), name: Pattern(format!("^[A-Za-z0-9][A-Za-z0-9_.-]{{0,{}}}$", MAX_NAME - 1)) }
        wire::StatedLimits { position: Items(2, 2), velocity: Positive, acceleration: Positive, jerk: Positive }
        wire::VelocityEnvelope { deceleration_limit: Positive, velocity_offset: NotNegative }
        wire::Interactive { speed: Between(MIN_SPEED, MAX_SPEED) }
        wire::SimulationControl {
            step: Between(1.0, MAX_STEPS as f64),
            speed: Between(MIN_SPEED, MAX_SPEED),
            external_force: Items(3, 3),
        }
    }
}

/// Returns the ranges of fields of wrench sensors, and of the requests about them.
fn sensor_ranges() -> Vec<FieldRange> {
    field_ranges! {
        wire::WrenchSensor {
            gravity: Items(3, 3),
            filter_time_s: Between(0.0, MAX_FILTER_S),
            deadband_n: NotNegative,
            deadband_nm: NotNegative,
        }
        wire::Payload {
            mass_kg: Between(0.0, MAX_PAYLOAD_KG),
            center_of_mass: Items(3, 3),
        }
        wire::TareRequest { readings: Items(MIN_TARE_READINGS, MAX_READINGS) }
        wire::PayloadRequest {
            gravity: Items(3, 3),
            force_noise_n: Positive,
            torque_noise_nm: Positive,
            readings: Items(MIN_POSTURES, MAX_READINGS),
        }
        wire::PayloadReading { gravity: Items(3, 3) }
    }
}

/// Returns the ranges of fields of laws.
fn law_ranges() -> Vec<FieldRange> {
    field_ranges! {
        wire::Law as wire::Law::Contact {
            approach_speed: Between(ContactSettings::LEAST_MOTION, MAX_MAGNITUDE),
            stiffest: Positive,
            noise: PositiveUpTo(ContactSettings::MOST_NOISE),
            bias: Between(0.0, ContactSettings::MOST_BIAS),
            sensor_lag_s: Between(0.0, ContactLaw::MOST_SENSOR_LAG),
            max_force: Positive,
            retreat_speed: Between(ContactSettings::LEAST_MOTION, MAX_MAGNITUDE),
            max_acceleration: Between(ContactSettings::LEAST_MOTION, MAX_MAGNITUDE),
        }
        wire::SurfaceFollowing { max_tilt_rad: PositiveUpTo(SurfaceSettings::MOST_TILT) }
        wire::Law as wire::Law::Hybrid { inertia: Between(MIN_INERTIA, MAX_MAGNITUDE), damping: NotNegative, stiffness: NotNegative }
        wire::Law as wire::Law::LookAt { gain: NotNegative, max_acceleration: Positive }
        wire::Law as wire::Law::Posture { gain: NotNegative, max_acceleration: Positive, joints: UniqueItems(1, MAX_JOINTS) }
    }
}

/// Returns the ranges of fields of memories, which are parts of requests.
fn memory_ranges() -> Vec<FieldRange> {
    field_ranges! {
        wire::DriveState { velocity: Items(1, MAX_JOINTS), pending: Items(0, MAX_DRIVE_DELAY) }
        wire::JerkState { acceleration: Items(1, MAX_JOINTS), requested: Items(1, MAX_JOINTS) }
        wire::ContactMemory {
            contact_time_s: NotNegative,
            return_speed: NotNegative,
            lack: NotNegative,
            spent_j: NotNegative,
            hold_time_s: NotNegative,
            surface_motion: Items(3, 3),
            followed: Items(8, 8),
            stiffness: Items(3, 3),
            means: Items(2, 2),
            sums: Items(4, 4),
            swing: Items(3, 3),
        }
        wire::MeasuredContact {
            position: Items(3, 3),
            stiffness: Items(3, 3),
            means: Items(2, 2),
            sums: Items(4, 4),
            surface_motion: Items(3, 3),
            followed: Items(8, 8),
        }
        wire::NormalMemory {
            normal: Items(3, 3),
            mean: Items(3, 3),
            friction: NotNegative,
            variance: NotNegative,
            chords: NotNegative,
        }
        wire::WrenchSensorMemory { velocity: Items(3, 3) }
        wire::RestState { fading_since_s: Between(-MAX_TIME_S, MAX_TIME_S) }
        wire::Progress {
            slow_since_s: Between(-MAX_TIME_S, MAX_TIME_S),
            leaving_since_s: Between(-MAX_TIME_S, MAX_TIME_S),
        }
        wire::Memory {
            time_s: Between(-MAX_TIME_S, MAX_TIME_S),
            start_time_s: Between(-MAX_TIME_S, MAX_TIME_S),
            task_velocities: Items(0, MAX_TASKS),
            joint_position: Items(1, MAX_JOINTS),
            valid_for_ms: Between(0.0, MAX_VALID_FOR_MS as f64),
            stop_time_s: Positive,
            last_command: Items(1, MAX_JOINTS),
            active_set: Items(0, MAX_TASKS),
            target_streams: Items(0, 2 * MAX_TASKS),
        }
    }
}

/// Returns the ranges of fields of streamed targets.
fn target_ranges() -> Vec<FieldRange> {
    field_ranges! {
        wire::Streaming {
            hold_after_s: Between(0.0, MAX_STREAMING_TIME),
            brake_after_s: Between(0.0, MAX_STREAMING_TIME),
            delay_s: Between(0.0, MAX_STREAMING_TIME),
            smoothing_s: Between(0.0, MAX_STREAMING_TIME),
            fade_s: Between(0.0, MAX_STREAMING_TIME),
            max_velocity: Positive,
            max_acceleration: Positive,
        }
        wire::StreamedTarget {
            time_s: Between(-MAX_TIME_S, MAX_TIME_S),
            velocity: Items(1, MAX_ROWS),
            force: Items(1, MAX_ROWS),
            ahead: Items(0, MAX_TARGETS_AHEAD),
            chunk: Items(1, MAX_ACTIONS),
        }
        wire::ChunkAction {
            time_s: Between(-MAX_TIME_S, MAX_TIME_S),
            position: Items(3, 3),
            velocity: Items(1, MAX_ROWS),
            force: Items(1, MAX_ROWS),
        }
        wire::Channel { max_rate: Positive }
        wire::ChannelMemory { targets: Items(0, MAX_CHANNEL_TARGETS) }
        wire::ChannelTarget { time_s: Between(-MAX_TIME_S, MAX_TIME_S) }
        wire::ChunkMemory {
            first_s: Between(-MAX_TIME_S, MAX_TIME_S),
            merged_s: Between(-MAX_TIME_S, MAX_TIME_S),
            actions: Items(0, MAX_KEPT_ACTIONS),
        }
        wire::Fade {
            start_s: Between(-MAX_TIME_S, MAX_TIME_S),
            duration_s: Positive,
            offset: Items(1, MAX_ROWS),
            rate: Items(1, MAX_ROWS),
            acceleration: Items(1, MAX_ROWS),
        }
        wire::TargetAhead { after_s: Between(MIN_INTERVAL, MAX_FORESIGHT) }
        wire::TargetStream { ahead: Items(0, MAX_TARGETS_AHEAD) }
        wire::LaterTarget { time_s: Between(-MAX_TIME_S, MAX_TIME_S), values: Items(1, MAX_ROWS) }
        wire::StreamedPose { position: Items(3, 3) }
        wire::TargetSample {
            time_s: Between(-MAX_TIME_S, MAX_TIME_S),
            values: Items(1, MAX_ROWS),
            velocity: Items(1, MAX_ROWS),
        }
        wire::VirtualArm {
            postures: Rows([TIMES_AHEAD.len(), TIMES_AHEAD.len()], [1, MAX_JOINTS]),
            next: UpTo(TIMES_AHEAD.len() - 1),
            target_accelerations: Rows([0, 2 * MAX_TASKS], [1, MAX_ROWS]),
        }
        wire::Line {
            offset: Items(1, MAX_TASKS * MAX_ROWS),
            progress: Between(0.0, 1.0),
            speed: NotNegative,
            postures: Rows([1, LINE_INTERVALS + 1], [1, MAX_JOINTS]),
            speeds: Items(1, LINE_INTERVALS + 1),
        }
        wire::TargetReference { values: Items(1, MAX_ROWS), velocity: Items(1, MAX_ROWS) }
    }
}

/// Returns the ranges of fields of scenarios.
fn scenario_ranges() -> Vec<FieldRange> {
    field_ranges! {
        Scenario {
            name: Pattern(name_pattern()),
            duration_s: Positive,
            start_joint_position: Items(1, MAX_JOINTS),
            contacts: Items(0, 100),
            obstacle_motions: Items(0, MAX_OBSTACLES),
            target_programs: Items(0, 100),
            substeps: Between(1.0, 1000.0),
        }
        VelocityLoop { lag_s: NotNegative, delay_periods: UpTo(10_000) }
        Contact { normal: Items(3, 3), radius_m: Positive, stiffness: NotNegative, damping: NotNegative, inertia: NotNegative }
        Edge { direction: Items(3, 3), depth_m: Positive }
        Hole { center: Items(3, 3), clearance_m: Positive, depth_m: Positive }
        Hinge { inertia: NotNegative, damping: NotNegative, friction: NotNegative }
        TargetProgram as TargetProgram::ForceAlongMotion { start_direction: Items(3, 3), memory_m: Positive }
        TargetProgram as TargetProgram::SpiralSearch { pitch_m: Positive, speed: Positive, inserted_m: Positive }
        Friction { coulomb: NotNegative, viscous: NotNegative, sticking_speed_m_s: Positive }
        Sensors { wrench_filter_s: NotNegative }
        Sensor { noise: NotNegative, quantum: NotNegative }
        Faults {
            dropped: Between(0.0, 1.0),
            late: Between(0.0, 1.0),
            late_periods: UpTo(10_000),
            repeated: Between(0.0, 1.0),
            reordered: Between(0.0, 1.0),
            outages: Items(0, 100),
        }
        Outage { start_s: Positive, duration_s: NotNegative }
    }
}

/// Returns the ranges of fields of answers.
fn answer_ranges() -> Vec<FieldRange> {
    field_ranges! {
        wire::BatchAnswer { items: Items(0, MAX_ITEMS) }
        wire::TaskOutcome { residual_norm: NotNegative, rank: UpTo(MAX_ROWS), scale: Between(0.0, 1.0) }
        wire::ActiveRow { row: UpTo(MAX_ROWS), multiplier: NotNegative }
        wire::SolverReport { kkt_residual: NotNegative }
        wire::SolverLevel { clarabel_residual: NotNegative, residual: NotNegative }
        wire::CertificatePart { weight: Between(0.0, 1.0) }
        wire::Singularity { smallest_singular_value: NotNegative, manipulability: NotNegative }
        wire::ResolveAnswer { elapsed_us: NotNegative, joint_limit_index: NotNegative }
        wire::StepAnswer { stop_time_s: Positive, elapsed_us: NotNegative, joint_limit_index: NotNegative }
        wire::TareAnswer { force_noise_n: NotNegative, torque_noise_nm: NotNegative }
        wire::PayloadAnswer {
            mass_uncertainty_kg: NotNegative,
            center_of_mass_uncertainty_m: NotNegative,
            force_residual_n: NotNegative,
            torque_residual_nm: NotNegative,
            condition: Between(0.0, 8.0),
        }
        wire::StabilityAnswer {
            spectral_radius: NotNegative,
            largest_lag_s: NotNegative,
            smallest_damping: NotNegative,
            largest_damping: NotNegative,
        }
        wire::KinematicsAnswer {
            jacobian: Rows([6, 6], [1, MAX_JOINTS]),
            singular_values: NotNegative,
            manipulability: NotNegative,
        }
        wire::RobotJoint {
            velocity_limit: NotNegative,
            acceleration_limit: NotNegative,
            jerk_limit: NotNegative,
            position_limit: Items(2, 2),
            published_range: Items(2, 2),
        }
        wire::Simulation { progress: Between(0.0, 1.0) }
        wire::Problem { status: Between(400.0, 599.0) }
    }
}

/// Adds all ranges.
pub fn complete(document: &mut Value) {
    let request_schemas = request_schemas(document);
    let Some(schemas) = document["components"]["schemas"].as_object_mut() else { return };
    for (name, schema) in schemas.iter_mut() {
        visit(schema, &mut bound_whole_numbers);
        if request_schemas.contains(name) {
            let most = if OF_CONTACTS.contains(&name.as_str()) { MAX_REMEMBERED } else { MAX_MAGNITUDE };
            visit(schema, &mut |schema| bound_numbers(schema, most));
        }
        if name.starts_with(PER_AXIS) {
            variants(schema).for_each(|variant| bound_items(variant, 1, MAX_ROWS));
        }
    }
    let ranges = [
        request_ranges(),
        scenario_ranges(),
        sensor_ranges(),
        law_ranges(),
        memory_ranges(),
        target_ranges(),
        answer_ranges(),
    ];
    for FieldRange { schema, field, range } in ranges.into_iter().flatten() {
        let Some(schema) = schemas.get_mut(&schema) else { panic!("the document has no schema {schema}") };
        let mut count = 0;
        for_each_field(schema, field, &mut |field| {
            apply(field, &range);
            count += 1;
        });
        assert!(count > 0, "the schema has no field {field}");
    }
    let joints = &mut schemas[&schema_name::<wire::JointVector>()]["oneOf"];
    bound_items(&mut joints[0], 1, MAX_JOINTS);
    joints[1]["minProperties"] = json!(1);
    joints[1]["maxProperties"] = json!(MAX_JOINTS);
}

/// Start of the names of the schemas of `wire::PerAxis`.
const PER_AXIS: &str = "PerAxis";

/// Calls `act` with the schema of a field, in the schema itself and in each variant that has the field.
fn for_each_field(schema: &mut Value, field: &str, act: &mut impl FnMut(&mut Value)) {
    let pointer = format!("/properties/{field}");
    schema.pointer_mut(&pointer).map(&mut *act);
    variants(schema).filter_map(|variant| variant.pointer_mut(&pointer)).for_each(act);
}

/// Returns the names of all schemas in the bodies of requests.
fn request_schemas(document: &Value) -> BTreeSet<String> {
    let operations = document["paths"].as_object().into_iter().flatten().filter_map(|(_, item)| item.as_object());
    let mut names = BTreeSet::new();
    for (_, operation) in operations.flatten() {
        references(&document["components"]["schemas"], &operation["requestBody"], &mut names);
    }
    names
}

/// Bounds whole numbers: they are counts, and exact in the double-precision numbers of every client.
fn bound_whole_numbers(schema: &mut Value) {
    if has_type(schema, "integer") {
        schema["minimum"] = json!(0);
        let max = if schema["format"] == "int32" { i32::MAX.unsigned_abs().into() } else { MAX_SEQUENCE };
        schema["maximum"] = json!(max);
    }
}

/// Schemas of what contact laws remember.
const OF_CONTACTS: [&str; 3] = ["ContactMemory", "MeasuredContact", "NormalMemory"];

/// Bounds the numbers of requests.
fn bound_numbers(schema: &mut Value, most: f64) {
    if has_type(schema, "number") {
        schema["minimum"] = json!(-most);
        schema["maximum"] = json!(most);
    }
}

fn has_type(schema: &Value, name: &str) -> bool {
    schema["type"] == name || schema["type"].as_array().is_some_and(|types| types.iter().any(|known| known == name))
}

fn apply(schema: &mut Value, range: &Range) {
    match range {
        Positive => set_bounds(schema, &[("exclusiveMinimum", json!(0))]),
        PositiveUpTo(max) => set_bounds(schema, &[("exclusiveMinimum", json!(0)), ("maximum", json!(max))]),
        NotNegative => set_bounds(schema, &[("minimum", json!(0))]),
        Between(min, max) => set_bounds(schema, &[("minimum", json!(min)), ("maximum", json!(max))]),
        UpTo(max) => set_bounds(schema, &[("minimum", json!(0)), ("maximum", json!(max))]),
        Items(min, max) => bound_items(schema, *min, *max),
        UniqueItems(min, max) => {
            bound_items(schema, *min, *max);
            schema["uniqueItems"] = json!(true);
        }
        Rows(rows, columns) => {
            bound_items(schema, rows[0], rows[1]);
            bound_items(&mut schema["items"], columns[0], columns[1]);
        }
        Pattern(pattern) => schema["pattern"] = json!(pattern),
    }
}

/// Bounds a number, the items of a list, or both for a value per axis.
fn set_bounds(schema: &mut Value, bounds: &[(&str, Value)]) {
    // A field that may be absent is null or one of the others.
    variants(schema).for_each(|option| set_bounds(option, bounds));
    let is_per_axis = schema["$ref"].as_str().is_some_and(|link| link.contains(PER_AXIS));
    if is_per_axis || has_type(schema, "number") || has_type(schema, "integer") {
        for (key, bound) in bounds {
            if *key == "exclusiveMinimum" {
                schema.as_object_mut().map(|fields| fields.remove("minimum"));
            }
            schema[*key] = bound.clone();
        }
    }
    if is_per_axis {
        schema["items"] = bounds.iter().map(|(key, bound)| ((*key).to_owned(), bound.clone())).collect();
    } else if has_type(schema, "array") {
        set_bounds(&mut schema["items"], bounds);
    }
}

fn bound_items(schema: &mut Value, min: usize, max: usize) {
    if has_type(schema, "array") {
        schema["minItems"] = json!(min);
        schema["maxItems"] = json!(max);
    }
}
