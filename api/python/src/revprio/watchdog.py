"""The watchdog: holds the last command while it is valid, then slows the arm down to rest."""

from __future__ import annotations

import numpy as np

from revprio.bodies import ArrayLike, FloatArray
from revprio.models import Robot, StepAnswer


class Watchdog:
    """Computes the joint velocities to command at any time, also when no answers come.

    An answer is valid for `valid_for_ms` from the moment at which its *state* was measured. After that, each joint
    slows down to rest at its maximum acceleration and stays at rest until a newer answer comes. All times are
    arguments, in seconds of any monotonic clock, such as `time.monotonic()`.
    """

    def __init__(self, acceleration_limit: ArrayLike) -> None:
        """`acceleration_limit`: maximum acceleration of each joint, n, rad/s² or m/s²."""
        self._acceleration = np.asarray(acceleration_limit, dtype=np.float64)
        if self._acceleration.ndim != 1 or self._acceleration.size == 0 or not (self._acceleration > 0).all():
            message = f"acceleration_limit: give one positive number per joint, not {acceleration_limit!r}"
            raise ValueError(message)
        self._velocity = np.zeros_like(self._acceleration)
        self._measured_at_s = self._expires_at_s = -np.inf

    @classmethod
    def of(cls, robot: Robot) -> Watchdog:
        """Creates a watchdog with the acceleration limits of a robot, as `Client.robot` returns it."""
        limits = [joint.acceleration_limit for joint in robot.joints if joint.acceleration_limit is not None]
        if len(limits) < len(robot.joints):
            message = f"{robot.name}: not every joint has an acceleration limit; use Watchdog([…]) with your own"
            raise ValueError(message)
        return cls(limits)

    def obey(self, answer: StepAnswer, measured_at_s: float, now_s: float) -> bool:
        """Accepts the answer that came at `now_s` to the state measured at `measured_at_s`.

        Returns `False` and ignores the answer if it has expired, or if an answer to a later state was accepted before.
        """
        if answer.joint_velocity.shape != self._acceleration.shape:
            message = f"{answer.joint_velocity.size} joint velocities for {self._acceleration.size} joints"
            raise ValueError(message)
        expires_at_s = measured_at_s + answer.valid_for_ms / 1e3
        if now_s > expires_at_s or measured_at_s < self._measured_at_s:
            return False
        self._velocity, self._measured_at_s, self._expires_at_s = answer.joint_velocity, measured_at_s, expires_at_s
        return True

    def command(self, now_s: float) -> FloatArray:
        """Returns the joint velocities to command at `now_s`: n, rad/s or m/s."""
        silence_s = max(now_s - self._expires_at_s, 0.0)
        speed = np.maximum(np.abs(self._velocity) - self._acceleration * silence_s, 0.0)
        return np.copysign(speed, self._velocity)

    def expire(self, now_s: float) -> None:
        """Starts the ramp to rest at `now_s`, if it has not started yet."""
        self._expires_at_s = min(self._expires_at_s, now_s)

    def is_at_rest(self, now_s: float) -> bool:
        """Returns whether the ramp is over and all joints are at rest at `now_s`."""
        return now_s >= self._expires_at_s and not self.command(now_s).any()
