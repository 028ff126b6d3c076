use nalgebra::{IsometryMatrix3, Vector3};
use proptest::prelude::*;

use super::*;
use crate::{JointKind, LimitOverride, ModelError, Overrides, RobotModel, TipReason, VelocityEnvelope};

mod arms;
mod trees;

const REVOLUTE: &str = r#"type="revolute"><limit lower="-1" upper="2" velocity="3"/>"#;

fn joint(name: &str, parent: &str, child: &str, rest: &str) -> String {
    format!(r#"<joint name="{name}" {rest}<parent link="{parent}"/><child link="{child}"/></joint>"#)
}

fn robot(links: &str, joints: &[String]) -> String {
    let links = links.split_whitespace().map(|name| format!(r#"<link name="{name}"/>"#)).collect::<Vec<_>>().concat();
    format!(r#"<robot name="r">{links}{}</robot>"#, joints.concat())
}

fn read(text: &str) -> Result<RobotModel, UrdfError> {
    RobotModel::from_urdf(text, &UrdfOptions::default())
}

fn between(text: &str, base: &str, tip: &str) -> Result<RobotModel, UrdfError> {
    RobotModel::from_urdf(text, &UrdfOptions { base: Some(base), tip: Some(tip), ..UrdfOptions::default() })
}

/// One joint `j` between `a` and `b`.
fn one(rest: &str) -> Result<RobotModel, UrdfError> {
    read(&robot("a b", &[joint("j", "a", "b", rest)]))
}

fn message(result: Result<RobotModel, UrdfError>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn fixed_revolute_continuous_and_prismatic_joints_make_a_chain() {
    let text = robot(
        "a b c d e",
        &[
            joint("fixed", "a", "b", r#"type="fixed"><origin xyz="1 2 3"/>"#),
            joint("turn", "b", "c", REVOLUTE),
            joint("spin", "c", "d", r#"type="continuous"><axis xyz="0 0 2"/><origin xyz="0 0 1"/>"#),
            joint("slide", "d", "e", r#"type="prismatic"><limit lower="0" upper="0.5" velocity="0.1"/>"#),
        ],
    );
    let robot = read(&text).unwrap();
    let names: Vec<&str> = robot.joints().iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!((robot.name(), &names[..]), ("r", &["turn", "spin", "slide"][..]));
    assert_eq!(robot.description(), "3 joints from link `a` to link `e`, URDF");
    assert_eq!(robot.joints()[0].placement.translation.vector, Vector3::new(1.0, 2.0, 3.0));
    let limits = |i: usize| robot.joints()[i].limits;
    assert_eq!((limits(0).lower, limits(0).upper, limits(0).velocity), (-1.0, 2.0, 3.0));
    assert_eq!(limits(1), super::super::JointLimits::NONE);
    assert_eq!((robot.joints()[2].kind, limits(2).upper), (JointKind::Prismatic, 0.5));
}

#[test]
fn an_axis_of_the_frame_is_placed_without_rounding() {
    let placement = |axis: &str| {
        let robot = one(&format!(r#"type="continuous"><axis xyz="{axis}"/>"#)).unwrap();
        (robot.joints()[0].placement.rotation, robot.tool().rotation)
    };
    assert_eq!(placement("0 0 1").0.matrix(), &nalgebra::Matrix3::identity());
    for (axis, direction) in [
        ("1 0 0", Vector3::x()),
        ("0 1 0", Vector3::y()),
        ("-3 0 0", -Vector3::x()),
        ("0 -1 0", -Vector3::y()),
        ("0 0 -1", -Vector3::z()),
    ] {
        let (before, after) = placement(axis);
        assert_eq!(before * Vector3::z(), direction, "{axis}");
        assert_eq!((before * after).matrix(), &nalgebra::Matrix3::identity(), "{axis}");
        assert_eq!(before.matrix().determinant(), 1.0, "{axis}");
    }
    let (oblique, back) = placement("1 -2 0.5");
    assert!((oblique * Vector3::z() - Vector3::new(1.0, -2.0, 0.5).normalize()).norm() < 1e-15);
    assert!((oblique * back).matrix().relative_eq(&nalgebra::Matrix3::identity(), 1e-15, 1e-15));
}

#[test]
fn acceleration_is_the_smaller_of_both_directions() {
    let limit = |more: &str| {
        let rest = format!(r#"type="revolute"><limit lower="-1" upper="1" velocity="2" {more}/>"#);
        one(&rest).unwrap().joints()[0].limits.acceleration
    };
    assert_eq!(limit(""), f64::INFINITY);
    assert_eq!(limit(r#"acceleration="8""#), 8.0);
    assert_eq!(limit(r#"acceleration="8" deceleration="5""#), 5.0);
}

#[test]
fn velocity_limits_near_the_ends_are_read() {
    let envelope = |attributes: &str| {
        let limits = r#"<limit lower="-1" upper="2" velocity="3"/><position_based_velocity_limits "#;
        one(&format!(r#"type="revolute">{limits}{attributes}/>"#)).map(|robot| robot.joints()[0].limits.envelope)
    };
    let stated = envelope(r#"velocity_offset="0.2" deceleration_limit="2.585""#).unwrap();
    assert_eq!(stated, VelocityEnvelope { deceleration: 2.585, offset: 0.2 });
    assert_eq!(one(REVOLUTE).unwrap().joints()[0].limits.envelope, VelocityEnvelope::NONE);
    for (wrong, cause) in [
        (r#"deceleration_limit="6""#, "needs `deceleration_limit` and `velocity_offset`"),
        (r#"deceleration_limit="0" velocity_offset="0.1""#, "deceleration 0, which must be positive"),
        (r#"deceleration_limit="6" velocity_offset="-0.1""#, "offset -0.1, which must not be negative"),
        (r#"deceleration_limit="6" velocity_offset="inf""#, "velocity_offset"),
        (r#"deceleration_limit="six" velocity_offset="1""#, "deceleration_limit"),
        (r#"deceleration_limit="1" velocity_offset="2""#, "no motion nearer than 2 to its ends"),
    ] {
        let error = envelope(wrong).unwrap_err().to_string();
        assert!(error.contains("`j`") && error.contains(cause), "{error}");
    }
}

#[test]
fn jerk_is_read_and_must_be_positive() {
    let limit = |more: &str| {
        let rest = format!(r#"type="revolute"><limit lower="-1" upper="1" velocity="2" {more}/>"#);
        one(&rest).map(|robot| robot.joints()[0].limits.jerk)
    };
    assert_eq!((limit("").unwrap(), limit(r#"jerk="90""#).unwrap()), (f64::INFINITY, 90.0));
    let error = limit(r#"jerk="0""#).unwrap_err().to_string();
    assert!(error.contains("the jerk limit 0 is not positive"), "{error}");
}

#[test]
fn the_named_tip_selects_the_chain_and_branches_are_ignored() {
    let text = robot(
        "base arm hand camera finger",
        &[
            joint("shoulder", "base", "arm", REVOLUTE),
            joint("wrist", "arm", "hand", REVOLUTE),
            joint("pan", "arm", "camera", r#"type="floating">"#),
            joint("grip", "hand", "finger", r#"type="prismatic"><mimic joint="wrist"/>"#),
        ],
    );
    let two = between(&text, "base", "hand").unwrap();
    let left_out: Vec<_> = two.selection().unwrap().left_out.iter().map(|joint| joint.joint.as_str()).collect();
    assert_eq!((two.joint_count(), left_out), (2, vec!["pan", "grip"]));
    assert_eq!(two.selection().unwrap().reason, TipReason::Request);
    assert_eq!(between(&text, "arm", "hand").unwrap().joint_count(), 1);
    assert_eq!(read(&text).unwrap().selection().unwrap().tip, "hand");
    assert!(message(between(&text, "base", "camera")).contains("joint `pan` of the chain is floating"));
    assert!(message(between(&text, "base", "finger")).contains("joint `grip` of the chain is mimic"));
    assert!(message(between(&text, "base", "foot")).contains("to a link `foot`; chains from there end at `camera`"));
    assert!(message(between(&text, "camera", "hand")).contains("no chain leads from `camera` to a link `hand`"));
    assert!(message(between(&text, "foot", "hand")).contains("base link `foot` does not exist"));
    assert_eq!(between(&text, "base", "base").unwrap_err(), UrdfError::Model(ModelError::NoJoints));
}

fn with(text: &str, overrides: &Overrides) -> Result<RobotModel, UrdfError> {
    RobotModel::from_urdf(text, &UrdfOptions { overrides: Some(overrides), ..UrdfOptions::default() })
}

#[test]
fn overrides_replace_and_complete_the_text() {
    let text = robot("a b", &[joint("j", "a", "b", r#"type="revolute"><limit lower="-1" upper="1" velocity="0"/>"#)]);
    let limit = |limit: LimitOverride| Overrides { limits: [("j".to_owned(), limit)].into(), ..Overrides::default() };
    let limits = |stated| with(&text, &limit(stated)).map(|robot| robot.joints()[0].limits);
    let mended = limits(LimitOverride { velocity: Some(2.0), ..LimitOverride::default() }).unwrap();
    assert_eq!((mended.lower, mended.upper, mended.velocity), (-1.0, 1.0, 2.0));
    assert!(mended.acceleration.is_infinite());
    let envelope = VelocityEnvelope { deceleration: 2.0, offset: 0.1 };
    let all = LimitOverride {
        position: Some([-0.5, 0.5]),
        velocity: Some(3.0),
        acceleration: Some(4.0),
        jerk: Some(90.0),
        envelope: Some(envelope),
    };
    let all = limits(all).unwrap();
    assert_eq!((all.lower, all.upper, all.velocity), (-0.5, 0.5, 3.0));
    assert_eq!((all.acceleration, all.jerk, all.envelope), (4.0, 90.0, envelope));
    for bad in [f64::NAN, 0.0, -1.0] {
        assert!(limits(LimitOverride { velocity: Some(bad), ..LimitOverride::default() }).is_err(), "{bad}");
    }

    let spin = robot("a b", &[joint("j", "a", "b", r#"type="continuous">"#)]);
    let bounded = LimitOverride { position: Some([-9.0, 9.0]), ..LimitOverride::default() };
    assert_eq!(with(&spin, &limit(bounded)).unwrap().joints()[0].limits.upper, 9.0);
    let tool_offset = Some(IsometryMatrix3::translation(0.0, 0.0, 0.25));
    let names = [("j".to_owned(), "spin".to_owned())].into();
    let named = with(&spin, &Overrides { joint_names: names, tool_offset, ..Overrides::default() }).unwrap();
    assert_eq!(named.joints()[0].name, "spin");
    let moved = named.tool().translation.vector - read(&spin).unwrap().tool().translation.vector;
    assert!((moved.norm() - 0.25).abs() < 1e-15);

    let unknown = Overrides { joint_names: [("k".to_owned(), "l".to_owned())].into(), ..Overrides::default() };
    let error = with(&spin, &unknown).unwrap_err().to_string();
    assert_eq!(error, "`joint_names` has a joint `k`, which is no joint of the chain; its joints are `j`");
    let empty = Overrides { joint_names: [("j".to_owned(), String::new())].into(), ..Overrides::default() };
    assert_eq!(with(&spin, &empty).unwrap_err(), UrdfError::JointName { joint: "j".to_owned() });
}

#[test]
fn joints_of_unsupported_types_are_refused_with_their_type() {
    for kind in ["floating", "planar", "spherical", "hinge"] {
        assert!(message(one(&format!(r#"type="{kind}">"#))).contains(&format!("joint `j` of the chain is {kind}")));
    }
    let remedy = |kind: &str| message(one(&format!(r#"type="{kind}">"#)));
    assert!(remedy("planar").contains("Replace it by two prismatic joints and a continuous one"));
    assert!(!remedy("revolut").contains("tips"), "`tips` does not help");
    assert!(message(one(">")).contains("joint `j` needs a type"));
}

#[test]
fn links_that_are_not_a_tree_are_refused() {
    let cycle = [joint("j", "a", "b", REVOLUTE), joint("k", "b", "a", REVOLUTE)];
    assert_eq!(read(&robot("a b", &cycle)).unwrap_err(), UrdfError::Model(ModelError::Cycle { link: "a".to_owned() }));
    assert!(matches!(between(&robot("c a b", &cycle), "c", "a"), Err(UrdfError::Model(ModelError::Cycle { .. }))));
    assert_eq!(between(&robot("a b", &cycle), "a", "b").unwrap().joint_count(), 1);
    let diamond = [joint("j", "a", "b", REVOLUTE), joint("k", "a", "b", REVOLUTE)];
    assert!(message(read(&robot("a b", &diamond))).contains("link `b` is the child of the joints `j` and `k`"));
    assert!(message(read(&robot("a b c", &diamond[..1]))).contains("links without parent: `a`, `c`; name the `base`"));
    assert!(message(read(&robot("", &[]))).contains("links without parent: none"));
    assert!(message(read(&robot("a a", &[]))).contains("two links are named `a`"));
    let twice = [joint("j", "a", "b", REVOLUTE), joint("j", "b", "c", REVOLUTE)];
    assert!(message(read(&robot("a b c", &twice))).contains("two joints are named `j`"));
    assert!(message(read(&robot("a", &cycle[..1]))).contains("connects link `b`, which does not exist"));
    assert!(message(read(r#"<robot name="r"><link/></robot>"#)).contains("<link> number 1"));
    assert!(message(read(r#"<robot><link name="a"/><joint name="j"/></robot>"#)).contains("`j` needs <parent"));
}

#[test]
fn invalid_numbers_and_limits_are_named() {
    let limit = |text: &str| message(one(&format!(r#"type="revolute"><limit {text}/>"#)));
    for missing in ["", r#"lower="-1" upper="1""#, r#"upper="1" velocity="1""#, r#"lower="1" velocity="1""#] {
        assert!(limit(missing).contains("joint `j`: <limit> needs `"), "{missing}");
    }
    assert!(message(one(r#"type="prismatic">"#)).contains("joint `j`: <limit> needs `"));
    assert!(
        limit(r#"lower="1" upper="-1" velocity="1""#).contains("joint `j`: the position range from 1 to -1 is empty")
    );
    let still = limit(r#"lower="-1" upper="1" velocity="0""#);
    assert!(
        still.ends_with(r#"velocity limit 0 is not positive; state it in `limits`: {"j": {"velocity": number}}"#),
        "{still}"
    );
    assert!(
        limit(r#"lower="-1" upper="1" velocity="1" acceleration="-1""#)
            .contains("acceleration limit -1 is not positive")
    );
    let two =
        [joint("j", "a", "b", r#"type="prismatic"><limit lower="0" upper="1"/>"#), joint("k", "b", "c", REVOLUTE)];
    let two = [&two[..], &[joint("l", "c", "d", r#"type="revolute"><limit lower="0" upper="2"/>"#)]].concat();
    let both = message(read(&robot("a b c d", &two)));
    let remedy = r#"{"j": {"velocity": number}, "l": {"velocity": number}}"#;
    assert_eq!(both, format!("joint `j`, `l`: <limit> needs `velocity`; state it in `limits`: {remedy}"));
    for number in ["nan", "inf", "-infinity", "1e308", "1e999", "one", "", "1 2", "0x10", "1,5"] {
        let error = limit(&format!(r#"lower="-1" upper="{number}" velocity="1""#));
        assert!(error.contains(&format!("joint `j`: upper=\"{number}\" is not 1 number(s)")), "{error}");
    }
    for xyz in ["0 0", "0 0 0 0", "0 0 nan", "0 0 1e10"] {
        assert!(message(one(&format!(r#"type="fixed"><origin xyz="{xyz}"/>"#))).contains("is not 3 number(s)"));
    }
    for axis in ["0 0 0", "1e-300 0 0"] {
        let error = message(one(&format!(r#"type="continuous"><axis xyz="{axis}"/>"#)));
        assert!(error.contains("joint `j`: the axis has length zero"), "{error}");
    }
    assert!(message(one(r#"type="fixed"><origin quat_xyzw="0 0 0 1"/>"#)).contains("`quat_xyzw` is not supported"));
}

#[test]
fn xml_that_is_not_a_robot_is_refused() {
    for text in ["", "robot", "<robot>", "<robot></link>", "<robot name='a' name='b'/>", "<robot>&x;</robot>", "\0"] {
        assert!(matches!(read(text), Err(UrdfError::Xml(_))), "{text}");
    }
    assert!(message(read("<sdf/>")).contains("the outermost element is <sdf>"));
    assert!(message(read("<mujoco/>")).contains("`revprio.read_mjcf(FILE)`"));
    let xacro = r#"<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include filename="a"/></robot>"#;
    assert!(message(read(xacro)).contains("<xacro:include>; expand it first"));
}

#[test]
fn entities_are_not_expanded_and_files_are_not_opened() {
    let entity = r#"<!DOCTYPE robot [<!ENTITY a SYSTEM "file:///etc/passwd">]><robot name="&a;"/>"#;
    assert!(message(read(entity)).contains("DTD"));
    let mesh = r#"<link name="a"><visual><geometry><mesh filename="package://none/a.stl"/></geometry></visual></link>"#;
    let text = robot("b", &[mesh.to_owned(), joint("j", "a", "b", REVOLUTE)]);
    assert_eq!(read(&text).unwrap().joint_count(), 1);
}

/// Damages a valid text: cuts pieces out and inserts characters that have a meaning in XML or URDF.
fn any_text() -> impl Strategy<Value = String> {
    const VALID: &str = include_str!("../../../../fixtures/golden/oblique.urdf");
    const PIECES: [&str; 15] = [
        "<", ">", "/>", "\"", "'", "&amp;", "<!--", "]]>", "=", " nan", "-1e9", "<limit/>", "<joint>", "\u{0}", "base",
    ];
    let cut = (0..VALID.len(), 0..40_usize, prop::sample::select(&PIECES[..]));
    prop::collection::vec(cut, 1..4).prop_map(|cuts| {
        cuts.into_iter().fold(VALID.to_owned(), |text, (at, length, piece)| {
            let (at, end) = (at.min(text.len()), (at + length).min(text.len()));
            format!("{}{piece}{}", &text[..at], &text[end..])
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_text_gives_an_error_or_a_valid_robot(text in any_text()) {
        let options = UrdfOptions { tip: Some("tool"), ..UrdfOptions::default() };
        for robot in [RobotModel::from_urdf(&text, &options), read(&text)].into_iter().flatten() {
            prop_assert!(robot.joint_count() > 0);
            prop_assert!(robot.tool().to_homogeneous().iter().all(|entry| entry.is_finite()));
        }
    }
}

#[test]
fn every_text_is_read_in_bounded_time() {
    let elements = |element: &str| format!("<robot>{}</robot>", element.repeat((1 << 20) / element.len() - 10));
    let deep = 70_000;
    let attributes = (0..90_000).map(|i| format!("a{i:x}='' ")).collect::<Vec<_>>().concat();
    let spaces = (0..5_000).map(|i| format!("<a xmlns:b{i}='c{i}'>")).collect::<Vec<_>>().concat();
    let chain: Vec<String> = (0..8_000).map(|i| format!(r#"<link name="{i}"/>"#)).collect();
    let bush = |parent: &dyn Fn(usize) -> usize| {
        let joint = |i: usize| {
            format!("<joint name='{i}' type='fixed'><parent link='{}'/><child link='{i}'/></joint>", parent(i))
        };
        format!("<robot>{}{}</robot>", chain.concat(), (1..8_000).map(joint).collect::<Vec<_>>().concat())
    };
    let texts = [
        elements("<a/>"),
        elements("<link name='a'/>"),
        elements("<!---->"),
        format!("<robot>{}{}</robot>", "<a>".repeat(deep), "</a>".repeat(deep)),
        format!("<robot {attributes}/>"),
        format!("<robot>{spaces}"),
        " ".repeat(2 << 20),
        bush(&|i| i - 1),
        bush(&|i| i / 2),
        bush(&|i| if i < 4_000 { i - 1 } else { 3_999 }),
    ];
    let start = std::time::Instant::now();
    for text in texts {
        read(&text).unwrap_err();
    }
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
}

#[test]
fn soft_limits_narrow_the_range_where_they_leave_one() {
    let ends = |soft: &str| {
        let element = format!(
            r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
            <limit lower="-2.8" upper="2.5" velocity="2"/><safety_controller k_velocity="10" {soft}/></joint>"#
        );
        let limits = read(&robot("a b", &[element])).unwrap().joints()[0].limits;
        (limits.lower, limits.upper)
    };
    assert_eq!(ends(r#"soft_lower_limit="-2" soft_upper_limit="2.1""#), (-2.0, 2.1));
    assert_eq!(ends(r#"soft_lower_limit="-3" soft_upper_limit="2.1""#), (-2.8, 2.1));
    assert_eq!(ends(r#"soft_upper_limit="2""#), (-2.8, 2.0));
    for none in ["", r#"soft_lower_limit="0" soft_upper_limit="0""#, r#"soft_lower_limit="3" soft_upper_limit="4""#] {
        assert_eq!(ends(none), (-2.8, 2.5), "{none}");
    }
}

#[test]
fn elements_of_other_programs_are_not_those_of_the_robot() {
    let joint = r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/>
        <d:limit xmlns:d="urn:drake" lower="-9" upper="9" velocity="99"/><limit lower="-1" upper="1" velocity="2"/></joint>"#;
    let text = robot("a b", &[joint.to_owned()]);
    assert_eq!(read(&text).unwrap().joints()[0].limits.velocity, 2.0);
    // A namespace of the whole text is its own.
    let whole = text.replacen("<robot", r#"<robot xmlns="http://drake.mit.edu""#, 1);
    assert_eq!(read(&whole).unwrap().joints()[0].limits.velocity, 2.0);
}

#[test]
fn xacro_inside_a_joint_is_refused() {
    let joint = r#"<joint name="j" type="continuous"><parent link="a"/><child link="b"/>
        <xacro:if xmlns:xacro="http://www.ros.org/wiki/xacro" value="true"><origin xyz="0.4 0 0"/></xacro:if></joint>"#;
    assert!(matches!(read(&robot("a b", &[joint.to_owned()])), Err(UrdfError::Xacro { .. })));
}
