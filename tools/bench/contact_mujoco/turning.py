"""Torques: the tool turns about an axis, and a ball at the end of a lever presses."""

from __future__ import annotations

from itertools import product

import mujoco
import numpy as np
import revprio
from revprio.models import ContactLaw

from contact_mujoco import pressing, scene
from contact_mujoco.conditions import NOISE_N
from contact_mujoco.pressing import Rig
from contact_mujoco.robots import DOWN, ROBOTS
from contact_mujoco.score import score
from contact_mujoco.tables import VERDICT, short, table, terms, verdict

LEVER_M = 0.1
"""Distance from the tool point to the ball that turns it, m."""
NOISE_NM = 0.02
"""σ of the torque, N·m."""


class Turning(Rig):
    """The tool turns about the axis y of the base, and a ball at the end of a lever presses on the wall.

    Torques count as forces at the ball: N·m over the lever.
    """

    row = np.array([0, 0, 0, 0, 1 / LEVER_M, 0])

    def model(self) -> mujoco.MjModel:
        """Returns a model whose ball is in front of the tool point, along x of the base."""
        robot = self.conditions.robot
        free = scene.model(robot)
        data = mujoco.MjData(free)
        data.qpos[:] = robot.start
        mujoco.mj_kinematics(free, data)
        place = LEVER_M * data.site("sensor").xmat.reshape(3, 3)[0]
        tool = scene.BALL.replace("<geom ", f'<geom pos="{scene.numbers(place)}" ')
        return scene.model(robot, scene.wall(np.zeros(3), -DOWN), tool)

    def tasks(self) -> list[revprio.ControllerTask]:
        """Returns the task that turns, and one that holds the rest."""
        torque, rate = LEVER_M * self.conditions.target, self.conditions.speed / LEVER_M
        law = ContactLaw(target_force=revprio.ConstantProfile(value=torque), approach_speed=rate)
        hold = revprio.PoseLaw(gain=2.0)
        return [
            revprio.ControllerTask(name="turn", axes=["ry"], law=law),
            revprio.ControllerTask(name="hold", axes=["x", "y", "z", "rx", "rz"], law=hold),
        ]

    def step(self) -> revprio.StepAnswer:
        """Adds the noise of the torque, which is 0.2 N at the ball."""
        wrench = self.arm.filtered.copy()
        wrench[:3] += NOISE_N * self._noise.normal(size=3)
        wrench[3:] += NOISE_NM * self._noise.normal(size=3)
        return self.law.step(self.arm.position, joint_velocity=self.arm.velocity, wrench=wrench)


def rotations() -> str:
    """Returns the table of torques."""
    rows = []
    for robot, torque in product(ROBOTS, (0.5, 3.0)):
        for stiffness, rate in product((1e3, 1e4, 1e5, 1e6), (0.1, 0.3, 1.0)):
            conditions = terms(robot, stiffness, speed=rate * LEVER_M, target=torque / LEVER_M)
            found = score(conditions, pressing.press(Turning(conditions)))
            cells = verdict(found)
            cells[3] = f"{found.error * LEVER_M:.3f}"
            rows.append([robot.name, torque, short(stiffness * LEVER_M**2), rate, *cells])
    head = ["arm", "torque, N·m", "K, N·m/rad", "approach, rad/s", *VERDICT]
    head[7] = "error, N·m"
    return table(head, rows)
