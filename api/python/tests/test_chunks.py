"""Chunks of actions from arrays, in the process and over HTTP."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import revprio

PERIOD = 0.01
IDEAL = revprio.JointDrive(lag_s=0, delay_periods=0)
START = [0, -0.785, 0, -2.356, 0, 1.571, 0.785]


def hand() -> revprio.ControllerTask:
    law = revprio.PoseLaw(gain=8.0)
    return revprio.ControllerTask(name="hand", axes=["x", "y", "z"], law=law)


def follow(
    controller: revprio.Controller, make: Callable[[float], revprio.StreamedTarget]
) -> tuple[np.ndarray, np.ndarray, revprio.StepAnswer]:
    """Follows chunks of a policy that needs 0.3 s; returns the commands."""
    q, commands = np.array(START), []
    for period in range(150):
        now = period * PERIOD
        targets = {"hand": make(now - 0.3)} if period % 50 == 30 else None
        answer = controller.step(q, time_s=now, targets=targets)
        commands.append(np.array(answer.joint_velocity))
        q = q + PERIOD * commands[-1]
    return np.array(commands), q, answer


def test_a_policy_leads_the_arm_to_where_its_actions_end() -> None:
    start = np.array(revprio.kinematics(robot="panda", joint_position=START).pose.position)

    def make(look: float) -> revprio.StreamedTarget:
        times = look + np.arange(50) / 30
        ramp = np.clip(times, 0, 1)[:, np.newaxis] * [0.0, 0.1, -0.05]
        return revprio.chunk(times, position=start + ramp, align="time")

    controller = revprio.Controller(robot="panda", tasks=[hand()], period_s=PERIOD, drive=IDEAL)
    commands, q, answer = follow(controller, make)
    reached = np.array(revprio.kinematics(robot="panda", joint_position=q).pose.position)
    assert np.abs(reached - start - [0.0, 0.1, -0.05]).max() < 2e-3
    status = answer.tasks[0].chunk
    assert status is not None
    assert status.actions_left > 0
    limits = np.array([joint.acceleration_limit for joint in revprio.robot("panda").joints])
    assert (np.abs(np.diff(commands, axis=0)).max(axis=0) <= limits * PERIOD * (1 + 1e-9)).all()


def test_joint_chunks_need_no_orientation() -> None:
    posture = revprio.PostureLaw(gain=5.0, target_position=START)
    task = revprio.ControllerTask(name="hand", law=posture)
    controller = revprio.Controller(robot="panda", tasks=[task], period_s=PERIOD, drive=IDEAL)

    def make(look: float) -> revprio.StreamedTarget:
        times = look + np.arange(50) / 30
        return revprio.chunk(times, joint_position=np.tile(np.array(START) + 0.1, (50, 1)), align="progress")

    _, q, _ = follow(controller, make)
    assert np.abs(q - START - 0.1).max() < 5e-3


def test_a_gripper_closes_with_the_actions_within_its_rate() -> None:
    channel = revprio.Channel(name="gripper", kind="position", lower=0.0, upper=0.08, max_rate=0.1)
    controller = revprio.Controller(robot="panda", tasks=[hand()], period_s=PERIOD, drive=IDEAL, channels=[channel])
    start = np.array(revprio.kinematics(robot="panda", joint_position=START).pose.position)
    times = np.arange(50) / 30
    closes = np.where(times < 0.5, 0.08, 0.0)
    arrived = {"hand": revprio.chunk(times, position=np.tile(start, (50, 1)), gripper=closes)}
    first = {"gripper": revprio.ChannelInput(measured=0.08)}
    commands = []
    for period in range(150):
        targets, channels = (arrived, first) if period == 0 else (None, None)
        answer = controller.step(START, time_s=period * PERIOD, targets=targets, channels=channels)
        assert answer.channels is not None
        commands.append(answer.channels["gripper"])
    changes = np.abs(np.diff(commands))
    assert commands[40] == pytest.approx(0.08)
    assert commands[-1] == 0.0
    assert changes.max() <= 0.1 * PERIOD + 1e-12


def test_a_chunk_without_values_is_refused() -> None:
    with pytest.raises(revprio.InvalidError, match="the actions have no values"):
        revprio.chunk([0.1, 0.2])


def test_wrong_shapes_are_refused_with_a_pointer() -> None:
    position = [[0.3, 0.0, 0.5], [0.31, 0.0, 0.5]]
    wrong: list[tuple[Any, Any, str, str]] = [
        ([0.0, 0.1], [[0, 0, 0]], "/position", "give 2 rows"),
        ([0.0, 0.1], [0.3, 0.0, 0.5], "/position", "shape (3,)"),
        ([0.0, 0.1], [position], "/position", "shape (1, 2, 3)"),
        ([0.0, 0.1], [[1, 2], [1, 2, 3]], "/position", "rows of equal length"),
        ([0.0, 0.1], {"x": 1}, "/position", "real numbers"),
        ([0.0, 0.1], np.array(position) * 1j, "/position", "real numbers"),
        (["now", "later"], position, "/time_s", "real numbers"),
        ([[0.0, 0.1]], position, "/time_s", "one time per action"),
    ]
    for times, values, pointer, part in wrong:
        with pytest.raises(revprio.InvalidError) as refused:
            revprio.chunk(times, position=values)
        assert refused.value.problem.pointer == pointer
        assert part in refused.value.problem.detail


def test_velocities_make_a_chunk() -> None:
    made = revprio.chunk([0.0, 0.1], velocity=[[0.1, 0.0, 0.0], [0.2, 0.0, 0.0]])
    assert made.chunk is not None
    assert np.array_equal(np.array([action.velocity for action in made.chunk]), [[0.1, 0.0, 0.0], [0.2, 0.0, 0.0]])
