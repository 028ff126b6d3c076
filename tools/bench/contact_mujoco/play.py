"""Play between the sensor and the tool."""

from __future__ import annotations

from itertools import product

import mujoco
import numpy as np

from contact_mujoco import pressing, scene
from contact_mujoco.arm import Arm
from contact_mujoco.conditions import Conditions
from contact_mujoco.pressing import Rig, Wall
from contact_mujoco.robots import DOWN, PANDA, Array
from contact_mujoco.score import score
from contact_mujoco.tables import VERDICT, short, table, terms, verdict

PLAY_BALL_KG = 0.2
"""Mass of a ball that has play, kg."""
STOPS = 3e6
"""Stiffness of the ends of the play, N/m."""


class Loose(Rig):
    """The tool has play along its axis: the ball slides between two stops, with a little friction."""

    def __init__(self, conditions: Conditions, play_m: float) -> None:
        """`play_m`: distance between the stops, m."""
        self._play_m = play_m
        super().__init__(conditions)

    def model(self) -> mujoco.MjModel:
        """Returns the model; the axis of the joint is vertical at the start."""
        robot = self.conditions.robot
        free = scene.model(robot)
        data = mujoco.MjData(free)
        data.qpos[:] = robot.start
        mujoco.mj_kinematics(free, data)
        axis = scene.numbers(data.site("sensor").xmat.reshape(3, 3).T @ DOWN)
        stops = f'solimplimit="{scene.IMPEDANCE} {scene.IMPEDANCE} 0.001 0.5 2" solreflimit="-1 -1"'
        way = f'range="{-self._play_m} 0" limited="true" frictionloss="0.3"'
        joint = f'<joint name="play" type="slide" axis="{axis}" {way} {stops}/>'
        ball = scene.BALL.replace("1e-9", f"{PLAY_BALL_KG}")
        model = scene.model(
            robot, scene.wall(np.zeros(3), -DOWN), f'<body name="ball" gravcomp="1">{joint}{ball}</body>'
        )
        set_stops(model)
        return model

    def stand(self) -> Wall:
        """Returns the wall; the weight of the ball is tared."""
        self.arm.tare[2] = 9.81 * PLAY_BALL_KG
        return super().stand()

    def forces(self, arm: Arm, wrenches: Array) -> Array:
        """Returns the force between ball and wall at the end of the period: the sensor measures its inertia too."""
        data = arm.data
        depth = data.mocap_pos[0, 2] - data.geom("tool").xpos[2] + scene.TOOL_RADIUS_M
        return np.full(len(wrenches), max(0.0, self.conditions.stiffness * depth))


def set_stops(model: mujoco.MjModel) -> None:
    """Gives both stops of the play their stiffness."""
    data = mujoco.MjData(model)
    joint = model.joint("play").id
    data.qpos[model.jnt_qposadr[joint]] = pressing.DEPTH_M
    mujoco.mj_forward(model, data)
    rows = np.flatnonzero(data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT))
    model.jnt_solref[joint] = scene.spring(data, int(rows[0]), STOPS)


def play() -> str:
    """Returns the table of tools with play."""
    rows = []
    for way, stiffness in product((5e-5, 2e-4, 1e-3), (1e3, 1e4, 1e5, 1e6)):
        conditions = terms(PANDA, stiffness, speed=0.01)
        found = score(conditions, pressing.press(Loose(conditions, way)))
        rows.append([f"{way * 1e3}", short(stiffness), *verdict(found)])
    return table(["play, mm", "K, N/m", *VERDICT], rows)
