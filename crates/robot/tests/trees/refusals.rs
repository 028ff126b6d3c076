//! Descriptions that are no robot.

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_robot::{
    JointKind, JointLimits, JointMotion, Mimic, ModelError, RobotModel, TreeDescription, TreeJoint, TreeTip,
};

fn turn() -> JointMotion {
    let limits = JointLimits { lower: -1.0, upper: 2.0, velocity: 3.0, ..JointLimits::NONE };
    JointMotion { kind: JointKind::Revolute, axis: Vector3::y(), limits, mimic: None }
}

fn follow(leader: &str, multiplier: f64, offset: f64) -> JointMotion {
    JointMotion { mimic: Some(Mimic { leader: leader.to_owned(), multiplier, offset }), ..turn() }
}

fn joint(name: &str, parent: &str, child: &str, motion: Option<JointMotion>) -> TreeJoint {
    let [name, parent, child] = [name, parent, child].map(str::to_owned);
    TreeJoint { name, parent, child, origin: IsometryMatrix3::identity(), motion }
}

fn tip(name: &str, link: &str) -> TreeTip {
    TreeTip { name: name.to_owned(), link: link.to_owned(), offset: IsometryMatrix3::identity() }
}

/// A base `a` with the tip `tool` on link `b`.
fn model(joints: &[TreeJoint]) -> Result<RobotModel, ModelError> {
    with_tips(joints, &[tip("tool", "b")])
}

fn with_tips(joints: &[TreeJoint], tips: &[TreeTip]) -> Result<RobotModel, ModelError> {
    let description = TreeDescription { base: "a".to_owned(), joints: joints.to_vec(), tips: tips.to_vec() };
    RobotModel::from_tree("robot", "", &description)
}

fn refusal(joints: &[TreeJoint]) -> String {
    model(joints).unwrap_err().to_string()
}

#[test]
fn links_that_are_not_a_tree_are_refused() {
    let first = || joint("j", "a", "b", Some(turn()));
    assert_eq!(refusal(&[]), "a robot needs at least one joint");
    assert_eq!(
        refusal(&[first(), joint("k", "a", "b", None)]),
        "link `b` is the child of the joints `j` and `k`; the links must form a tree"
    );
    let cycle = "the links form a cycle through `a`; the links must form a tree";
    assert_eq!(refusal(&[first(), joint("k", "b", "a", None)]), cycle);
    let apart = [first(), joint("k", "c", "d", None), joint("l", "d", "c", None)];
    assert!(matches!(model(&apart), Err(ModelError::Cycle { .. })));
    let below_cycle = [first(), joint("m", "d", "e", None), joint("k", "c", "d", None), joint("l", "d", "c", None)];
    assert!(matches!(model(&below_cycle), Err(ModelError::Cycle { .. })));
    let lost = "the parent of joint `k` is link `c`, which is not connected to the base";
    assert_eq!(refusal(&[first(), joint("l", "d", "e", None), joint("k", "c", "d", None)]), lost);
    assert_eq!(
        refusal(&[first(), joint("j", "b", "c", Some(turn()))]),
        "two joints are named `j`; give each its own name"
    );
}

#[test]
fn tips_must_be_on_links_that_move() {
    let joints = [joint("j", "a", "b", Some(turn())), joint("k", "a", "c", None)];
    let refusal = |tips: &[TreeTip]| with_tips(&joints, tips).unwrap_err().to_string();
    assert_eq!(refusal(&[]), "a robot needs at least one tip; the first one is the tool");
    assert_eq!(refusal(&[tip("tool", "b"), tip("hand", "d")]), "tip `hand`: there is no link `d`");
    assert_eq!(refusal(&[tip("hand", "c")]), "tip `hand`: no joint moves link `c`");
    assert_eq!(refusal(&[tip("tool", "b"), tip("tool", "b")]), "two tips are named `tool`; give each its own name");
    let far = TreeTip { offset: IsometryMatrix3::translation(f64::INFINITY, 0.0, 0.0), ..tip("tool", "b") };
    assert_eq!(refusal(&[far]), "tip `tool`: lengths and angles must be finite numbers, lengths at most 1e100 m");
}

#[test]
fn mimic_joints_must_follow_a_joint_with_its_own_position() {
    let with = |motion| {
        refusal(&[
            joint("j", "a", "b", Some(turn())),
            joint("w", "b", "c", None),
            joint("k", "c", "d", Some(motion)),
            joint("l", "d", "e", Some(follow("j", 1.0, 0.0))),
        ])
    };
    assert_eq!(with(follow("x", 1.0, 0.0)), "joint `k` follows joint `x`, which does not exist");
    assert_eq!(with(follow("w", 1.0, 0.0)), "joint `k` follows joint `w`, which is fixed; follow a joint that moves");
    for leader in ["l", "k"] {
        let chain = "is a mimic joint; follow a joint with its own position";
        assert_eq!(with(follow(leader, 1.0, 0.0)), format!("joint `k` follows joint `{leader}`, which {chain}"));
    }
    for (multiplier, offset) in [(f64::NAN, 0.0), (1.0, f64::INFINITY)] {
        assert_eq!(
            with(follow("j", multiplier, offset)),
            "joint `k`: lengths and angles must be finite numbers, lengths at most 1e100 m"
        );
    }
    let only = model(&[joint("k", "a", "b", Some(follow("k", 1.0, 0.0)))]);
    assert!(matches!(only, Err(ModelError::MimicChain { .. })));
}

#[test]
fn limits_of_a_mimic_joint_restrict_the_joint_that_it_follows() {
    let limits = |multiplier: f64, offset: f64| {
        let joints = [joint("j", "a", "b", Some(turn())), joint("k", "b", "c", Some(follow("j", multiplier, offset)))];
        model(&joints).map(|robot| robot.joints()[0].limits)
    };
    let range = |multiplier, offset| limits(multiplier, offset).map(|limits| [limits.lower, limits.upper]);
    assert_eq!(range(1.0, 0.0), Ok([-1.0, 2.0]));
    assert_eq!(range(-2.0, 0.0), Ok([-1.0, 0.5]));
    assert_eq!(range(0.5, 1.5), Ok([-1.0, 1.0]));
    assert_eq!(range(0.0, 100.0), Ok([-1.0, 2.0]));
    assert_eq!((limits(-2.0, 0.0).unwrap().velocity, limits(0.5, 0.0).unwrap().velocity), (1.5, 3.0));
    let apart = "joint `k` follows joint `j`, but no position is within the ranges of both";
    assert_eq!(limits(1.0, 9.0).unwrap_err().to_string(), apart);
}

#[test]
fn joints_without_axis_or_with_impossible_limits_are_refused() {
    let with = |motion| refusal(&[joint("j", "a", "b", Some(motion))]);
    assert_eq!(
        with(JointMotion { axis: Vector3::zeros(), ..turn() }),
        "joint `j`: the axis has length zero; give its direction"
    );
    let still = JointLimits { velocity: 0.0, ..JointLimits::NONE };
    assert!(
        with(JointMotion { limits: still, ..turn() }).starts_with("joint `j`: the position range must not be empty")
    );
    let mut far = joint("j", "a", "b", Some(turn()));
    far.origin = IsometryMatrix3::translation(f64::NAN, 0.0, 0.0);
    assert_eq!(refusal(&[far]), "joint `j`: lengths and angles must be finite numbers, lengths at most 1e100 m");
}
