"""MuJoCo models."""

from pathlib import Path
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest

import revprio

# A shoulder of three joints in one body, anchors that are not the origin of the body, positions with a reference, a
# slide before a hinge in one body, and Euler angles in degrees of a default class.
ARM = """<mujoco model="odd arm">
  <compiler angle="degree" eulerseq="zyx"/>
  <default><joint limited="true" range="-170 170"/></default>
  <worldbody>
    <body name="table" pos="0.3 -0.2 0.7" euler="30 20 10">
      <body name="shoulder" pos="0 0.1 0.2" quat="0.5 -0.5 0.5 0.5">
        <joint name="pan" axis="0 0 1" ref="20"/>
        <joint name="lift" axis="1 2 0" pos="0.01 0.02 0.03" ref="-35"/>
        <joint name="roll" axis="0 1 0" pos="0.1 0 -0.2"/>
        <geom size="0.1"/>
        <body name="rail" pos="0.2 0 0.1" euler="0 90 0">
          <joint name="extend" type="slide" axis="1 1 1" range="-0.1 0.5" ref="0.2"/>
          <joint name="elbow" axis="0 -1 0" pos="0 0.1 0"/>
          <geom size="0.1"/>
          <body name="wrist" pos="0 0 0.3">
            <joint name="turn" axis="0.2 0 1" limited="false" pos="0 0 0.05"/>
            <geom size="0.1"/>
            <site name="attachment_site" pos="0.01 0.02 0.1" euler="0 -90 45"/>
            <body name="left" pos="0 0.02 0.1">
              <joint name="drive" type="slide" axis="0 1 0" range="0 0.04"/><geom size="0.01"/>
            </body>
            <body name="right" pos="0 -0.02 0.1">
              <joint name="slave" type="slide" axis="0 -1 0" range="0 0.04"/><geom size="0.01"/>
            </body>
          </body>
        </body>
      </body>
    </body>
    <body name="cube"><freejoint/><geom size="0.1"/></body>
  </worldbody>
  <equality><joint joint1="slave" joint2="drive" polycoef="0.01 -1 0 0 0"/></equality>
</mujoco>"""

# The arm of a flying base, with a linkage that drives its gripper.
FLYING = """<mujoco>
  <worldbody><body name="drone" pos="0 0 2"><freejoint name="float"/><geom size="0.1"/>
    <body name="upper"><joint name="a" axis="0 1 0" range="-2 2"/><geom size="0.1"/>
      <body name="fore" pos="0 0 0.3"><joint name="b" axis="0 1 0" range="-2 2"/><geom size="0.1"/>
        <body name="crank" pos="0 0 0.3"><joint name="c" axis="0 1 0" range="-2 2"/><geom size="0.1"/></body>
        <body name="rocker" pos="0 0 0.3"><joint name="d" axis="0 1 0" range="-2 2"/><geom size="0.1"/></body>
        <body><joint type="ball"/><geom size="0.1"/></body>
      </body></body></body>
  </worldbody>
  <equality><connect body1="crank" body2="rocker" anchor="0 0 0.1"/></equality>
</mujoco>"""


# The second joint is kept at 0.3 + 0.4 rad. The third body has no name, the second one has the name it would get.
LOCKED = """<mujoco>
  <compiler angle="radian"/>
  <worldbody><body name="a"><joint name="first" axis="0 1 0" range="-2 2"/><geom size="0.1"/>
    <body name="body_3" pos="0 0 0.3"><joint name="kept" axis="1 1 0" pos="0.1 0 0" range="-2 2" ref="0.3"/>
      <geom size="0.1"/>
      <body pos="0 0.1 0.3"><joint name="last" axis="1 0 0" range="-2 2"/><geom size="0.1"/>
        <site name="tcp" pos="0 0 1"/></body>
    </body></body>
  </worldbody>
  <equality><joint joint1="kept" polycoef="0.4 0 0 0 0"/></equality>
</mujoco>"""


