"""A step for the pipelines of LeRobot that turns end-effector actions into joint actions. Needs `lerobot`.

    from revprio.lerobot_step import EEToJointsStep
    step = EEToJointsStep("so101.urdf", motor_names, max_speed_deg_s=90.0)
    pipeline = RobotProcessorPipeline(
        [step], to_transition=robot_action_observation_to_transition, to_output=transition_to_robot_action
    )

A saved pipeline contains the name of this class and its arguments; `from_pretrained` imports it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lerobot.configs.types import FeatureType, PipelineFeatureType, PolicyFeature
from lerobot.processor import RobotActionProcessorStep, TransitionKey

from revprio.ee_actions import EEToJoints, RobotKinematics

POSE = ("x", "y", "z", "wx", "wy", "wz", "gripper_pos")
"""Entries of an action that the step replaces, each after `ee.`."""


class EEToJointsStep(RobotActionProcessorStep):  # type: ignore[misc]
    """The step `EEToJoints`, as a class of LeRobot that can be saved and loaded."""

    def __init__(
        self,
        urdf_path: str,
        motor_names: list[str],
        target_frame_name: str = "gripper_frame_link",
        joint_names: list[str] | None = None,
        **speeds: float | Mapping[str, float],
    ) -> None:
        """The arguments are those of `RobotKinematics`; `speeds`: `period_s` and the speeds of `EEToJoints`."""
        kinematics = RobotKinematics(urdf_path, target_frame_name, joint_names)
        self.step = EEToJoints(kinematics, motor_names, **speeds)  # type: ignore[arg-type]

    @classmethod
    def around(cls, step: EEToJoints) -> EEToJointsStep:
        """Returns this class around a step that exists."""
        result = cls.__new__(cls)
        result.step = step
        return result

    def action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Returns the joint action."""
        return self.step.process(action, self.transition.get(TransitionKey.OBSERVATION) or {})

    def reset(self) -> None:
        """Starts the next action from its observation."""
        self.step.reset()

    def get_config(self) -> dict[str, Any]:
        """Returns the arguments that make this step, for the file of a pipeline."""
        step, kinematics = self.step, self.step.kinematics
        speed = step.max_speed_deg_s
        return {
            "urdf_path": kinematics.urdf_path,
            "motor_names": list(step.motor_names),
            "target_frame_name": kinematics.target_frame_name,
            "joint_names": list(kinematics.joint_names),
            "period_s": step.period_s,
            "max_speed_deg_s": dict(speed) if isinstance(speed, Mapping) else speed,
            "max_gripper_speed": step.max_gripper_speed,
        }

    def transform_features(self, features: Any) -> Any:  # noqa: ANN401 - a type of LeRobot
        """Replaces the features of the end effector by those of the motors."""
        actions = features[PipelineFeatureType.ACTION]
        for name in POSE:
            actions.pop(f"ee.{name}", None)
        for name in self.step.motor_names:
            actions[f"{name}.pos"] = PolicyFeature(type=FeatureType.ACTION, shape=(1,))
        return features
