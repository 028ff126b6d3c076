//! Chains without a named tip.

use super::*;
use crate::LeftOutReason;

/// An arm of three joints `a1` to `a3` on `base`, with more links and joints.
fn arm(links: &str, more: &[String]) -> Result<RobotModel, UrdfError> {
    let arm =
        [joint("a1", "base", "l1", REVOLUTE), joint("a2", "l1", "l2", REVOLUTE), joint("a3", "l2", "l3", REVOLUTE)];
    read(&robot(&format!("base l1 l2 l3 {links}"), &[&arm[..], more].concat()))
}

fn chosen(links: &str, more: &[String]) -> (String, TipReason, Vec<LeftOutReason>) {
    let selection = arm(links, more).unwrap().selection().unwrap().clone();
    (selection.tip, selection.reason, selection.left_out.iter().map(|joint| joint.reason).collect())
}

fn fixed(name: &str, parent: &str, child: &str) -> String {
    joint(name, parent, child, r#"type="fixed">"#)
}

#[test]
fn the_best_named_link_behind_the_last_joint_is_the_tip() {
    let frames = [fixed("f", "l3", "ee_link"), fixed("g", "l3", "tool0"), fixed("h", "l3", "camera_tool")];
    assert_eq!(chosen("ee_link tool0 camera_tool", &frames), ("tool0".to_owned(), TipReason::ToolName, vec![]));
    assert_eq!(chosen("cover fingertip", &[fixed("f", "l3", "cover"), fixed("g", "l3", "fingertip")]).0, "fingertip");
    let plain = [fixed("f", "l3", "cover"), fixed("g", "base", "plate")];
    assert_eq!(chosen("cover plate", &plain), ("cover".to_owned(), TipReason::LastLink, vec![]));
    assert_eq!(chosen("cover", &plain[..1]), ("cover".to_owned(), TipReason::OnlyEnd, vec![]));
}

#[test]
fn gripper_joints_are_never_taken_without_being_asked_for() {
    let left_out = vec![LeftOutReason::Gripper];
    let jaw = [joint("jaw", "l3", "jaw_link", REVOLUTE)];
    assert_eq!(chosen("jaw_link", &jaw), ("l3".to_owned(), TipReason::BeforeGripper, left_out));
    let fingers = [
        fixed("mount", "l3", "adapter"),
        joint("f1", "adapter", "left_finger", r#"type="prismatic"><limit lower="0" upper="1" velocity="1"/>"#),
        joint("f2", "adapter", "right_finger", r#"type="prismatic"><mimic joint="f1"/>"#),
    ];
    let (tip, reason, left_out) = chosen("adapter left_finger right_finger", &fingers);
    assert_eq!((tip.as_str(), reason), ("adapter", TipReason::BeforeGripper));
    assert_eq!(left_out, [LeftOutReason::Gripper; 2]);
    // Behind a hand, the name of the joint does not matter.
    let drive = [fixed("m", "l3", "hand"), joint("x", "hand", "x1", REVOLUTE), joint("y", "hand", "y1", REVOLUTE)];
    assert_eq!(chosen("hand x1 y1", &drive).0, "hand");
    let mounted = [
        fixed("m", "l3", "hand"),
        fixed("n", "hand", "plate"),
        fixed("o", "plate", "lamp"),
        joint("x", "plate", "mover", REVOLUTE),
    ];
    assert_eq!(chosen("hand plate lamp mover", &mounted).2, [LeftOutReason::Gripper]);
    // So it does not if another joint follows it.
    let drives = [joint("x", "l3", "x1", REVOLUTE), joint("y", "l3", "y1", r#"type="revolute"><mimic joint="x"/>"#)];
    assert_eq!(chosen("x1 y1", &drives), ("l3".to_owned(), TipReason::BeforeGripper, vec![LeftOutReason::Gripper; 2]));
    // Joints of closed loops are never part of a serial arm.
    let linkage = [joint("p", "l3", "x1", r#"type="closed_loop">"#), joint("q", "l3", "x2", r#"type="closed_loop">"#)];
    let (tip, _, left_out) = chosen("x1 x2", &linkage);
    assert_eq!((tip.as_str(), left_out), ("l3", vec![LeftOutReason::Unsupported; 2]));
    // A chain of fingers only is what the caller wants.
    assert_eq!(read(&robot("a b", &[joint("finger", "a", "b", REVOLUTE)])).unwrap().joint_count(), 1);
}

#[test]
fn heads_wheels_and_sensors_are_no_arms_and_several_arms_are_named() {
    let others = [
        joint("head_pan", "base", "head", REVOLUTE),
        joint("wheel_left", "base", "wheel", r#"type="continuous">"#),
        joint("laser_tilt", "base", "laser", REVOLUTE),
    ];
    let (tip, _, left_out) = chosen("head wheel laser", &others);
    assert_eq!(left_out, [LeftOutReason::Head, LeftOutReason::LegOrWheel, LeftOutReason::Sensor]);
    assert_eq!(tip, "l3");
    let second = [joint("b1", "base", "k1", REVOLUTE), joint("b2", "k1", "k2", REVOLUTE)];
    let error = arm("k1 k2", &second).unwrap_err();
    assert_eq!(error.to_string(), "the robot has 2 arms; name the `tip`: `l3`, `k2`; or register several as `tips`");
    assert!(
        message(read(&robot(
            "a wheel_l wheel_r",
            &[joint("j", "a", "wheel_l", REVOLUTE), joint("k", "a", "wheel_r", REVOLUTE),]
        )))
        .contains("can end at several links; name the `tip`: `wheel_l`, `wheel_r`")
    );
}