def rotation(orientation: revprio.Orientation) -> np.ndarray:
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, [orientation.w, orientation.x, orientation.y, orientation.z])
    return matrix


def random_arm(seed: int) -> str:
    """A chain of bodies with one to three joints each, at random places."""
    rng = np.random.default_rng(seed)
    text = '<site name="tool0" pos="0.1 0.2 0.3"/>'
    for body in range(4):
        joints = ""
        for joint in range(rng.integers(1, 4)):
            axis, anchor = (" ".join(map(str, rng.uniform(-1, 1, 3))) for _ in range(2))
            kind, reference = rng.choice(["hinge", "slide"]), rng.uniform(-1, 1)
            joints += f'<joint name="j{body}{joint}" type="{kind}" axis="{axis}" pos="{anchor}" ref="{reference}"/>'
        place, turn = (" ".join(map(str, rng.uniform(-1, 1, count))) for count in (3, 4))
        text = f'<body name="b{body}" pos="{place}" quat="{turn}">{joints}<geom size="0.1"/>{text}</body>'
    options = '<compiler angle="radian"/><default><joint limited="true" range="-3 3"/></default>'
    return f"<mujoco>{options}<worldbody>{text}</worldbody></mujoco>"


@pytest.mark.parametrize("text", [ARM, *map(random_arm, range(8))], ids=["odd", *map(str, range(8))])
def test_poses_are_those_of_mujoco(text: str, tmp_path: Path) -> None:
    file = tmp_path / "arm.xml"
    file.write_text(text, encoding="utf-8")
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    rng = np.random.default_rng(1)
    urdf = revprio.read_mjcf(file, velocity_limits=2.0)
    # Sites are tips, and so are bodies.
    for tip, frame in [(model.site(0).name, data.site(0)), (model.body(2).name, data.body(2))]:
        robot = revprio.register_robot(name="mjcf", urdf=urdf, tip=tip)
        try:
            for _ in range(20):
                posture = {joint.name: rng.uniform(-2, 2) for joint in robot.joints}
                for name, position in posture.items():
                    data.joint(name).qpos[0] = position
                mujoco.mj_kinematics(model, data)
                pose = revprio.kinematics(robot="mjcf", joint_position=posture).pose
                np.testing.assert_allclose(np.asarray(pose.position), frame.xpos, atol=1e-12)
                np.testing.assert_allclose(rotation(pose.orientation), frame.xmat, atol=1e-12)
        finally:
            revprio.delete_robot("mjcf")


def test_the_arm_is_found_with_its_limits_and_without_its_gripper() -> None:
    model = mujoco.MjModel.from_xml_string(ARM)
    speeds = dict.fromkeys(("pan", "lift", "roll", "extend", "elbow", "turn"), 1.5)
    robot = revprio.register_robot(name="odd", urdf=revprio.read_mjcf(model, velocity_limits=speeds))
    try:
        assert robot.chain is not None
        assert (robot.chain.base, robot.chain.tip, robot.chain.joints) == ("world", "attachment_site", list(speeds))
        assert {joint.joint for joint in robot.chain.left_out} == {"drive", "slave"}
        extend, turn = robot.joints[3], robot.joints[5]
        assert (extend.kind, turn.kind) == ("prismatic", "revolute")
        np.testing.assert_allclose(np.asarray(extend.position_limit), [-0.1, 0.5])
        assert turn.velocity_limit == pytest.approx(1.5)
        assert turn.position_limit is None
    finally:
        revprio.delete_robot("odd")


def test_a_locked_joint_is_fixed() -> None:
    model = mujoco.MjModel.from_xml_string(LOCKED)
    robot = revprio.register_robot(name="locked", urdf=revprio.read_mjcf(model, velocity_limits=1.0))
    revprio_pose = revprio.kinematics(robot="locked", joint_position={"first": 0.5, "last": -1.2}).pose
    revprio.delete_robot("locked")
    assert [joint.name for joint in robot.joints] == ["first", "last"]
    data = mujoco.MjData(model)
    data.qpos[:] = [0.5, 0.7, -1.2]
    mujoco.mj_kinematics(model, data)
    np.testing.assert_allclose(np.asarray(revprio_pose.position), data.site("tcp").xpos, atol=1e-12)
    np.testing.assert_allclose(rotation(revprio_pose.orientation), data.site("tcp").xmat, atol=1e-12)


