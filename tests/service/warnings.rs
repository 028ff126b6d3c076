//! Warnings about control loops that are unstable in the stated environment or in free space.

use serde_json::{Value, json};

use crate::harness::{Service, example, without};
use crate::robots::{CRANK, registration};

/// Returns the example controller at a wall of 10⁵ N/m along x, with a lag.
fn at_the_wall(lag_s: f64) -> Value {
    let mut controller = example("controller.json");
    controller["environment"] = json!({"x": {"stiffness": 1e5}, "lag_s": lag_s});
    controller["method"] = json!("strict_reverse_priority");
    controller
}

fn warnings(service: &Service, controller: &Value) -> Vec<String> {
    let created = service.call("/v1/controllers", controller);
    created["warnings"].as_array().unwrap().iter().map(|warning| warning.as_str().unwrap().to_owned()).collect()
}

#[test]
fn a_warning_names_the_unstable_axis_and_the_margins() {
    let service = Service::start();
    let warnings = warnings(&service, &at_the_wall(0.005));
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let margin = service.call("/v1/stability", &example("stability.json"));
    let radius = format!("{:.6}", margin["spectral_radius"].as_f64().unwrap());
    for part in ["task `push`, axis x: ", "unstable", &radius, "lag 1.498 ms", "at least 500.5 N·s/m"] {
        assert!(warnings[0].contains(part), "`{part}` is not in {}", warnings[0]);
    }
}

#[test]
fn a_controller_that_is_stable_or_without_environment_has_no_warning() {
    let service = Service::start();
    assert_eq!(warnings(&service, &at_the_wall(0.001)), [""; 0]);
    assert_eq!(warnings(&service, &example("controller.json")), [""; 0]);
    let mut elsewhere = at_the_wall(0.005);
    elsewhere["environment"] = json!({"lag_s": 0.005});
    assert_eq!(warnings(&service, &elsewhere), [""; 0]);
}

/// Nobody measures the lag of an arm twice: what the drive states need not be said of the environment again.
#[test]
fn a_stated_drive_counts_for_the_contact() {
    let service = Service::start();
    let mut controller = at_the_wall(0.0);
    assert_eq!(warnings(&service, &controller), [""; 0]);
    controller["drive"] = json!({"lag_s": 0.005, "delay_periods": 0});
    assert_eq!(warnings(&service, &controller), warnings(&service, &at_the_wall(0.005)));
    controller["drive"] = json!({"lag_s": 0.0, "delay_periods": 4});
    let delayed = warnings(&service, &controller);
    assert!(delayed.len() == 1 && delayed[0].contains("admissible delay"), "{delayed:?}");
}

#[test]
fn the_first_task_on_an_axis_counts() {
    let service = Service::start();
    let mut controller = at_the_wall(0.005);
    let still = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": [0.0]}});
    controller["tasks"].as_array_mut().unwrap().insert(0, json!({"name": "still", "axes": ["x"], "law": still}));
    assert_eq!(warnings(&service, &controller), [""; 0]);
}

#[test]
fn a_task_with_bounds_on_an_axis_does_not_count() {
    let service = Service::start();
    let mut controller = at_the_wall(0.005);
    let before = warnings(&service, &controller);
    let slow = json!({"name": "slow", "axes": ["x"], "upper": [0.1]});
    controller["tasks"].as_array_mut().unwrap().insert(0, slow);
    assert!(!before.is_empty());
    assert_eq!(warnings(&service, &controller), before);
}

#[test]
fn the_environment_is_shown_and_does_not_change_commands() {
    let service = Service::start();
    let controller = at_the_wall(0.005);
    let session = service.open(&controller);
    let shown = service.get(&session).accepted();
    assert_eq!(shown["controller"]["environment"]["x"]["stiffness"], json!(1e5));
    let plain = service.open(&example("controller.json"));
    let step = |session: &str| service.call(&format!("{session}/step"), &example("state.json"));
    assert_eq!(without(step(&session), &["elapsed_us"]), without(step(&plain), &["elapsed_us"]));
    let mut stateless = example("step.json");
    let answer = |request: &Value| without(service.call("/v1/step", request), &["elapsed_us"]);
    let before = answer(&stateless);
    stateless["controller"]["environment"] = controller["environment"].clone();
    assert_eq!(answer(&stateless), before);
}

/// Returns a controller with one law on all linear axes, and a drive, if it is stated.
fn in_free_space(law: &Value, period_s: f64, drive: Option<Value>) -> Value {
    let tasks = json!([{"name": "yield", "axes": ["x", "y", "z"], "law": law}]);
    let mut controller = json!({"robot": "panda", "period_s": period_s, "tasks": tasks});
    if let Some(drive) = drive {
        controller["drive"] = drive;
    }
    controller
}

