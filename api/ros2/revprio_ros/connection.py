"""Sessions of a controller, at a service or in this process. Calls run in a thread, so the loop never waits long."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import revprio

CALL_TIMEOUT_S = 2.0
"""Time limit for opening a session, s."""
STEP_TIMEOUT_S = 0.1
"""Time limit of a step, s. An answer is not valid for longer."""


class Connection:
    """Opens sessions of one controller and steps the newest one."""

    def __init__(self, config: revprio.ControllerConfig, url: str, token: str | None) -> None:
        """`url`: address of the service; empty: this process. Nothing is sent before the first call."""
        options = {"token": token, "timeout_s": CALL_TIMEOUT_S, "step_timeout_s": STEP_TIMEOUT_S, "retries": 0}
        self.client: Any = revprio.connect(url, **options) if url else revprio.connect()
        self._config = config
        self._session: Any = None
        self._calls = ThreadPoolExecutor(1, "revprio")

    def open(self) -> Future[tuple[list[str], list[str], revprio.Robot]]:
        """Ends the last session and opens a new one. Returns the joints, warnings, and the robot."""
        return self._calls.submit(self._open)

    def step(self, arguments: dict[str, Any]) -> Future[revprio.StepAnswer]:
        """Runs one control period."""
        return self._calls.submit(self._session.step, **arguments)

    def call(self, function: Callable[[], Any]) -> Any:
        """Runs a function after all calls before it, and returns its result."""
        return self._calls.submit(function).result()

    def close(self) -> None:
        """Ends the session and the thread."""
        self._calls.submit(self._end_session)
        self._calls.shutdown()
        self.client.close()

    def _open(self) -> tuple[list[str], list[str], revprio.Robot]:
        self._end_session()
        fields = {name: getattr(self._config, name) for name in self._config.model_fields_set}
        session = self.client.Controller(**fields)
        robot = self.client.robot(self._config.robot)
        self._session = session
        return session.joints, session.warnings, robot

    def _end_session(self) -> None:
        """Ends the session. If that fails, the service ends it when it is idle."""
        if self._session is not None:
            with suppress(revprio.RevprioError):
                self._session.close()
            self._session = None
