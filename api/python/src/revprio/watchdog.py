"""The watchdog: holds the last command while it is valid, then brakes the arm to rest."""

from __future__ import annotations

import numpy as np

from revprio.bodies import ArrayLike, FloatArray
from revprio.models import Robot, StepAnswer

ROUNDING_S = 1e-9
"""Times that differ by less are equal, because sums of periods are not exact."""

ARRIVED = 1e-9
"""Velocities that differ by less are equal for the same reason, rad/s or m/s."""


class Watchdog:
    """Computes the joint velocities to command at any time, also when no answers come.

    An answer is valid for `valid_for_ms` from the moment at which its *state* was measured. After that, the joints
    brake together within the answer's `stop_time_s`, or each at `braking_deceleration` if the answer has none, and stay
    at rest until a newer answer comes. If the controller's limits include positions, every joint then stops inside its
    range. When answers come again, the joints accelerate with `braking_deceleration` until they have the velocity of
    the answer. All times are arguments, in seconds of any monotonic clock, such as `time.monotonic()`.
    """

    def __init__(self, acceleration_limit: ArrayLike) -> None:
        """`acceleration_limit`: deceleration of the joints, n, rad/s² or m/s², where the answer has none.

        The answer has precedence, because its `valid_for_ms` is correct for its own deceleration only.
        """
        self._acceleration = np.asarray(acceleration_limit, dtype=np.float64)
        if self._acceleration.ndim != 1 or self._acceleration.size == 0 or not (self._acceleration > 0).all():
            message = f"acceleration_limit: give one positive number per joint, not {acceleration_limit!r}"
            raise ValueError(message)
        self._deceleration = self._acceleration
        self._stop_time_s: float | None = None
        self._velocity = np.zeros_like(self._acceleration)
        self._measured_at_s = self._expires_at_s = -np.inf
        # The last command and its time, and whether commands must return from it to the answers.
        self._commanded, self._commanded_at_s = self._velocity, -np.inf
        self._resumes = self._has_answer = False

    @classmethod
    def of(cls, robot: Robot) -> Watchdog:
        """Creates a watchdog for a robot, as `Client.robot` returns it.

        A joint without any deceleration, in the answer or in the robot, stops at once.
        """
        if not hasattr(robot, "joints"):
            message = f"{robot!r} is no robot; give what `revprio.robot(…)` or `Client.robot(…)` returns"
            raise TypeError(message)
        limits = [joint.acceleration_limit for joint in robot.joints]
        return cls([np.inf if limit is None else limit for limit in limits])

    def obey(self, answer: StepAnswer, measured_at_s: float, now_s: float) -> bool:
        """Accepts the answer that came at `now_s` to the state measured at `measured_at_s`.

        Returns `False` and ignores the answer if it has expired, or if an answer to a later state was accepted before.
        """
        if answer.joint_velocity.shape != self._acceleration.shape:
            message = f"{answer.joint_velocity.size} joint velocities for {self._acceleration.size} joints"
            raise ValueError(message)
        expires_at_s = measured_at_s + answer.valid_for_ms / 1e3
        is_first, self._has_answer = not self._has_answer, True
        if now_s > expires_at_s or measured_at_s < self._measured_at_s:
            return False
        # Before the first answer there is no ramp to return from: the service counts with its answer at once.
        self._resumes |= not is_first and self._commanded_at_s - self._expires_at_s > ROUNDING_S
        self._velocity, self._measured_at_s, self._expires_at_s = answer.joint_velocity, measured_at_s, expires_at_s
        self._deceleration, self._stop_time_s = self._decelerations(answer), answer.stop_time_s
        return True

    def _decelerations(self, answer: StepAnswer) -> FloatArray:
        given = np.asarray(answer.braking_deceleration, dtype=np.float64)
        return np.where(np.isnan(given), self._acceleration, given) if given.size else self._acceleration

    def command(self, now_s: float) -> FloatArray:
        """Returns the joint velocities to command at `now_s`: n, rad/s or m/s.

        The arm keeps a command until the next one. In a loop, use the time of the next command instead of the present
        time: then the arm is never faster than the ramp. `drive` does so.
        """
        velocity = self._resumed(now_s)
        self._resumes = self._resumes and bool((np.abs(velocity - self._ramp(now_s)) > ARRIVED).any())
        self._commanded, self._commanded_at_s = velocity, now_s
        return velocity

    def _ramp(self, now_s: float) -> FloatArray:
        """Returns the velocities of the last answer; after it has expired, those of the ramp to rest."""
        silence_s = max(now_s - self._expires_at_s, 0.0)
        if silence_s <= ROUNDING_S:
            return self._velocity
        if self._stop_time_s is not None:
            return self._velocity * max(1.0 - silence_s / self._stop_time_s, 0.0)
        speed = np.maximum(np.abs(self._velocity) - self._deceleration * silence_s, 0.0)
        return np.copysign(speed, self._velocity)

    def _resumed(self, now_s: float) -> FloatArray:
        """Returns the ramp; after an interruption what is within reach from the last command."""
        velocity = self._ramp(now_s)
        if not self._resumes:
            return velocity
        elapsed_s = max(now_s - self._commanded_at_s, 0.0)
        reach = np.full_like(velocity, np.inf)
        np.multiply(self._deceleration, elapsed_s, out=reach, where=np.isfinite(self._deceleration))
        return np.clip(velocity, self._commanded - reach, self._commanded + reach)

    def expire(self, now_s: float) -> None:
        """Starts the ramp to rest at `now_s`, if it has not started yet."""
        self._expires_at_s = min(self._expires_at_s, now_s)

    def is_at_rest(self, now_s: float) -> bool:
        """Returns whether the ramp is over and all joints are at rest at `now_s`."""
        return now_s >= self._expires_at_s and not self._resumed(now_s).any()