def test_a_joint_that_follows_another_one_becomes_mimic() -> None:
    robot = ET.fromstring(revprio.read_mjcf(mujoco.MjModel.from_xml_string(ARM)))
    mimic = robot.find("joint[@name='slave']/mimic")
    assert mimic is not None
    assert (mimic.get("joint"), mimic.get("multiplier"), mimic.get("offset")) == ("drive", "-1.0", "0.01")


def arm_with_equality(equality: str, objects: str = "") -> mujoco.MjModel:
    """An arm with joints j0 to j4 about parallel axes, and a cube, a sphere that the user moves, and a table."""
    text = '<site name="tool" pos="0.3 0 0"/>'
    for number in range(4, -1, -1):
        joint = f'<joint name="j{number}" axis="0 0 1" range="-100 100" ref="{10 * number}"/><geom size="0.1"/>'
        text = f'<body name="b{number}" pos="0.5 0 0">{joint}{text}</body>'
    scene = """<body name="cube"><freejoint/><geom size="0.1"/></body>
        <body name="target" mocap="true"><geom size="0.1"/></body>
        <body name="table"><geom size="0.1"/><site name="vise"/></body>"""
    equality = f"<equality>{equality}</equality>"
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{text}{scene}{objects}</worldbody>{equality}</mujoco>")


def test_a_coupling_that_is_not_linear_is_refused_with_the_remedy() -> None:
    for numbers in ("0 1 0.5 0 0", "0 1 0 0.5 0", "0 1 0 0 0.5"):
        model = arm_with_equality(f'<joint joint1="j2" joint2="j1" polycoef="{numbers}"/>')
        message = f'joint `j2` follows joint `j1` .* polycoef="{numbers}"; .* Set .* to 0 .* active="false"'
        with pytest.raises(ValueError, match=message):
            revprio.read_mjcf(model)


def test_an_inactive_coupling_does_not_count() -> None:
    for numbers in ("0 1 0.5 0 0", "0 1 0 0 0"):
        model = arm_with_equality(f'<joint joint1="j2" joint2="j1" polycoef="{numbers}" active="false"/>')
        assert "mimic" not in revprio.read_mjcf(model)


def test_a_joint_that_follows_a_locked_one_is_fixed() -> None:
    # In any order, over several joints, and by a polynomial too: with j1 fixed, all of them are numbers.
    model = arm_with_equality(
        '<joint joint1="j3" joint2="j2" polycoef="0.1 0.5 0.3 0.2 -0.4"/>'
        '<joint joint1="j2" joint2="j1" polycoef="0.2 -1.5 0 0 0"/><joint joint1="j1" polycoef="0.6 0 0 0 0"/>'
        '<joint joint1="j4" joint2="j0" polycoef="0.1 2 0 0 0"/>',
    )
    urdf = revprio.read_mjcf(model, velocity_limits=1.0)
    robot = revprio.register_robot(name="followers", urdf=urdf, tips=[revprio.RegisteredTip(name="tip", link="tool")])
    pose = revprio.kinematics(robot="followers", joint_position={"j0": 0.5}).pose
    revprio.delete_robot("followers")
    assert [joint.name for joint in robot.joints] == ["j0"]
    data = mujoco.MjData(model)
    motions = {"j0": 0.5, "j1": 0.6, "j2": 0.2 - 1.5 * 0.6}
    motions["j3"] = float(np.polyval([-0.4, 0.2, 0.3, 0.5, 0.1], motions["j2"]))
    motions["j4"] = 0.1 + 2 * motions["j0"]
    for name, motion in motions.items():
        data.joint(name).qpos[0] = model.joint(name).qpos0[0] + motion
    mujoco.mj_kinematics(model, data)
    np.testing.assert_allclose(np.asarray(pose.position), data.site("tool").xpos, atol=1e-12)