fn force(inertia: f64, damping: f64) -> Value {
    json!({"kind": "force", "inertia": inertia, "damping": damping, "target_force": {"kind": "constant", "value": 0.0}})
}

fn impedance(inertia: f64, damping: f64, stiffness: f64) -> Value {
    json!({"kind": "impedance", "inertia": inertia, "damping": damping, "stiffness": stiffness})
}

fn ideal() -> Value {
    json!({"lag_s": 0.0, "delay_periods": 0})
}

#[test]
fn laws_that_are_unstable_in_free_space_are_named() {
    let service = Service::start();
    let cases = [
        // Measured: up to 53.5 M_d, commanded: up to 200 M_d.
        (
            in_free_space(&force(15.0, 1000.0), 0.01, None),
            ["stable if not; damping above 0 and up to 80", "larger inertia"],
        ),
        (in_free_space(&force(15.0, 4000.0), 0.01, None), ["spectral radius 1.666667 if not", "up to 80"]),
        (
            in_free_space(&force(15.0, 0.0), 0.01, None),
            ["spectral radius 1.000000 if not", "damping above 0 and up to 80"],
        ),
        (
            in_free_space(&impedance(5.0, 632.0, 20_000.0), 0.001, None),
            ["spectral radius 1.003495 if states contain `joint_velocity`, stable if not", "a smaller stiffness"],
        ),
        (
            in_free_space(&impedance(1.0, 2000.0, 1e6), 0.001, Some(ideal())),
            ["spectral radius 1.618034 if not", "damping above 0 and up to 1"],
        ),
    ];
    for (controller, parts) in cases {
        let found = warnings(&service, &controller);
        assert_eq!(found.len(), 1, "{controller}: {found:?}");
        for part in ["task `yield`, axis x: ", "in free space"].iter().chain(&parts) {
            assert!(found[0].contains(part), "`{part}` is not in {}", found[0]);
        }
    }
}

#[test]
fn laws_that_are_stable_in_free_space_have_no_warning() {
    let service = Service::start();
    for (law, period_s, drive) in [
        (force(15.0, 1000.0), 0.001, None),
        (force(15.0, 1000.0), 0.01, Some(ideal())),
        (force(15.0, 790.0), 0.01, None),
        (impedance(5.0, 632.0, 20_000.0), 0.001, Some(ideal())),
        (impedance(10.0, 200.0, 500.0), 0.001, None),
    ] {
        assert_eq!(warnings(&service, &in_free_space(&law, period_s, drive)), [""; 0], "{law}");
    }
}

#[test]
fn the_recommended_damping_is_stable_and_a_larger_one_is_not() {
    let service = Service::start();
    for law in [force(15.0, 1e4), impedance(10.0, 0.0, 200.0)] {
        let with = |damping: f64| {
            let mut law = law.clone();
            law["damping"] = json!(damping);
            warnings(&service, &in_free_space(&law, 0.01, None))
        };
        let warning = warnings(&service, &in_free_space(&law, 0.01, None)).remove(0);
        let (_, range) = warning.split_once("damping above ").unwrap();
        let (low, rest) = range.split_once(" and up to ").unwrap();
        let (low, high): (f64, f64) = (low.parse().unwrap(), rest.split(' ').next().unwrap().parse().unwrap());
        assert_eq!(with(high), [""; 0]);
        assert_eq!(with(1.002 * high).len(), 1);
        if low > 0.0 {
            assert_eq!(with(low), [""; 0]);
            assert_eq!(with(0.998 * low).len(), 1);
        }
    }
}

#[test]
fn a_contact_with_too_much_damping_is_told_the_largest_one() {
    let service = Service::start();
    let mut controller = at_the_wall(0.005);
    controller["drive"] = ideal();
    for task in controller["tasks"].as_array_mut().unwrap() {
        if task["law"]["damping"].is_number() || task["law"]["damping"].is_array() {
            task["law"]["damping"] = json!(5e6);
        }
    }
    let found = warnings(&service, &controller);
    assert!(found[0].contains("damping of at most "), "{found:?}");
}

/// Returns the example controller with a pose law in place of its second law.
fn with_pose_law(law: Value) -> Value {
    let mut controller = example("controller.json");
    controller["tasks"][1]["law"] = law;
    controller
}

