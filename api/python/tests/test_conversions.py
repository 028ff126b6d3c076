"""Quaternions as lists, constants, paths of URDF files, and masked arrays."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import revprio
from revprio import InvalidError, models
from revprio.states import StateNumbering

Q = np.array([0.3, -0.6, 0.2, 1.4, 0.5, 0.9, 0.0])


@pytest.mark.parametrize("given", [[0.0, 0.6, 0.0, 0.8], (0.0, 0.6, 0.0, 0.8), np.array([0.0, 0.6, 0.0, 0.8])])
def test_four_numbers_are_a_quaternion_x_y_z_w(given: Any) -> None:  # noqa: ANN401
    pose = models.Pose(position=[1, 2, 3], orientation=given)
    assert pose.orientation == models.Orientation(w=0.8, x=0.0, y=0.6, z=0.0)
    assert pose.json_bytes() == b'{"orientation":{"w":0.8,"x":0.0,"y":0.6,"z":0.0},"position":[1.0,2.0,3.0]}'
    assert "x, y, z, w, as in ROS and SciPy" in (models.Orientation.__doc__ or "")


@pytest.mark.parametrize("wrong", [[0, 0, 1], [[0, 0, 0, 1]], [0, 0, 0, float("nan")], 1.0, ["a", 0, 0, 1]])
def test_other_numbers_are_no_quaternion(wrong: Any) -> None:  # noqa: ANN401
    with pytest.raises(InvalidError) as refused:
        models.Pose(position=[1, 2, 3], orientation=wrong)
    assert refused.value.pointer == "/orientation"


def test_an_array_is_a_constant_target() -> None:
    law = models.PostureLaw(gain=2, target_position=Q)
    assert law.json_bytes() == models.PostureLaw(gain=2, target_position=models.ConstantProfile(value=Q)).json_bytes()
    assert b'"target_force":{"kind":"constant","value":30.0}' in (
        models.ForceLaw(inertia=15, damping=1000, target_force=30).json_bytes()
    )
    assert b"mid_range" in models.PostureLaw(gain=2, target_position="mid_range").json_bytes()
    with pytest.raises(InvalidError) as refused:
        models.PostureLaw(gain=2, target_position=[1.0, float("inf")])
    assert (refused.value.pointer or "").startswith("/target_position")
    task = models.ControllerTask(name="posture", law=law)
    with revprio.Controller(robot="sawyer_dh", period_s=0.01, tasks=[task]) as arm:
        assert np.abs(arm.step(Q).joint_velocity).max() < 1e-9


def test_a_path_of_a_urdf_file_is_read(tmp_path: Path) -> None:
    text = """\ufeff <robot name="two"><link name="a"/><link name="b"/><joint name="j" type="revolute">
        <parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
        <limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""
    file = tmp_path / "two.urdf"
    file.write_text(text.lstrip("\ufeff"), encoding="utf-8")
    for given in (file, str(file), text.lstrip("\ufeff ")):
        robot = revprio.register_robot(name="two", urdf=given)
        assert [joint.name for joint in robot.joints] == ["j"]
        revprio.delete_robot("two")


@pytest.mark.parametrize(
    ("wrong", "text"), [("no_such.urdf", "no_such.urdf"), ("arm.urdf.xacro", "read_xacro"), ("", "no URDF"), (3, "")]
)
def test_what_is_neither_urdf_nor_a_file_is_refused(wrong: Any, text: str) -> None:  # noqa: ANN401
    with pytest.raises(InvalidError) as refused:
        revprio.register_robot(name="two", urdf=wrong)
    assert refused.value.pointer == "/urdf"
    assert text in refused.value.detail


@pytest.mark.parametrize("name", ["joint_position", "joint_velocity", "wrench"])
def test_masked_arrays_are_refused(name: str) -> None:
    given = {"joint_position": Q, "joint_velocity": Q, "wrench": np.zeros(6)}
    given[name] = np.ma.masked_greater(given[name], 0.5)
    arm = revprio.Controller(robot="sawyer_dh", period_s=0.001, tasks=revprio.push("x", 15))
    with pytest.raises(InvalidError, match="masked"):
        arm.step(**given)  # type: ignore[arg-type]
    with pytest.raises(InvalidError, match="masked"):
        StateNumbering(0.001).state(given["joint_position"], given["joint_velocity"], given["wrench"], None)


def test_bodies_with_arrays_are_compared_by_what_they_send() -> None:
    def law(gain: float) -> revprio.PostureLaw:
        return revprio.PostureLaw(gain=gain, target_position=Q)

    assert law(2) == law(2)
    assert law(2) != law(3)
    assert law(2) != revprio.PoseLaw(gain=2)
    assert len({law(2), law(2), law(3)}) == 2


def test_an_array_that_changes_afterwards_changes_no_body() -> None:
    position = Q.copy()
    law = revprio.PostureLaw(gain=2, target_position=position)
    sent = law.json_bytes()
    position[0] = 5
    assert law.json_bytes() == sent


@pytest.mark.parametrize("wrong", [np.zeros(7, "M8[s]"), np.zeros(7, "m8[s]"), np.zeros(7, [("x", float)])])
def test_arrays_of_dates_and_records_are_no_numbers(wrong: Any) -> None:  # noqa: ANN401
    with pytest.raises(InvalidError):
        models.KinematicsRequest(robot="panda", joint_position=wrong)
