"""A torque-controlled Sawyer arm in MuJoCo in front of a wall, and the tasks that press on the wall.

README.md in this directory lists the differences to the built-in simulator and explains the gains.
"""

from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray
from sawyer_mjcf import posture, sawyer_with_wall

import revprio
from revprio import ConstantProfile, ControllerTask, EnvironmentAxis, ForceLaw, ImpedanceLaw

URDF = Path(__file__).resolve().parents[3] / "fixtures/robots/sawyer.urdf"
PERIOD_S = 0.002
"""Control period T, s."""
TIMESTEP_S = 0.0005
"""Time step of the physics and of the inner velocity loop, s."""
GAP_M = 0.01
"""Distance from the tool to the wall at the start, m."""
CONTACT_TIME_S = 0.016
"""Time constant of MuJoCo's contact, s."""
FRICTION_N_M = 0.5
"""Coulomb friction in each joint, N·m; only the integral part of the inner loop compensates it."""
LAG_S = 0.005
"""Lag of the inner loop without friction and torque limits, s."""
TARGET_N = 30.0
WALL_N_PER_M = 1e5
"""Wall stiffness for which the gains are chosen, N/m; the stiffness in MuJoCo is only known after the run."""

Array = NDArray[np.float64]


class Sawyer:
    """The arm in MuJoCo with an inner velocity loop: computed torque with a proportional and an integral part."""

    def __init__(self) -> None:
        """Creates the arm, and a wall `GAP_M` in front of its tool."""
        start = revprio.kinematics(robot="sawyer", joint_position=posture()).pose.position
        self._wall_x_m = float(np.asarray(start)[0]) + GAP_M
        mjcf = sawyer_with_wall(URDF, self._wall_x_m, TIMESTEP_S, CONTACT_TIME_S, FRICTION_N_M)
        self._model = mujoco.MjModel.from_xml_string(mjcf)
        self._data = mujoco.MjData(self._model)
        self.reset()

    def reset(self) -> None:
        """Sets the arm at rest in the nominal posture."""
        mujoco.mj_resetData(self._model, self._data)
        self._data.qpos[:] = posture()
        mujoco.mj_forward(self._model, self._data)
        self._integral = np.zeros(7)

    @property
    def position(self) -> Array:
        """Joint position q, 7, rad."""
        return np.array(self._data.qpos)

    @property
    def velocity(self) -> Array:
        """Joint velocity q̇, 7, rad/s."""
        return np.array(self._data.qvel)

    @property
    def depth_m(self) -> float:
        """Distance of the tool behind the surface of the wall, m."""
        return float(self._data.geom("tool").xpos[0] - self._wall_x_m)

    def wrench(self) -> Array:
        """Returns the wrench of the tool on the wall, 6, base frame, N and N·m; the torque of a sphere is 0."""
        wrench = np.zeros(6)
        for index in range(self._data.ncon):
            contact_force = np.zeros(6)
            mujoco.mj_contactForce(self._model, self._data, index, contact_force)
            # MuJoCo gives the force in the contact frame. Its first axis points from the wall to the tool.
            wrench[:3] += self._data.contact[index].frame.reshape(3, 3).T @ contact_force[:3]
        return wrench

    def follow(self, command: Array) -> None:
        """Simulates one period with commanded joint velocities, rad/s."""
        for _ in range(round(PERIOD_S / TIMESTEP_S)):
            error = command - self._data.qvel
            self._integral += TIMESTEP_S * error
            acceleration = (error + self._integral / (4 * LAG_S)) / LAG_S
            torque = np.zeros(7)
            mujoco.mj_mulM(self._model, self._data, torque, acceleration)
            self._data.ctrl[:] = torque + self._data.qfrc_bias
            mujoco.mj_step(self._model, self._data)


def pushing() -> list[ControllerTask]:
    """Returns a force task along x and an impedance task for the other axes.

    The damping of the force law is 1.5 times the minimum that is stable with this contact stiffness and lag.
    """
    wall = EnvironmentAxis(stiffness=WALL_N_PER_M)
    margin = revprio.stability(
        inertia=15, damping=150, environment=wall, period_s=PERIOD_S, lag_s=LAG_S, delay_periods=1
    )
    assert margin.smallest_damping is not None
    law = ForceLaw(inertia=15, damping=1.5 * margin.smallest_damping, target_force=ConstantProfile(value=TARGET_N))
    hold = ImpedanceLaw(
        inertia=[15, 15, 80, 80, 80], damping=[150, 150, 280, 280, 280], stiffness=[1000, 1000, 100, 100, 100],
        target_pose="initial",
    )  # fmt: skip
    return [
        ControllerTask(name="push", axes=["x"], law=law),
        ControllerTask(name="hold", axes=["y", "z", "rx", "ry", "rz"], law=hold),
    ]