#[test]
fn a_gain_that_demands_more_deceleration_than_a_joint_has_is_named() {
    let service = Service::start();
    let warnings_for = |law| warnings(&service, &with_pose_law(law));
    // The last joint of Sawyer: 10 rad/s² over 4.545 rad/s.
    assert_eq!(warnings_for(json!({"kind": "pose", "gain": 2.2})), [""; 0]);
    let braking = warnings_for(json!({"kind": "pose", "gain": 5}));
    let bare = warnings_for(json!({"kind": "pose", "gain": 5, "braking": false}));
    for (found, consequence) in [(&braking, "the law brakes"), (&bare, "may pass its target")] {
        assert_eq!(found.len(), 1, "{found:?}");
        for part in ["task `hold`", "gain 5 1/s", "2.20 1/s", "`j7`", consequence] {
            assert!(found[0].contains(part), "`{part}` is not in {}", found[0]);
        }
    }
}

#[test]
fn braking_slows_down_a_distant_pose_and_the_bare_gain_does_not() {
    let service = Service::start();
    let speed = |law: Value| {
        let mut step = example("step.json");
        step["controller"]["tasks"][1]["law"] = law;
        step["controller"]["tasks"][1]["law"]["target_displacement"] =
            json!({"kind": "constant", "value": [0.3, 0, 0, 0, 0]});
        service.call("/v1/step", &step)["tasks"][1]["requested"][0].as_f64().unwrap()
    };
    let bare = speed(json!({"kind": "pose", "gain": 10, "braking": false}));
    let braked = speed(json!({"kind": "pose", "gain": 10}));
    let gentle = speed(json!({"kind": "pose", "gain": 10, "max_acceleration": 0.1}));
    assert!((bare - 3.0).abs() < 1e-9, "{bare}");
    assert!(gentle > 0.0 && gentle < 0.25 && braked > gentle && braked < 2.0, "{gentle} {braked}");
}

/// A small arm on a rail of 4 m. Its linear rows have the size one, whatever the arm is like.
const SLIDING: &str = r#"<robot name="sliding"><link name="base"/><link name="car"/><link name="arm"/><link name="tool"/>
    <joint name="slide" type="prismatic"><parent link="base"/><child link="car"/><axis xyz="1 0 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
    <joint name="turn" type="revolute"><parent link="car"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
    <joint name="hand" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="0.05 0 0"/></joint></robot>"#;

#[test]
fn no_length_is_advised_where_joints_slide() {
    let service = Service::start();
    service.post("/v1/robots", &registration("sliding", SLIDING).to_string()).accepted();
    let law = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": [0.01]}});
    let tasks = json!([{"name": "pull", "axes": ["y"], "law": law}]);
    let controller = json!({"robot": "sliding", "period_s": 0.01, "limits": "none", "tasks": tasks});
    assert_eq!(warnings(&service, &controller), [""; 0]);
}

#[test]
fn the_length_that_suits_a_small_arm_is_named_and_accepted() {
    let service = Service::start();
    let small = CRANK.replace("xyz=\"2 0 0\"", "xyz=\"0.05 0 0\"");
    service.post("/v1/robots", &registration("small", &small).to_string()).accepted();
    let law = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": [0.01]}});
    let mut controller = json!({"robot": "small", "period_s": 0.01, "limits": "none", "tasks": [{"name": "pull", "axes": ["y"], "law": law}]});
    let velocity = |controller: &Value| {
        let state = json!({"sequence": 0, "time_s": 0.0, "joint_position": [0.0]});
        service.call(&format!("{}/step", service.open(controller)), &state)["joint_velocity"][0].as_f64().unwrap()
    };
    let found = warnings(&service, &controller);
    assert!(found.len() == 1 && found[0].contains("set `characteristic_length_m` to 0.05"), "{found:?}");
    let damped = velocity(&controller);
    controller["characteristic_length_m"] = json!(0.05);
    assert_eq!(warnings(&service, &controller), [""; 0]);
    let exact = velocity(&controller);
    assert!(damped < 0.05 && (exact - 0.2).abs() < 1e-12, "{damped} and {exact} rad/s of the 0.2 rad/s for 1 cm/s");
    for length in [json!(0.0), json!(1e4), json!("long")] {
        controller["characteristic_length_m"] = length;
        service.post("/v1/controllers", &controller.to_string()).assert_refused(422, Some("/characteristic_length_m"));
    }
}

