"""The processor step in a pipeline of LeRobot; without the package, against the signatures that LeRobot documents."""

import importlib
import json
import math
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from conftest import ROOT
from test_lerobot import NAMES, PANDA, START, ee_action

from revprio.lerobot import EEToJoints, RobotKinematics, as_processor_step

MOTORS = [*NAMES, "gripper"]
OBSERVATION = {f"{name}.pos": value for name, value in zip(MOTORS, [*START, 10.0], strict=True)}
ARGUMENTS: dict[str, Any] = {
    "urdf_path": PANDA, "motor_names": MOTORS, "target_frame_name": "panda_link8", "joint_names": NAMES,
    "max_speed_deg_s": 90.0,
}  # fmt: skip


class TransitionKey(StrEnum):
    """The keys of a transition that the step reads."""

    OBSERVATION = "observation"
    ACTION = "action"


class FeatureType(StrEnum):
    ACTION = "ACTION"


class PipelineFeatureType(StrEnum):
    ACTION = "ACTION"


@dataclass
class PolicyFeature:
    type: FeatureType
    shape: tuple[int, ...]


class RobotActionProcessorStep:
    """What LeRobot 0.4 documents: a call copies the transition, and replaces its action by that of `action`."""

    transition: dict[Any, Any]

    def __call__(self, transition: dict[Any, Any]) -> dict[Any, Any]:
        self.transition = transition.copy()
        self.transition[TransitionKey.ACTION] = self.action(transition[TransitionKey.ACTION].copy())
        return self.transition

    def action(self, action: dict[str, Any]) -> dict[str, Any]:
        raise NotImplementedError


def stand_in() -> dict[str, ModuleType]:
    """Returns modules with the documented signatures."""
    names = ("lerobot", "lerobot.configs", "lerobot.configs.types", "lerobot.processor")
    modules = {name: ModuleType(name) for name in names}
    types: tuple[type, ...] = (FeatureType, PipelineFeatureType, PolicyFeature)
    processor: tuple[type, ...] = (RobotActionProcessorStep, TransitionKey)
    for module, parts in (("lerobot.configs.types", types), ("lerobot.processor", processor)):
        for part in parts:
            setattr(modules[module], part.__name__, part)
    return modules


