"""An arm in MuJoCo behind a velocity loop that computes torques, and its force sensor."""

from __future__ import annotations

import copy
from collections import deque
from dataclasses import dataclass

import mujoco
import numpy as np

from contact_mujoco.robots import Array

SENSOR_LAG_S = 0.002
"""τ_f, time constant of the force sensor, s."""


@dataclass(frozen=True)
class Drive:
    """The velocity loop: q̈ = q̈_r + 2 ω (q̇_r − q̇) + ω² (q_r − q), by computed torques with gravity.

    The reference q̇_r follows the command after the delay, with the lag.
    """

    bandwidth: float
    """ω, rad/s."""
    lag_s: float = 0.0
    """L, s."""
    delay_periods: int = 0
    """D."""


class Arm:
    """The arm of a model; `period_s`: T; `timestep_s`: step of the physics and of the velocity loop."""

    def __init__(self, model: mujoco.MjModel, start: Array, drive: Drive, period_s: float, timestep_s: float) -> None:
        """Puts the arm at rest in a posture."""
        self.model, self.drive = model, drive
        self.substeps = round(period_s / timestep_s)
        self.timestep_s = period_s / self.substeps
        model.opt.timestep = self.timestep_s
        self.data = mujoco.MjData(model)
        self.joints = start.size
        self.data.qpos[: self.joints] = start
        mujoco.mj_forward(model, self.data)
        self.site = model.site("sensor").id
        self.reference = start.copy()
        """Reference q_r of the velocity loop, n, rad."""
        self._rate = np.zeros(self.joints)
        self._waiting = deque([np.zeros(self.joints)] * drive.delay_periods)
        self._torque = np.zeros(model.nv)
        self._limits = model.actuator_ctrlrange[:, 1].copy()
        self.tare = np.zeros(6)
        """Wrench that the sensor does not show, 6, base frame, N and N·m."""
        self.filtered = np.zeros(6)
        """Wrench behind the filter of the sensor, 6, base frame, N and N·m, on the environment."""

    def copy(self) -> Arm:
        """Returns an arm in the same state; the model is the same."""
        other = copy.copy(self)
        other.data = copy.copy(self.data)
        other._waiting = deque(self._waiting)
        other._torque = self._torque.copy()
        other.filtered = self.filtered.copy()
        return other

    @property
    def position(self) -> Array:
        """Joint positions q, n, rad."""
        return np.array(self.data.qpos[: self.joints])

    @property
    def velocity(self) -> Array:
        """Joint velocities q̇, n, rad/s."""
        return np.array(self.data.qvel[: self.joints])

    @property
    def point(self) -> Array:
        """Place of the tool point, base frame, 3, m."""
        return np.array(self.data.site_xpos[self.site])

    def wrench(self) -> Array:
        """Returns the wrench of the tool on what it touches, about the tool point, 6, base frame, N and N·m.

        It is that of a sensor between arm and tool, so it has the weight and the inertia of the tool in it, without
        `tare`.
        """
        axes = self.data.site_xmat[self.site].reshape(3, 3)
        return np.asarray((self.data.sensordata[:6].reshape(2, 3) @ axes.T).ravel() - self.tare)

    def follow(self, command: Array) -> Array:
        """Simulates one period with commanded joint velocities, rad/s; returns the wrench of each step, steps × 6."""
        self._waiting.append(np.array(command, dtype=float))
        wanted = self._references(self._waiting.popleft())
        model, data, joints = self.model, self.data, self.joints
        omega, kept = self.drive.bandwidth, np.exp(-self.timestep_s / SENSOR_LAG_S)
        position, velocity = data.qpos[:joints], data.qvel[:joints]
        acceleration = np.zeros(model.nv)
        wrenches = np.zeros((self.substeps, 6))
        for step in range(self.substeps):
            mujoco.mj_step1(model, data)
            acceleration[:joints] = wanted[step] - 2 * omega * velocity - omega**2 * position
            mujoco.mj_mulM(model, data, self._torque, acceleration)
            torque = self._torque[:joints] + data.qfrc_bias[:joints]
            data.ctrl[:] = np.clip(torque, -self._limits, self._limits)
            if np.any(np.abs(torque) > self._limits):
                wanted[step:] += self._give_way(torque)
            mujoco.mj_step2(model, data)
            wrenches[step] = self.wrench()
            self.filtered = wrenches[step] + kept * (self.filtered - wrenches[step])
        return wrenches

    def _give_way(self, torque: Array) -> Array:
        """Moves the reference to where the loop would ask for what the motors give; returns the change of q̈, n.

        Without that, the position part winds up while a torque is at its limit.
        """
        missing = np.zeros((1, self.model.nv))
        missing[0, : self.joints] = self.data.ctrl - torque
        change = np.zeros_like(missing)
        mujoco.mj_solveM(self.model, self.data, change, missing)
        self.reference = self.reference + change[0, : self.joints] / self.drive.bandwidth**2
        return np.asarray(change[0, : self.joints])

    def _references(self, command: Array) -> Array:
        """Returns q̈_r + 2 ω q̇_r + ω² q_r of each step, steps × n, and moves the reference on."""
        omega, lag, dt = self.drive.bandwidth, self.drive.lag_s, self.timestep_s
        kept = np.exp(-dt / lag) if lag > 0 else 0.0
        rates = command + kept ** np.arange(self.substeps + 1)[:, None] * (self._rate - command)
        # Without a lag the velocity jumps, and no torque follows its derivative.
        accelerations = np.diff(rates, axis=0) / dt if lag > 0 else 0.0
        ways = dt * (0.5 * (rates[1:] + rates[:-1]) if lag > 0 else rates[1:])
        positions = self.reference + np.cumsum(ways, axis=0)
        self.reference, self._rate = positions[-1], rates[-1]
        return np.asarray(accelerations + 2 * omega * rates[1:] + omega**2 * positions)
