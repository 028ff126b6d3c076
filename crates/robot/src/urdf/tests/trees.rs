//! Trees read from URDF.

use super::*;

fn tree(text: &str) -> Result<RobotModel, UrdfError> {
    RobotModel::from_urdf_tree(text, &UrdfTreeOptions::default())
}

fn names<'a, T: 'a>(items: &'a [T], name: impl Fn(&'a T) -> &'a String) -> Vec<&'a str> {
    items.iter().map(|item| name(item).as_str()).collect()
}

/// A torso that carries two arms of two joints and a gripper on the left one.
fn body() -> String {
    robot(
        "base torso left_upper right_upper left_fore right_fore left_tool right_tool finger thumb",
        &[
            joint("turn", "base", "torso", REVOLUTE),
            joint("left_shoulder", "torso", "left_upper", REVOLUTE),
            joint("right_shoulder", "torso", "right_upper", REVOLUTE),
            joint("left_elbow", "left_upper", "left_fore", r#"type="continuous">"#),
            joint("right_elbow", "right_upper", "right_fore", r#"type="continuous">"#),
            joint("left_mount", "left_fore", "left_tool", r#"type="fixed"><origin xyz="0.1 0 0"/>"#),
            joint("right_mount", "right_fore", "right_tool", r#"type="fixed">"#),
            joint("grip", "left_tool", "finger", r#"type="prismatic"><limit lower="0" upper="0.04" velocity="0.1"/>"#),
            joint("grip_too", "left_tool", "thumb", r#"type="prismatic"><mimic joint="grip" multiplier="-2"/>"#),
        ],
    )
}

#[test]
fn the_whole_tree_is_read_depth_first_with_a_tip_per_arm() {
    let body = tree(&body()).unwrap();
    let own = names(body.joints(), |joint| &joint.name);
    assert_eq!(own, ["turn", "left_shoulder", "left_elbow", "grip", "right_shoulder", "right_elbow"]);
    assert_eq!(names(body.tips(), |tip| &tip.name), ["left_tool", "right_tool"]);
    assert_eq!((body.links().len(), body.moving_joints().len()), (10, 7));
    assert_eq!(body.description(), "7 joints below link `base`, URDF");
    let thumb = &body.moving_joints()[4];
    assert_eq!((thumb.name.as_str(), thumb.coordinate, thumb.multiplier, thumb.offset), ("grip_too", 3, -2.0, 0.0));
    assert_eq!(body.moving_joints()[thumb.parent.unwrap()].name, "left_elbow");
    let parent = |link: &str| body.links()[body.link(link).unwrap().index()].parent.unwrap();
    assert_eq!(body.links()[parent("right_upper").index()].name, "torso");
}

#[test]
fn tips_can_be_named_and_the_first_one_is_the_tool() {
    let offset = IsometryMatrix3::translation(0.0, 0.0, 0.2);
    let tips = [
        UrdfTip { name: "right hand", link: "right_tool", offset },
        UrdfTip { name: "chest", link: "torso", offset: IsometryMatrix3::identity() },
    ];
    let overrides = Overrides { tool_offset: Some(offset), ..Overrides::default() };
    let options = UrdfTreeOptions { tips: &tips, overrides: Some(&overrides), ..UrdfTreeOptions::default() };
    let body = RobotModel::from_urdf_tree(&body(), &options).unwrap();
    assert_eq!(names(body.tips(), |tip| &tip.name), ["right hand", "chest"]);
    assert!((body.tip("right hand").unwrap().offset.translation.z - 0.4).abs() < 1e-15);
    assert!((body.tool().translation.vector.norm() - 0.4).abs() < 1e-15);
    assert_eq!(body.tip("left hand"), None);
}

#[test]
fn a_base_in_the_middle_selects_what_is_below_it() {
    let options = UrdfTreeOptions { base: Some("left_upper"), ..UrdfTreeOptions::default() };
    let arm = RobotModel::from_urdf_tree(&body(), &options).unwrap();
    assert_eq!(names(arm.joints(), |joint| &joint.name), ["left_elbow", "grip"]);
}

#[test]
fn limits_and_names_can_be_stated_also_for_mimic_joints() {
    let fast = LimitOverride { velocity: Some(0.1), ..LimitOverride::default() };
    let overrides = Overrides {
        limits: [("grip_too".to_owned(), fast)].into(),
        joint_names: [("grip".to_owned(), "close".to_owned())].into(),
        ..Overrides::default()
    };
    let options = UrdfTreeOptions { overrides: Some(&overrides), ..UrdfTreeOptions::default() };
    let body = RobotModel::from_urdf_tree(&body(), &options).unwrap();
    let close = &body.joints()[3];
    // The mimic joint moves twice as fast.
    assert_eq!((close.name.as_str(), close.limits.velocity), ("close", 0.05));
    assert_eq!((close.limits.lower, close.limits.upper), (0.0, 0.04));
}

#[test]
fn trees_that_are_none_are_refused() {
    let refused = |links: &str, joints: &[String]| tree(&robot(links, joints)).unwrap_err().to_string();
    let options = |tip: &'static str, link: &'static str| {
        let tips = [UrdfTip { name: tip, link, offset: IsometryMatrix3::identity() }];
        RobotModel::from_urdf_tree(&body(), &UrdfTreeOptions { tips: &tips, ..UrdfTreeOptions::default() })
            .unwrap_err()
            .to_string()
    };
    assert_eq!(options("hand", "foot"), "tip `hand`: there is no link `foot`");
    assert_eq!(options("hand", "base"), "tip `hand`: no joint moves link `base`");
    let cycle = [joint("j", "a", "b", REVOLUTE), joint("k", "b", "a", REVOLUTE)];
    assert_eq!(tree(&robot("a b", &cycle)).unwrap_err(), UrdfError::Model(ModelError::Cycle { link: "a".to_owned() }));
    let from_a = UrdfTreeOptions { base: Some("a"), ..UrdfTreeOptions::default() };
    let through_base = RobotModel::from_urdf_tree(&robot("a b", &cycle), &from_a).unwrap_err();
    assert_eq!(through_base, UrdfError::Model(ModelError::Cycle { link: "a".to_owned() }));
    let diamond = [joint("j", "a", "b", REVOLUTE), joint("k", "a", "b", REVOLUTE)];
    assert!(refused("a b", &diamond).contains("link `b` is the child of the joints `j` and `k`"));
    let floating = [joint("j", "a", "b", r#"type="floating">"#)];
    assert!(refused("a b", &floating).starts_with("joint `j` is floating; only fixed, revolute"));
    let welded = [joint("j", "a", "b", r#"type="fixed">"#)];
    assert_eq!(tree(&robot("a b", &welded)).unwrap_err(), UrdfError::Model(ModelError::NoJoints));
    let follow = |leader: &str, first: &str| {
        let second = format!(r#"type="prismatic"><mimic {leader}/>"#);
        refused("a b c", &[joint("j", "a", "b", first), joint("k", "b", "c", &second)])
    };
    let fixed = "joint `k` follows joint `j`, which is fixed; follow a joint that moves";
    assert_eq!(follow(r#"joint="j""#, r#"type="fixed">"#), fixed);
    let chain = "joint `k` follows joint `k`, which is a mimic joint; follow a joint with its own position";
    assert_eq!(follow(r#"joint="k""#, REVOLUTE), chain);
    assert_eq!(follow(r#"joint="l""#, REVOLUTE), "joint `k` follows joint `l`, which does not exist");
    assert!(follow("", REVOLUTE).contains("joint `k` needs <mimic joint="));
    assert!(follow(r#"joint="j" multiplier="nan""#, REVOLUTE).contains("multiplier"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_text_gives_an_error_or_a_valid_tree(text in any_text()) {
        if let Ok(robot) = tree(&text) {
            prop_assert!(robot.joint_count() > 0 && !robot.tips().is_empty());
            let finite = |placement: &IsometryMatrix3<f64>| placement.to_homogeneous().iter().all(|entry| entry.is_finite());
            prop_assert!(robot.links().iter().all(|link| finite(&link.placement)));
        }
    }
}
