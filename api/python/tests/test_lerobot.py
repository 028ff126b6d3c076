"""LeRobot's kinematics and actions, without LeRobot, and the same numbers as the real package, if installed."""

import gc
import math
import os
import runpy
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from conftest import ROOT

import revprio
from revprio.lerobot import EEToJoints, RobotKinematics

PANDA = str(ROOT / "fixtures/robots/panda.urdf")
START = np.rad2deg([0.1, -0.6, 0.05, -2.1, 0.1, 1.6, 0.7])
NAMES = [f"panda_joint{k}" for k in range(1, 8)]


@pytest.fixture(scope="module")
def kinematics() -> RobotKinematics:
    """Returns the kinematics of a Panda."""
    return RobotKinematics(PANDA, "panda_link8", NAMES)


def ee_action(pose: np.ndarray, gripper: float = 50.0) -> dict[str, float]:
    """Returns an action of LeRobot."""
    angle = math.acos(np.clip((pose[:3, :3].trace() - 1) / 2, -1, 1))
    skew = pose[:3, :3] - pose[:3, :3].T
    vector = np.array([skew[2, 1], skew[0, 2], skew[1, 0]]) * angle / (2 * math.sin(angle))
    named = dict(zip(("ee.wx", "ee.wy", "ee.wz"), vector.tolist(), strict=True))
    return dict(zip(("ee.x", "ee.y", "ee.z"), pose[:3, 3].tolist(), strict=True)) | named | {"ee.gripper_pos": gripper}


def test_the_inverse_undoes_the_forward_kinematics(kinematics: RobotKinematics) -> None:
    goal = kinematics.forward_kinematics(START + 8)
    found = kinematics.inverse_kinematics(START, goal, orientation_weight=1.0)
    assert np.abs(kinematics.forward_kinematics(found) - goal).max() < 1e-6


def test_kinematics_that_nobody_uses_leave_no_robot_behind() -> None:
    known = {robot.name for robot in revprio.robots()}
    kinematics = RobotKinematics(PANDA, "panda_link8", NAMES)
    assert len(revprio.robots()) == len(known) + 1
    del kinematics
    gc.collect()
    assert {robot.name for robot in revprio.robots()} == known


def test_a_target_out_of_reach_is_approached_and_nothing_is_raised(kinematics: RobotKinematics) -> None:
    far = kinematics.forward_kinematics(START)
    far[:3, 3] = [3.0, 0.0, 0.3]
    found = kinematics.inverse_kinematics(START, far)
    assert np.isfinite(found).all()
    assert kinematics.forward_kinematics(found)[0, 3] > 0.7
    for metres in (1e15, 1e300):
        far[0, 3] = metres
        assert np.isfinite(kinematics.inverse_kinematics(START, far)).all()
    far[0, 3] = math.nan
    assert (kinematics.inverse_kinematics(START, far) == START).all()


def test_a_gripper_after_the_joints_keeps_its_value(kinematics: RobotKinematics) -> None:
    with_gripper = np.append(START, 42.0)
    found = kinematics.inverse_kinematics(with_gripper, kinematics.forward_kinematics(START))
    assert found[7] == 42.0
    assert np.abs(found[:7] - START).max() < 1e-4


def test_a_jump_is_scaled_and_made_up_for(kinematics: RobotKinematics) -> None:
    names = [*NAMES, "gripper"]
    step = EEToJoints(kinematics, names, max_speed_deg_s=90.0)
    observation = {f"{name}.pos": value for name, value in zip(names, [*START, 10.0], strict=True)}
    goal = kinematics.forward_kinematics(START)
    goal[:3, 3] += [0.0, 0.3, 0.1]
    last, scales = observation, []
    for _ in range(60):
        now = step.process(ee_action(goal, 90.0) | {"extra": 1}, observation)
        arm = [abs(now[f"{name}.pos"] - last[f"{name}.pos"]) for name in NAMES]
        assert max(arm) <= 90.0 / 30 + 1e-9
        assert abs(now["gripper.pos"] - last["gripper.pos"]) <= 200 / 30 + 1e-9
        scales.append(step.scale)
        last = now
    reached = kinematics.forward_kinematics([last[f"{name}.pos"] for name in NAMES])
    assert scales[0] < 0.5
    assert scales[-1] == 1.0
    assert np.abs(reached[:3, 3] - goal[:3, 3]).max() < 1e-3
    assert last["gripper.pos"] == 90.0
    assert last["extra"] == 1