def test_joints_that_follow_each_other_do_not_hang() -> None:
    pair = '<joint joint1="{}" joint2="{}" polycoef="0 1 0 0 0"/>'
    model = arm_with_equality(pair.format("j1", "j2") + pair.format("j2", "j1"))
    assert revprio.read_mjcf(model).count("<mimic") == 2


def test_a_free_base_is_the_root_and_loops_and_balls_are_left_out() -> None:
    urdf = revprio.read_mjcf(mujoco.MjModel.from_xml_string(FLYING), velocity_limits=1.0)
    robot = revprio.register_robot(name="flying", urdf=urdf)
    try:
        assert robot.chain is not None
        assert (robot.chain.base, robot.chain.tip, robot.chain.joints) == ("drone", "fore", ["a", "b"])
        left_out = {joint.joint: joint.reason for joint in robot.chain.left_out}
        assert left_out == dict.fromkeys(["c", "d", "joint_5"], "unsupported")
    finally:
        revprio.delete_robot("flying")


def test_missing_speeds_and_wrong_files_are_refused_with_the_remedy(tmp_path: Path) -> None:
    urdf = revprio.read_mjcf(mujoco.MjModel.from_xml_string(FLYING))
    with pytest.raises(revprio.InvalidError, match=r'`limits`: {"a": {"velocity": number}, "b": {"velocity": number}}'):
        revprio.register_robot(name="slow", urdf=urdf)
    limits = {"a": revprio.StatedLimits(velocity=1.0), "b": revprio.StatedLimits(velocity=2.0)}
    robot = revprio.register_robot(name="slow", urdf=urdf, limits=limits)
    revprio.delete_robot("slow")
    assert [joint.velocity_limit for joint in robot.joints] == [1.0, 2.0]
    with pytest.raises(ValueError, match="no joint elbow; its joints are float, a, b"):
        revprio.read_mjcf(mujoco.MjModel.from_xml_string(FLYING), velocity_limits={"elbow": 1.0})
    with pytest.raises(TypeError, match=r"numbers by the names of joints, not \[1, 2\]"):
        revprio.read_mjcf(mujoco.MjModel.from_xml_string(FLYING), velocity_limits=[1, 2])  # type: ignore[arg-type]
    (tmp_path / "broken.xml").write_text("<mujoco><worldbody>", encoding="utf-8")
    with pytest.raises(ValueError, match=r"broken\.xml: XML"):
        revprio.read_mjcf(tmp_path / "broken.xml")


def joints_of_type(kind: str, urdf: str) -> set[str | None]:
    return {joint.get("name") for joint in ET.fromstring(urdf).findall("joint") if joint.get("type") == kind}


@pytest.mark.parametrize(
    ("equality", "loop"),
    [
        ('<weld body1="b3"/>', {"j0", "j1", "j2", "j3"}),
        ('<connect body1="b1" anchor="0 0 0"/>', {"j0", "j1"}),
        ('<weld body1="table" body2="b3"/>', {"j0", "j1", "j2", "j3"}),
        ('<weld site1="tool" site2="vise"/>', {"j0", "j1", "j2", "j3", "j4"}),
        ('<weld body1="b1" body2="door"/>', {"j0", "j1", "hinge"}),
        ('<weld body1="b3" active="false"/>', set()),
        # They pull the arm, or hold what it grasps.
        ('<weld body1="target" body2="b4"/>', set()),
        ('<connect body1="b4" body2="target" anchor="0 0 0"/>', set()),
        ('<weld body1="b4" body2="cube"/>', set()),
    ],
)
def test_the_world_closes_loops_and_what_moves_freely_does_not(equality: str, loop: set[str]) -> None:
    door = '<body name="door"><joint name="hinge"/><geom size="0.1"/></body>'
    urdf = revprio.read_mjcf(arm_with_equality(equality, door), velocity_limits=1.0)
    assert joints_of_type("closed_loop", urdf) == loop