#[test]
fn bounds_without_rest_and_answers_that_expire_too_early_are_told() {
    let service = Service::start();
    let with = |field: &str, value: Value| {
        let mut controller = example("controller.json");
        controller[field] = value;
        warnings(&service, &controller).join("\n")
    };
    assert_eq!(with("valid_for_ms", json!(2)), "");
    assert!(with("valid_for_ms", json!(1)).contains("set `valid_for_ms` to 2 or more"));
    assert!(with("period_s", json!(0.2)).contains("set `valid_for_ms` to 400 or more"));
    let bounds = |lower: f64| json!({"lower": vec![lower; 7], "upper": vec![0.5; 7]});
    assert!(with("limits", bounds(0.1)).contains("never stands still"));
    assert_eq!(with("limits", bounds(0.0)), "");
}

#[test]
fn a_description_in_millimetres_and_degrees_is_named() {
    let service = Service::start();
    let of = |name: &str, urdf: &str| {
        service.post("/v1/robots", &registration(name, urdf).to_string()).accepted();
        let law = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": [0.5]}});
        let task = json!({"name": "pull", "axes": ["y"], "law": law});
        warnings(&service, &json!({"robot": name, "period_s": 0.01, "tasks": [task]})).join("\n")
    };
    assert!(!of("right", CRANK).contains(" in "));
    assert_eq!(
        of("millimetres", &CRANK.replace("\"2 0 0\"", "\"2000 0 0\"")),
        "`millimetres` reaches 2000 m; is its description in millimetres?"
    );
    let degrees = of("degrees", &CRANK.replace("lower=\"-3\" upper=\"3\"", "lower=\"-170\" upper=\"170\""));
    assert!(degrees.contains("the range of joint `crank` is -170 to 170 rad; is it in degrees?"), "{degrees}");
    let fast = of("fast", &CRANK.replace("velocity=\"1.5\"", "velocity=\"180\""));
    assert!(fast.contains("the speed limit of joint `crank` is 180 rad/s; is it in degrees per second?"), "{fast}");
    let sliding =
        CRANK.replace("revolute", "prismatic").replace("lower=\"-3\" upper=\"3\"", "lower=\"-200\" upper=\"300\"");
    let sliding = of("sliding", &sliding);
    assert!(sliding.contains("joint `crank` slides from -200 to 300 m"), "{sliding}");
}

#[test]
fn a_gantry_reaches_as_far_as_its_slides() {
    let service = Service::start();
    let slide = |name: &str, parent: &str, axis: &str, most: f64| {
        format!(
            r#"<joint name="{name}" type="prismatic"><parent link="{parent}"/><child link="{name}_link"/><axis xyz="{axis}"/>
               <limit lower="0" upper="{most}" velocity="1" effort="1"/></joint><link name="{name}_link"/>"#
        )
    };
    let joints = [slide("x", "base", "1 0 0", 10.0), slide("y", "x_link", "0 1 0", 4.0)].concat();
    let urdf = format!(r#"<robot name="gantry"><link name="base"/>{joints}</robot>"#);
    service.post("/v1/robots", &registration("gantry", &urdf).to_string()).accepted();
    let controller = |x: f64| {
        let pose = json!({"position": [x, 2.0, 0.0], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}});
        let law = json!({"kind": "pose", "gain": 1, "target_pose": pose});
        json!({"robot": "gantry", "period_s": 0.01, "tasks": [{"name": "go", "axes": ["x", "y"], "law": law}]})
    };
    assert_eq!(warnings(&service, &controller(9.0)), [""; 0]);
    let far = warnings(&service, &controller(9000.0)).join("\n");
    assert!(far.contains("the arm reaches 14.00 m"), "{far}");
}

/// The second link of a Panda turns about a vertical axis and never rises.
#[test]
fn a_plane_that_no_joint_moves_its_point_towards_has_a_warning() {
    let service = Service::start();
    let with_plane = |normal: [f64; 3]| {
        let plane =
            json!({"name": "ceiling", "kind": "plane", "normal": normal, "offset_m": 0.1, "point": "panda_joint2"});
        let mut controller = example("controller.json");
        controller["robot"] = json!("panda");
        controller["inequalities"] = json!([plane]);
        warnings(&service, &controller)
    };
    let idle = |warnings: Vec<String>| warnings.iter().filter(|warning| warning.contains("holds nothing back")).count();
    assert_eq!(idle(with_plane([0.0, 0.0, 1.0])), 1);
    assert_eq!(
        idle(with_plane([0.0, 1e-3, 1.0])),
        1,
        "the point lies on the axis of the only joint that moves its frame"
    );
    let mut hand = example("controller.json");
    hand["inequalities"] = json!([{"name": "front", "kind": "plane", "normal": [1, 0, 0], "offset_m": 5.0}]);
    assert_eq!(idle(warnings(&service, &hand)), 0);
}

