"""The control loop: sessions, the watchdog, and what happens without answers. It does not import ROS."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, wait
from enum import Enum
from typing import Any

import revprio
from numpy import zeros

from revprio_ros.connection import Connection
from revprio_ros.conversion import NotUsable

RETRY_S = 0.5
"""Time between two attempts to open a session, s."""
WAIT_SHARE = 0.6
"""Share of the period in which the loop waits for the answer."""

Read = Callable[[list[str]], tuple[dict[str, Any], float]]
"""Returns the arguments of `Controller.step` for these joints, without `time_s`, and the time of the measurement, s.
Raises a `NotUsable`."""


class Phase(Enum):
    """What the loop does."""

    WAITING = "waits at rest"
    RUNNING = "controls the arm"
    BRAKING = "brakes to rest"
    HALTED = "halted at rest"


class Control:
    """One command per period.

    - At rest it waits for fresh inputs, opens a session, and goes on with its first answer.
    - Without answers or fresh inputs the watchdog holds the last command while it is valid, then it brakes. If an
      answer comes before the arm is at rest, the motion goes on; otherwise with a new session.
    - If the service refuses a state, the arm brakes at once, and goes on with a new session.
    - After `halt` the arm brakes and stays at rest.
    """

    def __init__(self, connection: Connection, period_s: float) -> None:
        """Starts at rest; nothing is sent before `update`."""
        self._connection, self._period_s = connection, period_s
        self._pending: Future[Any] | None = None
        self._pending_is_step = False
        self._measured_s = 0.0
        self._last_s = self._retry_s = self._valid_until_s = float("-inf")
        self._has_session = self._has_answer = self._is_halted = False
        self._watchdog: revprio.Watchdog | None = None
        self.start_s: float | None = None
        """Start of `time_s` of the states, on the loop's clock, s."""
        self.joints: list[str] = []
        """Names of the joints in the order of the commands; empty before the first session."""
        self.robot: revprio.Robot | None = None
        """The robot of the newest session."""
        self.phase = Phase.WAITING
        self.problem = ""
        """What prevents control; empty if nothing does."""
        self.warnings: list[str] = []
        """Warnings about the controller."""
        self.answer: revprio.StepAnswer | None = None
        """The newest answer."""
        self.settled = 0
        """Number of states that the service has answered or refused so far."""
        self.sessions = self.answered = 0
        """Number of sessions and of answers so far."""

    @property
    def is_free(self) -> bool:
        """Whether the next state is sent: no answer is awaited."""
        return self._pending is None

    def update(self, now: Callable[[], float], check_fresh: Callable[[], None], read: Read) -> None:
        """Runs one period. Raises the refusal of a controller that has never run."""
        if now() < self._last_s:
            self._restart_clock(now())
        self._last_s = now()
        self._end_after_silence(now())
        self._finish_pending(now())
        if self.phase is Phase.WAITING:
            self._wait(now(), check_fresh)
        if self.phase is Phase.RUNNING:
            self._run(now, read)
        if self.phase is Phase.BRAKING and self._is_at_rest(now()):
            self.rest()

    def state(self, now_s: float) -> Phase:
        """Returns what the loop does for its user: it waits for the first answer, and brakes without a new one."""
        if self.phase is not Phase.RUNNING:
            return self.phase
        if not self._has_answer:
            return Phase.WAITING
        return Phase.BRAKING if now_s + self._period_s > self._valid_until_s else Phase.RUNNING

    def command(self, now_s: float) -> list[float]:
        """Returns the joint velocities from now until the next period, rad/s or m/s."""
        if self._watchdog is None or self.phase in (Phase.WAITING, Phase.HALTED):
            return list(zeros(len(self.joints)))
        return list(map(float, self._watchdog.command(now_s + self._period_s)))

    def halt(self, problem: str, now_s: float) -> None:
        """Brakes to rest and stays there. The problem of the first halt stays."""
        self._brake(problem, now_s)
        self._is_halted = True

    def _restart_clock(self, now_s: float) -> None:
        """Brakes after a jump of simulated time. A ramp that has begun ends at once, because its time is lost."""
        self._retry_s = now_s
        if self.state(self._last_s) is Phase.RUNNING:
            self._brake("the clock went back", now_s)
        else:
            self.rest()

    def rest(self) -> None:
        """Takes the arm for one at rest, and ends its session, whose next command could continue the old motion."""
        self.phase, self._has_session = Phase.HALTED if self._is_halted else Phase.WAITING, False

    def _wait(self, now_s: float, check_fresh: Callable[[], None]) -> None:
        try:
            check_fresh()
        except NotUsable as error:
            self.problem = str(error)
            return
        if self._has_session:
            self.phase = Phase.RUNNING
        elif self._pending is None and now_s >= self._retry_s:
            self._retry_s = now_s + RETRY_S
            self._pending, self._pending_is_step = self._connection.open(), False

    def _run(self, now: Callable[[], float], read: Read) -> None:
        try:
            arguments, measured_s = read(self.joints)
        except NotUsable as error:
            self.problem = str(error)
        else:
            if self.phase is Phase.RUNNING:  # `read` can halt the loop.
                self._send(arguments, measured_s)
        if self._pending is not None:
            wait([self._pending], WAIT_SHARE * self._period_s)
            self._finish_pending(now())
        self._end_after_silence(now())

    def _end_after_silence(self, now_s: float) -> None:
        """Ends a session that the watchdog has brought to rest."""
        if self.phase is Phase.RUNNING and self._has_answer and self._is_at_rest(now_s):
            self.rest()

    def _send(self, arguments: dict[str, Any], measured_s: float) -> None:
        if self._pending is None:
            self.start_s = measured_s if self.start_s is None else self.start_s
            self._measured_s = measured_s
            self._pending = self._connection.step({**arguments, "time_s": measured_s - self.start_s})
            self._pending_is_step = True

    def _finish_pending(self, now_s: float) -> None:
        if self._pending is None or not self._pending.done():
            return
        call, self._pending = self._pending, None
        try:
            result = call.result()
        except revprio.RevprioError as error:
            self.settled += self._pending_is_step and not error.is_silence
            self._fail(error, now_s)
        else:
            self.settled += self._pending_is_step
            self._obey(result, now_s) if self._pending_is_step else self._begin(*result)

    def _begin(self, joints: list[str], warnings: list[str], robot: revprio.Robot) -> None:
        """Starts a session. Its time begins with its first state."""
        if self.joints and joints != self.joints:
            self.halt(f"the robot of the service has other joints than before: {', '.join(joints)}", self._last_s)
            return
        self.joints, self.robot, self.warnings, self.start_s = joints, robot, warnings, None
        self._watchdog = revprio.Watchdog.of(robot)
        self._has_session, self._has_answer = True, False
        self.sessions += 1

    def _obey(self, answer: revprio.StepAnswer, now_s: float) -> None:
        """Accepts an answer, if it is still valid and the arm is not braking for another reason."""
        if self.phase is not Phase.RUNNING or self._watchdog is None:
            return
        if self._watchdog.obey(answer, self._measured_s, now_s):
            self.answer, self._has_answer, self.problem = answer, True, ""
            self._valid_until_s = self._measured_s + answer.valid_for_ms / 1e3
            self.answered += 1
        else:
            self.problem = "an answer came after the end of its validity; the service or the network is too slow"

    def _fail(self, error: revprio.RevprioError, now_s: float) -> None:
        """Brakes if a state was refused. Without an answer, the watchdog brakes when the last one has expired."""
        if self.phase is Phase.RUNNING and not error.is_silence:
            self._brake(str(error), now_s)
        elif self.phase in (Phase.RUNNING, Phase.WAITING):
            self.problem = str(error)
        if self.sessions == 0 and not error.is_silence:
            raise error

    def _brake(self, problem: str, now_s: float) -> None:
        self.problem = self.problem if self._is_halted else problem
        if self._watchdog is not None:
            self._watchdog.expire(now_s)
        self.phase = Phase.BRAKING

    def _is_at_rest(self, now_s: float) -> bool:
        return self._watchdog is None or self._watchdog.is_at_rest(now_s)