@pytest.mark.parametrize(
    "motors",
    [
        [*NAMES, "gripper"],
        ["gripper", *NAMES],
        ["gripper", *reversed(NAMES)],
        ["gripper", *(f"motor_{name}" for name in NAMES)],
    ],
)
def test_motors_are_the_joints_with_their_names(kinematics: RobotKinematics, motors: list[str]) -> None:
    """Motors with other names are the joints in their order."""
    step = EEToJoints(kinematics, motors)
    named = {motor.removeprefix("motor_"): motor for motor in motors}
    start = dict(zip([*NAMES, "gripper"], [*START, 10.0], strict=True))
    goal = kinematics.forward_kinematics(START)
    goal[1, 3] += 0.05
    observation = {f"{motor}.pos": start[name] for name, motor in named.items()}
    for _ in range(30):
        now = step.process(ee_action(goal, 10.0), observation)
    reached = kinematics.forward_kinematics([now[f"{named[name]}.pos"] for name in NAMES])
    assert list(now) == [f"{motor}.pos" for motor in motors]
    assert np.abs(reached[:3, 3] - goal[:3, 3]).max() < 1e-3
    assert now["gripper.pos"] == 10.0


@pytest.mark.parametrize(
    "motors",
    [
        NAMES[:-1],
        [f"motor_{name}" for name in NAMES[:-1]],
        # By their places, the gripper would move the first joint.
        ["left_gripper", *(f"motor_{name}" for name in NAMES)],
    ],
)
def test_motors_that_do_not_match_the_joints_are_refused(kinematics: RobotKinematics, motors: list[str]) -> None:
    with pytest.raises(ValueError, match="joint"):
        EEToJoints(kinematics, motors)


def test_a_name_given_twice_is_refused(kinematics: RobotKinematics) -> None:
    with pytest.raises(ValueError, match="motor_names has a, b more than once"):
        EEToJoints(kinematics, ["b", "a", "a", "b", "c", "d", "e"])
    with pytest.raises(ValueError, match=f"joint_names has {NAMES[0]} more than once"):
        RobotKinematics(kinematics.urdf_path, kinematics.target_frame_name, [*NAMES, NAMES[0]])


@pytest.mark.parametrize("motors", [["gripper", *"abcdefg"], [*"abcdefg", "gripper"]])
@pytest.mark.parametrize("names", [["hand", *NAMES], [*NAMES, "hand"], ["hand", *reversed(NAMES)]])
def test_motors_with_other_names_are_the_joints_that_move_the_frame(
    kinematics: RobotKinematics, names: list[str], motors: list[str]
) -> None:
    """The place of a joint that does not move the frame shifts no motor."""
    own = RobotKinematics(kinematics.urdf_path, kinematics.target_frame_name, names)
    joints = [name for name in names if name != "hand"]
    start = dict(zip(NAMES, START, strict=True))
    observation = {"gripper.pos": 1.0} | {f"{m}.pos": start[joint] for m, joint in zip("abcdefg", joints, strict=True)}
    step = EEToJoints(own, motors)
    held = step.process(ee_action(kinematics.forward_kinematics(START), 1.0), observation)
    assert {name: held[name] for name in observation} == pytest.approx(observation, abs=1e-3)


def test_a_pose_without_a_rotation_and_negative_weights_are_refused(kinematics: RobotKinematics) -> None:
    for wrong in (np.zeros((4, 4)), 2.0 * np.eye(4), np.diag([1.0, 1.0, -1.0, 1.0])):
        with pytest.raises(ValueError, match="no rotation matrix"):
            kinematics.inverse_kinematics(START, wrong)
    with pytest.raises(ValueError, match="weights of at least 0"):
        kinematics.inverse_kinematics(START, kinematics.forward_kinematics(START), position_weight=-1.0)


def test_a_sliding_joint_is_refused(tmp_path: Path, kinematics: RobotKinematics) -> None:
    text = Path(kinematics.urdf_path).read_text(encoding="utf-8")
    sliding = tmp_path / "sliding.urdf"
    sliding.write_text(text.replace('type="revolute"', 'type="prismatic"', 1), encoding="utf-8")
    with pytest.raises(ValueError, match=f"{NAMES[0]} slides"):
        RobotKinematics(str(sliding), kinematics.target_frame_name)