def test_a_free_base_gives_way_to_a_weld_of_the_arm_to_the_world() -> None:
    text = FLYING.replace('<connect body1="crank" body2="rocker" anchor="0 0 0.1"/>', '<weld body1="fore"/>')
    assert not joints_of_type("closed_loop", revprio.read_mjcf(mujoco.MjModel.from_xml_string(text)))


def test_an_arm_that_is_welded_to_the_world_is_refused() -> None:
    urdf = revprio.read_mjcf(arm_with_equality('<weld body1="b4"/>'), velocity_limits=1.0)
    with pytest.raises(revprio.InvalidError, match="joint `j0` of the chain is closed_loop"):
        revprio.register_robot(name="welded", urdf=urdf, tip="tool")


SHAPES = """
<mujoco model="shapes">
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <geom name="table" type="box" size="0.2 0.3 0.05" pos="0 0 -0.2"/>
    <body name="upper">
      <joint name="shoulder" axis="0 0 1" range="-100 100"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.04"/>
      <geom type="sphere" size="0.5" contype="0" conaffinity="0"/>
      <body name="fore" pos="0.4 0 0">
        <joint name="elbow" axis="0 0 1" range="-100 100"/>
        <geom type="cylinder" fromto="0 0 0 0.2 0 0" size="0.03"/>
        <body pos="0.3 0 0"><geom type="ellipsoid" size="0.05 0.02 0.02"/></body>
      </body>
    </body>
  </worldbody>
</mujoco>"""


def test_geoms_that_collide_become_shapes_that_contain_them() -> None:
    urdf = revprio.read_mjcf(mujoco.MjModel.from_xml_string(SHAPES), velocity_limits=1.0)
    robot = revprio.register_robot(name="shapes", urdf=urdf, shapes="fit")
    try:
        assert robot.shapes is not None
        links = [shape.link for shape in robot.shapes.shape_list]
        assert links.count("upper") == 1  # the sphere collides with nothing
        assert set(links) == {"world", "upper", "fore"}
        capsule = next(shape.capsule for shape in robot.shapes.shape_list if shape.link == "upper")
        assert capsule is not None
        ends = np.sort([np.asarray(capsule.start)[0], np.asarray(capsule.end)[0]])
        np.testing.assert_allclose(ends, [0.0, 0.4], atol=1e-12)
        assert capsule.radius == pytest.approx(0.04)
        # The ellipsoid is on a body without a name, 0.3 m before the elbow.
        fore = [shape.capsule for shape in robot.shapes.shape_list if shape.link == "fore"]
        ends = np.array([[shape.start, shape.end] for shape in fore if shape is not None])
        assert ends[..., 0].max() > 0.3
    finally:
        revprio.delete_robot("shapes")


# `upper` has a visual geom before one that collides, `fore` has two visual ones, `hand` has none.
VISUAL = """
<mujoco>
  <default><default class="visual"><geom contype="0" conaffinity="0"/></default></default>
  <worldbody>
    <geom type="plane" size="1 1 0.1" class="visual"/>
    <body name="upper">
      <joint name="shoulder" axis="0 0 1" range="-100 100"/>
      <geom size="0.05" class="visual"/><geom size="0.04"/>
      <body name="fore" pos="0.4 0 0">
        <joint name="elbow" axis="0 0 1" range="-100 100"/>
        <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" class="visual"/>
        <body pos="0.2 0 0"><geom type="box" size="0.1 0.1 0.1" class="visual"/></body>
        <body name="hand" pos="0.4 0 0">
          <joint name="wrist" axis="0 0 1" range="-100 100"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
          <body name="tool" pos="0.1 0 0"><geom size="0.02"/></body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"""


