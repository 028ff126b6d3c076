"""Kinematics and a processor step for LeRobot, with the names and units of LeRobot: degrees and 4 × 4 matrices.

    from revprio.lerobot import RobotKinematics      # in place of lerobot.model.kinematics
    kinematics = RobotKinematics("so101.urdf", "gripper_frame_link", motor_names)

The methods are those of `lerobot.model.kinematics.RobotKinematics` 0.4. They need neither placo nor LeRobot. The
inverse kinematics iterates until it arrives, within the ranges of the joints, and never raises for a target out of
reach.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from revprio.ee_actions import EEToJoints, RobotKinematics

if TYPE_CHECKING:
    from revprio.lerobot_step import EEToJointsStep

__all__ = ["EEToJoints", "RobotKinematics", "as_processor_step"]


def as_processor_step(step: EEToJoints) -> EEToJointsStep:
    """Returns the step as a `RobotActionProcessorStep` of LeRobot, for its pipelines. Needs `lerobot`."""
    from revprio.lerobot_step import EEToJointsStep  # noqa: PLC0415 - LeRobot is not a dependency

    return EEToJointsStep.around(step)