def test_names_that_lack_a_joint_of_the_chain_are_refused(kinematics: RobotKinematics) -> None:
    with pytest.raises(ValueError, match=f"`joint_names` lacks {kinematics.chain[0]}; give all joints"):
        RobotKinematics(kinematics.urdf_path, kinematics.target_frame_name, kinematics.chain[1:])


@pytest.mark.parametrize(
    "wrong", [{}, {"ee.x": math.nan}, {"ee.x": None}, {"ee.wx": "a"}, {"ee.y": 1e300}, {"ee.wz": 10**400}]
)
def test_an_action_without_numbers_holds_the_last_one(kinematics: RobotKinematics, wrong: dict[str, object]) -> None:
    step = EEToJoints(kinematics, NAMES)
    observation = {f"{name}.pos": value for name, value in zip(NAMES, START, strict=True)}
    action = (ee_action(kinematics.forward_kinematics(START)) | wrong) if wrong else {}
    held = step.process(action, observation)
    assert [held[f"{name}.pos"] for name in NAMES] == pytest.approx(list(START))


def test_the_numbers_are_those_of_the_real_package(tmp_path: Path) -> None:
    """Against `lerobot.model.kinematics.RobotKinematics`, which is one step of placo in each call."""
    real = pytest.importorskip("lerobot.model.kinematics")
    pytest.importorskip("placo")
    source = os.environ.get("SO101_URDF")
    if source is None:
        pytest.skip("set SO101_URDF to so101.urdf, as example-robot-data has it")
    # Without the meshes, which placo would load.
    tree = ET.parse(source)
    for link in tree.getroot().iter("link"):
        for part in link.findall("visual") + link.findall("collision"):
            link.remove(part)
    urdf = str(tmp_path / "so101.urdf")
    tree.write(urdf)
    names = ["shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll"]
    ours, theirs = RobotKinematics(urdf, joint_names=names), real.RobotKinematics(urdf, joint_names=names)
    generator = np.random.default_rng(0)
    for _ in range(50):
        start = generator.uniform(-50, 50, 5)
        pose = theirs.forward_kinematics(start)
        assert np.abs(ours.forward_kinematics(start) - pose).max() < 1e-9
        goal = theirs.forward_kinematics(start + generator.uniform(-10, 10, 5))
        step = start
        for _ in range(200):
            step = theirs.inverse_kinematics(step, goal)
        found = ours.inverse_kinematics(start, goal)
        assert np.abs(ours.forward_kinematics(found)[:3, 3] - goal[:3, 3]).max() < 1e-5
        assert np.abs(theirs.forward_kinematics(step)[:3, 3] - goal[:3, 3]).max() < 1e-4


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("max_speed_deg_s", math.nan),
        ("max_speed_deg_s", 0.0),
        ("max_speed_deg_s", dict.fromkeys(NAMES[:-1], 90.0)),
        ("max_speed_deg_s", dict.fromkeys(NAMES, -1.0)),
        ("max_gripper_speed", math.inf),
        ("period_s", None),
    ],
)
def test_a_speed_that_bounds_nothing_is_refused(kinematics: RobotKinematics, field: str, value: Any) -> None:  # noqa: ANN401
    with pytest.raises(ValueError, match=rf"^{field}( of panda_joint\d)? must be a positive number"):
        EEToJoints(kinematics, [*NAMES, "gripper"], **{field: value})


LEADER = str(ROOT / "api/python/examples/leader_follower.py")


def test_a_simulated_leader_leads_a_follower(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", [LEADER])
    names = runpy.run_path(LEADER)
    assert names["sent"] > 100
    assert np.abs(names["q"] - names["frames"][-1][1]).max() < 0.1


def test_the_file_of_an_episode_leads_a_follower(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    times = np.arange(60) / 30
    actions = [[*(START + 10 * np.sin(t)), 50.0] for t in times]
    path = str(tmp_path / "episode.parquet")
    pandas.DataFrame({"timestamp": times, "action": actions}).to_parquet(path)
    monkeypatch.setattr("sys.argv", [LEADER, path])
    names = runpy.run_path(LEADER)
    assert names["sent"] > 40
    assert np.abs(names["q"] - names["frames"][-1][1]).max() < 0.05
