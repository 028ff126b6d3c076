"""Commands of the watchdog while answers come and after they stop."""

import numpy as np
import pytest
from conftest import example

from revprio import Robot, StepAnswer, Watchdog

BODY = {
    **example("answers/step"),
    "joint_velocity": [0.4, -0.1],
    "valid_for_ms": 100,
    "stop_time_s": None,
    "braking_deceleration": [],
}
ANSWER = StepAnswer.model_validate(BODY)


def test_nothing_moves_before_the_first_answer() -> None:
    watchdog = Watchdog([2.0, 2.0])
    assert not watchdog.command(0.0).any()
    assert watchdog.is_at_rest(0.0)


def test_the_first_answer_counts_at_once_although_rest_was_commanded_before() -> None:
    # The service takes its first answer for the command; a slower one would always stay behind.
    watchdog = Watchdog([2.0, 4.0])
    watchdog.command(9.0)
    watchdog.command(10.0)
    watchdog.obey(ANSWER, 10.0, 10.01)
    np.testing.assert_array_equal(watchdog.command(10.01), [0.4, -0.1])


def test_an_answer_after_an_expired_first_one_is_reached_evenly() -> None:
    # The service counts with the expired answer, so the next one may be far from rest.
    watchdog = Watchdog([2.0, 4.0])
    watchdog.command(9.9)
    assert not watchdog.obey(ANSWER, 9.8, 9.95)
    assert watchdog.obey(ANSWER, 10.0, 10.0)
    np.testing.assert_allclose(watchdog.command(10.0), [0.2, -0.1], atol=1e-9)


def test_an_answer_is_held_while_valid_then_each_joint_brakes_at_its_own_limit() -> None:
    watchdog = Watchdog([2.0, 4.0])
    watchdog.obey(ANSWER, 10.0, 10.0)
    np.testing.assert_array_equal(watchdog.command(10.1), [0.4, -0.1])
    assert not watchdog.is_at_rest(10.1)
    np.testing.assert_allclose(watchdog.command(10.11), [0.38, -0.06], atol=1e-9)
    np.testing.assert_allclose(watchdog.command(10.2), [0.2, 0.0], atol=1e-9)
    np.testing.assert_array_equal(np.abs(watchdog.command(10.31)), [0.0, 0.0])
    assert watchdog.is_at_rest(10.31)


def test_rounding_does_not_prolong_the_return() -> None:
    # A joint without acceleration limit may jump as soon as the service counts the return as over.
    watchdog = Watchdog([2.0, 4.0])
    watchdog.obey(ANSWER, 10.0, 10.0)
    watchdog.command(10.2)
    reached = ANSWER.model_copy(update={"joint_velocity": np.array([0.22 + 1e-12, 0.0])})
    assert watchdog.obey(reached, 10.21, 10.21)
    watchdog.command(10.21)
    faster = ANSWER.model_copy(update={"joint_velocity": np.array([1.0, 1.0])})
    assert watchdog.obey(faster, 10.22, 10.22)
    np.testing.assert_array_equal(watchdog.command(10.22), [1.0, 1.0])


def test_all_joints_come_to_rest_together_if_the_answer_says_when() -> None:
    watchdog = Watchdog([2.0, 4.0])
    watchdog.obey(StepAnswer.model_validate({**BODY, "stop_time_s": 0.2}), 10.0, 10.0)
    np.testing.assert_array_equal(watchdog.command(10.1), [0.4, -0.1])
    np.testing.assert_allclose(watchdog.command(10.15), [0.3, -0.075], atol=1e-9)
    assert not watchdog.is_at_rest(10.29)
    assert watchdog.is_at_rest(10.301)
    # Afterwards each joint accelerates at its own limit, and the next answer may brake otherwise.
    watchdog.command(10.3)
    assert watchdog.obey(ANSWER, 10.3, 10.3)
    np.testing.assert_allclose(watchdog.command(10.31), [0.02, -0.04], atol=1e-9)
    np.testing.assert_allclose(watchdog.command(10.5), [0.2, 0.0], atol=1e-9)


def test_a_newer_answer_ends_the_ramp_and_an_older_one_does_not() -> None:
    watchdog = Watchdog([2.0, 4.0])
    watchdog.obey(ANSWER, 10.0, 10.0)
    faster = ANSWER.model_copy(update={"joint_velocity": np.array([1.0, 1.0])})
    assert not watchdog.obey(faster, 9.95, 10.0)
    np.testing.assert_array_equal(watchdog.command(10.05), [0.4, -0.1])
    assert watchdog.obey(faster, 10.15, 10.16)
    np.testing.assert_array_equal(watchdog.command(10.2), [1.0, 1.0])