def test_geoms_that_collide_only_in_a_stated_pair_become_shapes() -> None:
    """MuJoCo models for accelerators clear all masks and list the pairs."""
    text = """<mujoco><worldbody><body name="arm"><joint name="turn" range="-60 60"/>
        <geom name="link" type="capsule" size="0.05" fromto="0 0 0 0.3 0 0"/>
        <geom name="tool" type="box" size="0.1 0.02 0.3" contype="0" conaffinity="0"/>
        <geom type="sphere" size="0.4" contype="0" conaffinity="0"/>
        </body><geom name="table" type="box" size="1 1 0.1" pos="0 0 -1" contype="0" conaffinity="0"/></worldbody>
        <contact><pair geom1="tool" geom2="table"/></contact></mujoco>"""
    urdf = revprio.read_mjcf(mujoco.MjModel.from_xml_string(text), 1.0)
    shapes = {link.get("name"): len(link.findall("collision")) for link in ET.fromstring(urdf).findall("link")}
    assert shapes == {"world": 1, "arm": 2}


def test_links_that_are_only_visible_are_listed_as_uncovered() -> None:
    urdf = revprio.read_mjcf(mujoco.MjModel.from_xml_string(VISUAL), velocity_limits=1.0)
    visible = {link.get("name"): len(link.findall("visual")) for link in ET.fromstring(urdf).findall("link")}
    assert visible == {"world": 0, "upper": 0, "fore": 1, "hand": 0, "tool": 0}
    robot = revprio.register_robot(name="visual", urdf=urdf, shapes="fit")
    revprio.delete_robot("visual")
    assert robot.shapes is not None
    assert [shape.link for shape in robot.shapes.shape_list] == ["upper", "tool"]
    assert robot.shapes.uncovered_links == ["fore"]


# An arm on a base that the user can move, and objects around it: a stool, a door, a cup with a handle, and a target.
SCENE = """
<mujoco>
  <worldbody>
    <geom name="pillar" size="0.1" pos="2 0 0"/>
    <body name="stool" pos="1 0 0"><geom size="0.2"/></body>
    <body name="door" pos="0 1 0"><joint name="door_hinge" axis="0 0 1"/><geom type="box" size="0.4 0.02 0.9"/>
      <body><geom size="0.03"/></body></body>
    <body name="cup" pos="1 0 0.3"><freejoint/><geom size="0.05"/><site name="grip"/>
      <body><geom size="0.01"/></body><body name="handle"><geom size="0.01"/></body></body>
    <body pos="1 0 0.5"><freejoint/><geom size="0.05"/></body>
    <body name="target" mocap="true"><geom size="0.1"/><body name="axis"><geom size="0.01"/></body></body>
    <body mocap="true"><geom size="0.1" contype="0" conaffinity="0"/></body>
    <body name="cart" mocap="true"><geom size="0.1"/>
      <body name="upper" pos="0 0 0.2"><joint name="lift" axis="0 1 0"/><geom size="0.05"/>
        <body name="fore" pos="0.4 0 0"><joint name="bend" axis="0 1 0"/><geom size="0.05"/></body>
      </body></body>
  </worldbody>
</mujoco>"""


def test_objects_that_are_fixed_to_nothing_are_left_out() -> None:
    urdf = revprio.read_mjcf(mujoco.MjModel.from_xml_string(SCENE), velocity_limits=1.0)
    shapes = {link.get("name"): len(link.findall("collision")) for link in ET.fromstring(urdf).findall("link")}
    assert shapes == {"world": 1, "stool": 1, "door": 2, "cart": 1, "upper": 1, "fore": 1}
    assert "visual" not in urdf
    robot = revprio.register_robot(name="scene", urdf=urdf, shapes="fit", tip="fore")
    revprio.delete_robot("scene")
    assert robot.shapes is not None
    # The pillar and the stool are fixed to the base.
    assert [shape.link for shape in robot.shapes.shape_list] == ["world", "world", "cart", "upper", "fore"]
    assert robot.shapes.uncovered_links == ["door"]
