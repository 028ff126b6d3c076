"""What a client does that hears nothing from the service: it goes on for a while, then comes to rest."""

from __future__ import annotations

import numpy as np

from revprio.bodies import ArrayLike, FloatArray
from revprio.models import Robot, StepAnswer


class Watchdog:
    """Gives the joint velocities to command at any time, whether answers come or not.

    The last answer counts for `valid_for_ms` from the moment at which its *state* was measured. After that each joint
    slows down to rest with its largest acceleration, and stays there until a newer answer comes. Time is an argument,
    in seconds of any clock that does not go back, such as `time.monotonic()`.
    """

    def __init__(self, acceleration_limit: ArrayLike) -> None:
        """`acceleration_limit`: n, rad/s² or m/s²."""
        self._acceleration = np.asarray(acceleration_limit, dtype=np.float64)
        if self._acceleration.ndim != 1 or self._acceleration.size == 0 or not (self._acceleration > 0).all():
            message = f"acceleration_limit: give one positive number per joint, not {acceleration_limit!r}"
            raise ValueError(message)
        self._velocity = np.zeros_like(self._acceleration)
        self._measured_at_s = self._expires_at_s = -np.inf

    @classmethod
    def of(cls, robot: Robot) -> Watchdog:
        """With the acceleration limits of a robot, as `Client.robot` gives it."""
        limits = [joint.acceleration_limit for joint in robot.joints if joint.acceleration_limit is not None]
        if len(limits) < len(robot.joints):
            message = f"{robot.name}: not every joint has an acceleration limit; use Watchdog([…]) with your own"
            raise ValueError(message)
        return cls(limits)

    def obey(self, answer: StepAnswer, measured_at_s: float, now_s: float) -> bool:
        """Takes an answer that comes now (s) to a state that was measured before (s).

        `False` if it does not count: it has expired, or a state that was measured later was answered before.
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
        """Joint velocities to command at a time (s): n, rad/s or m/s."""
        silence_s = max(now_s - self._expires_at_s, 0.0)
        speed = np.maximum(np.abs(self._velocity) - self._acceleration * silence_s, 0.0)
        return np.copysign(speed, self._velocity)

    def expire(self, now_s: float) -> None:
        """Lets the ramp begin at a time (s), if it has not yet."""
        self._expires_at_s = min(self._expires_at_s, now_s)

    def is_at_rest(self, now_s: float) -> bool:
        """Whether the ramp is over at a time, s."""
        return now_s >= self._expires_at_s and not self.command(now_s).any()