@pytest.fixture
def lerobot(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Returns `lerobot.processor`: the real package, or the stand-in."""
    try:
        importlib.import_module("lerobot.processor")
    except ImportError:
        for name, module in stand_in().items():
            monkeypatch.setitem(sys.modules, name, module)
        sys.modules.pop("revprio.lerobot_step", None)
    yield sys.modules["lerobot.processor"]
    sys.modules.pop("revprio.lerobot_step", None)


def goal(metres: float = 0.3) -> np.ndarray:
    """Returns a pose beside that of the start."""
    pose = RobotKinematics(PANDA, "panda_link8", NAMES).forward_kinematics(START)
    pose[1, 3] += metres
    return pose


def test_a_transition_keeps_its_other_parts_and_gets_a_bounded_joint_action(lerobot: Any) -> None:  # noqa: ANN401
    step = as_processor_step(EEToJoints(RobotKinematics(PANDA, "panda_link8", NAMES), MOTORS, max_speed_deg_s=90.0))
    action, observation = lerobot.TransitionKey.ACTION, lerobot.TransitionKey.OBSERVATION
    given: dict[Any, Any] = {action: ee_action(goal(), 90.0), observation: OBSERVATION, "reward": 3}
    answer = step(given)
    assert set(answer[action]) == set(OBSERVATION)
    moved = [abs(answer[action][f"{name}.pos"] - OBSERVATION[f"{name}.pos"]) for name in NAMES]
    assert max(moved) == pytest.approx(90.0 / 30)
    assert answer["reward"] == 3
    assert "ee.x" in given[action]
    step.reset()
    assert step.step.last is None


def test_the_features_become_those_of_the_motors(lerobot: Any) -> None:  # noqa: ANN401, ARG001
    types = sys.modules["lerobot.configs.types"]
    step = as_processor_step(EEToJoints(RobotKinematics(PANDA, "panda_link8", NAMES), MOTORS))
    feature = types.PolicyFeature(type=types.FeatureType.ACTION, shape=(1,))
    kept = dict.fromkeys((*ee_action(goal()), "note"), feature)
    features = step.transform_features({types.PipelineFeatureType.ACTION: kept})
    assert set(features[types.PipelineFeatureType.ACTION]) == {*OBSERVATION, "note"}


def test_a_step_is_made_from_its_config(lerobot: Any) -> None:  # noqa: ANN401, ARG001
    step_class = importlib.import_module("revprio.lerobot_step").EEToJointsStep
    step = step_class(**ARGUMENTS)
    config = json.loads(json.dumps(step.get_config()))
    assert step_class(**config).get_config() == config
    assert {name: config[name] for name in ARGUMENTS} == ARGUMENTS
    by_joint = step_class(**(ARGUMENTS | {"max_speed_deg_s": dict.fromkeys(NAMES, 45.0)}))
    assert json.loads(json.dumps(by_joint.get_config()))["max_speed_deg_s"][NAMES[0]] == 45.0


@pytest.mark.parametrize("wrong", [{}, {"panda_joint3.pos": math.nan}, {"gripper.pos": None}])
def test_a_first_action_needs_to_know_where_the_arm_is(wrong: dict[str, object]) -> None:
    step = EEToJoints(RobotKinematics(PANDA, "panda_link8", NAMES), MOTORS)
    with pytest.raises(ValueError, match=r"the first action needs .*\.pos"):
        step.process(ee_action(goal()), OBSERVATION | wrong if wrong else {})
    assert step.last is None
    step.process(ee_action(goal()), OBSERVATION)
    assert np.isfinite(list(step.process(ee_action(goal()), {}).values())).all()


def pipeline(lerobot: Any) -> Any:  # noqa: ANN401
    """Returns a pipeline of the real package."""
    if not hasattr(lerobot, "RobotProcessorPipeline"):
        pytest.skip("needs lerobot 0.4")
    converters = importlib.import_module("lerobot.processor.converters")
    step_class = importlib.import_module("revprio.lerobot_step").EEToJointsStep
    return lerobot.RobotProcessorPipeline(
        steps=[step_class(**ARGUMENTS)],
        name="follower",
        to_transition=converters.robot_action_observation_to_transition,
        to_output=converters.transition_to_robot_action,
    )


def test_a_pipeline_of_the_real_package_reaches_the_pose(lerobot: Any) -> None:  # noqa: ANN401
    robot_action = pipeline(lerobot)
    answer = OBSERVATION
    for _ in range(60):
        answer = robot_action((ee_action(goal(), 90.0), answer))
    kinematics = RobotKinematics(PANDA, "panda_link8", NAMES)
    reached = kinematics.forward_kinematics([answer[f"{name}.pos"] for name in NAMES])
    assert np.abs(reached[:3, 3] - goal()[:3, 3]).max() < 1e-3
    assert answer["gripper.pos"] == 90.0
    robot_action.reset()
    assert robot_action.steps[0].step.last is None


def test_the_real_step_of_inverse_kinematics_takes_the_kinematics(lerobot: Any) -> None:  # noqa: ANN401
    """LeRobot's own step, with `revprio.lerobot.RobotKinematics` in place of its kinematics."""
    pipeline(lerobot)
    real = pytest.importorskip("lerobot.robots.so_follower.robot_kinematic_processor")
    step = real.InverseKinematicsEEToJoints(RobotKinematics(PANDA, "panda_link8", NAMES), MOTORS)
    answer = OBSERVATION
    for _ in range(40):
        key = lerobot.TransitionKey
        answer = step({key.ACTION: ee_action(goal(0.05), 90.0), key.OBSERVATION: answer})[key.ACTION]
    reached = RobotKinematics(PANDA, "panda_link8", NAMES).forward_kinematics([answer[f"{n}.pos"] for n in NAMES])
    assert np.abs(reached[:3, 3] - goal(0.05)[:3, 3]).max() < 1e-3


def test_a_saved_pipeline_is_loaded_where_revprio_was_not_imported(lerobot: Any, tmp_path: Path) -> None:  # noqa: ANN401
    pipeline(lerobot).save_pretrained(tmp_path)
    program = f"""
import json, sys
from lerobot.processor import RobotProcessorPipeline
from lerobot.processor.converters import robot_action_observation_to_transition, transition_to_robot_action
loaded = RobotProcessorPipeline.from_pretrained(
    {str(tmp_path)!r}, "follower.json", overrides={{"EEToJointsStep": {{"max_speed_deg_s": 30.0}}}},
    to_transition=robot_action_observation_to_transition, to_output=transition_to_robot_action)
action, observation = json.load(sys.stdin)
print(json.dumps(loaded((action, observation))))
"""
    given = json.dumps([ee_action(goal()), OBSERVATION])
    done = subprocess.run(
        [sys.executable, "-c", program], input=given, capture_output=True, text=True, check=True, cwd=ROOT
    )
    answer = json.loads(done.stdout.splitlines()[-1])
    moved = [abs(answer[f"{name}.pos"] - OBSERVATION[f"{name}.pos"]) for name in NAMES]
    assert max(moved) == pytest.approx(1.0)