def test_after_a_ramp_the_joints_accelerate_to_the_new_answer() -> None:
    watchdog = Watchdog([2.0, 4.0])
    watchdog.obey(ANSWER, 10.0, 10.0)
    np.testing.assert_allclose(watchdog.command(10.2), [0.2, 0.0], atol=1e-9)
    opposite = ANSWER.model_copy(update={"joint_velocity": np.array([0.3, -1.0])})
    assert watchdog.obey(opposite, 10.2, 10.205)
    np.testing.assert_allclose(watchdog.command(10.21), [0.22, -0.04], atol=1e-9)
    np.testing.assert_allclose(watchdog.command(10.21), [0.22, -0.04], atol=1e-9)
    np.testing.assert_allclose(watchdog.command(10.25), [0.3, -0.2], atol=1e-9)
    np.testing.assert_allclose(watchdog.command(10.29), [0.3, -0.36], atol=1e-9)
    assert watchdog.obey(opposite, 10.4, 10.4)
    np.testing.assert_array_equal(watchdog.command(10.45), [0.3, -1.0])
    # From now on every answer counts at once, as long as answers come.
    assert watchdog.obey(ANSWER, 10.46, 10.46)
    np.testing.assert_array_equal(watchdog.command(10.46), [0.4, -0.1])


def test_an_arm_that_resumes_is_at_rest_only_when_its_commands_are_zero() -> None:
    watchdog = Watchdog([2.0, 4.0])
    watchdog.obey(ANSWER, 10.0, 10.0)
    watchdog.command(10.2)
    watchdog.obey(ANSWER.model_copy(update={"joint_velocity": np.zeros(2)}), 10.2, 10.2)
    watchdog.expire(10.2)
    assert not watchdog.is_at_rest(10.25)
    assert watchdog.is_at_rest(10.31)
    assert not watchdog.command(10.31).any()


def test_a_joint_without_deceleration_resumes_at_once() -> None:
    watchdog = Watchdog([np.inf, 4.0])
    watchdog.obey(ANSWER, 10.0, 10.0)
    assert not watchdog.command(10.2).any()
    watchdog.obey(ANSWER, 10.2, 10.2)
    np.testing.assert_array_equal(watchdog.command(10.2), [0.4, 0.0])


def test_an_answer_that_arrives_expired_is_ignored() -> None:
    watchdog = Watchdog([2.0, 4.0])
    assert not watchdog.obey(ANSWER, 10.0, 10.11)
    assert not watchdog.command(10.11).any()


def test_expire_starts_the_ramp_at_once() -> None:
    watchdog = Watchdog([2.0, 4.0])
    watchdog.obey(ANSWER, 10.0, 10.0)
    watchdog.expire(10.05)
    np.testing.assert_allclose(watchdog.command(10.1), [0.3, 0.0], atol=1e-9)


def test_limits_must_be_one_positive_number_per_joint() -> None:
    for wrong in ([], [0.0], [-1.0], [[1.0]], 1.0, [float("nan")]):
        with pytest.raises(ValueError, match="positive number per joint"):
            Watchdog(wrong)
    with pytest.raises(ValueError, match="2 joint velocities for 3 joints"):
        Watchdog([1, 1, 1]).obey(ANSWER, 0.0, 0.0)


def test_the_deceleration_of_the_answer_has_precedence() -> None:
    watchdog = Watchdog([2.0, 4.0])
    watchdog.obey(StepAnswer.model_validate({**BODY, "braking_deceleration": [8.0, None]}), 10.0, 10.0)
    np.testing.assert_allclose(watchdog.command(10.11), [0.32, -0.06], atol=1e-9)


def test_a_joint_without_any_deceleration_stops_at_once() -> None:
    joint = {"name": "j", "kind": "revolute", "unit": "rad"}
    robot = Robot.model_validate({"name": "r", "description": "", "source": "urdf", "joints": [joint]})
    watchdog = Watchdog.of(robot)
    watchdog.obey(StepAnswer.model_validate({**BODY, "joint_velocity": [0.4]}), 10.0, 10.0)
    assert watchdog.command(10.1) == [0.4]
    assert watchdog.command(10.101) == [0.0]