/// The tool of a planar arm never rises.
#[test]
fn a_contact_along_an_axis_that_no_joint_moves_has_a_warning() {
    let service = Service::start();
    let pressing = |axis: &str| {
        let law = json!({"kind": "contact", "target_force": {"kind": "constant", "value": 5}});
        let task = json!({"name": "press", "axes": [axis], "law": law});
        let controller = json!({"robot": "planar_3r", "period_s": 0.001, "tasks": [task]});
        let warnings = warnings(&service, &controller);
        warnings.into_iter().filter(|text| text.starts_with(&format!("task `press`, axis {axis}: no joint"))).count()
    };
    assert_eq!(["x", "y", "z", "rx"].map(pressing), [0, 0, 1, 1]);
}

#[test]
fn an_answer_that_is_not_valid_for_a_period_has_advice_that_is_accepted() {
    let service = Service::start();
    let mut controller = example("controller.json");
    controller["period_s"] = json!(6.0);
    controller["valid_for_ms"] = json!(100);
    let advice =
        warnings(&service, &controller).iter().any(|text| text.ends_with("set `valid_for_ms` to 10000 or more"));
    assert!(advice);
    controller["valid_for_ms"] = json!(10_000);
    assert!(!warnings(&service, &controller).iter().any(|text| text.contains("valid_for_ms")));
}

#[test]
fn a_scaled_task_to_which_the_tasks_before_it_leave_no_axis_is_warned_of() {
    let service = Service::start();
    let warned = |tasks: &Value| {
        let controller = json!({"robot": "panda", "period_s": 0.01, "tasks": tasks});
        warnings(&service, &controller).iter().any(|text| text.contains("leave out `scale`"))
    };
    let pose = json!({"name": "go", "axes": ["x", "y", "z"], "law": {"kind": "pose", "gain": 1}, "scale": true});
    let hold = |axes: Value, frame: &str| {
        let law = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": 0}});
        json!({"name": format!("hold {}", axes.as_array().unwrap().len()), "axes": axes, "frame": frame, "law": law})
    };
    let all = json!(["x", "y", "z", "rx", "ry", "rz"]);
    // Three axes of a kind are all of them, in any frame.
    assert!(warned(&json!([hold(all.clone(), "tool"), pose])));
    assert!(warned(&json!([hold(json!(["x", "y"]), "base"), hold(json!(["z"]), "base"), pose])));
    for tasks in [
        json!([pose, hold(all.clone(), "tool")]),
        json!([hold(json!(["rx", "ry", "rz"]), "tool"), pose]),
        json!([hold(json!(["x", "y", "rz"]), "base"), pose]),
        json!([hold(json!(["x", "y"]), "base"), hold(json!(["z"]), "tool"), pose]),
        json!([{"name": "slow", "axes": all, "upper": vec![0.1; 6]}, pose]),
    ] {
        assert!(!warned(&tasks), "{tasks}");
    }
}

/// The values of a posture are in the order of its `joints`, not in that of the robot.
#[test]
fn the_target_of_a_posture_is_compared_with_the_range_of_its_own_joint() {
    let service = Service::start();
    let with = |values: [f64; 2]| {
        let target = json!({"kind": "constant", "value": values});
        let law = json!({"kind": "posture", "joints": ["panda_joint6", "panda_joint4"], "gain": 2, "target_position": target});
        let controller = json!({"robot": "panda", "period_s": 0.004, "tasks": [{"name": "elbow", "law": law}]});
        warnings(&service, &controller)
    };
    assert_eq!(with([3.0, -2.0]), [""; 0]);
    let swapped = with([-2.0, 3.0]);
    assert!(swapped.len() == 2 && swapped[0].contains("`panda_joint6` at -2"), "{swapped:?}");
}

#[test]
fn the_speed_of_a_turning_contact_is_compared_in_its_own_unit() {
    let service = Service::start();
    let with = |axis: &str, speed: f64| {
        let force = json!({"kind": "constant", "value": [1.0]});
        let law = json!({"kind": "contact", "target_force": force, "retreat_speed": speed});
        let controller =
            json!({"robot": "panda", "period_s": 0.004, "tasks": [{"name": "touch", "axes": [axis], "law": law}]});
        warnings(&service, &controller).into_iter().filter(|warning| warning.contains("hits hard")).collect::<Vec<_>>()
    };
    assert_eq!(with("rx", 2.5), [""; 0]);
    assert_eq!(with("z", 2.5), ["task `touch`: a retreat with 2.5 m/s hits hard; speeds are in m/s, not in mm/s"]);
}
