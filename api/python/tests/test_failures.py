"""What a client sees when something is wrong: with the token, the line, the load or the service itself."""

import http.server
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from conftest import Line, example, serve
from numpy.typing import NDArray

from revprio import (
    Client,
    ControllerConfig,
    ForeignAnswerError,
    InvalidError,
    LateAnswerError,
    Measurement,
    NoAnswerError,
    ResolveTask,
    Session,
    UnauthorizedError,
    UnavailableError,
    Watchdog,
    drive,
)

Q = np.array([2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2])
CONFIG = ControllerConfig.model_validate(example("controller"))
SLOW = CONFIG.model_copy(update={"period_s": 0.01})


def test_a_service_that_is_not_there_is_named() -> None:
    with (
        Client("http://127.0.0.1:9", retries=1) as client,
        pytest.raises(NoAnswerError, match="is the service running"),
    ):
        client.robots()
    assert not Client("http://127.0.0.1:9").is_ready()


def test_a_token_opens_what_is_closed_without(tmp_path: Path) -> None:
    token = tmp_path / "token"
    token.write_text("s" * 32)
    token.chmod(0o600)
    with serve("--token-file", str(token)) as (url, _):
        for wrong in (None, "t" * 32):
            with Client(url, token=wrong) as client, pytest.raises(UnauthorizedError) as refused:
                client.robots()
            assert refused.value.status == 401
            assert "Authorization" in refused.value.remedy
        with Client(url, token="s" * 32) as client, Session(client, CONFIG) as session, session.stream() as stream:
            assert stream.step(Q, wrench=np.zeros(6)).sequence == 0


def test_a_full_service_says_when_to_come_again() -> None:
    with serve("--max-sessions", "1") as (url, _), Client(url, retries=0) as client, Session(client, CONFIG):
        with pytest.raises(UnavailableError) as refused:
            Session(client, CONFIG)
        assert refused.value.status == 503
        assert refused.value.retry_after_s == 1
        assert refused.value.is_silence


class Busy(http.server.BaseHTTPRequestHandler):
    """Answers 503 to the first requests, then as a service does."""

    protocol_version = "HTTP/1.1"
    left = 2
    after = "0"

    def do_GET(self) -> None:
        Busy.left -= 1
        if Busy.left >= 0:
            problem = b'{"type": "/problems/overloaded", "title": "t", "status": 503, "detail": "too much"}'
            self._send(503, problem, {"retry-after": Busy.after})
        else:
            self._send(200, b'{"robots": []}', {})

    def _send(self, status: int, body: bytes, headers: dict[str, str]) -> None:
        self.send_response(status)
        for name, value in {**headers, "content-length": str(len(body))}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def busy() -> Iterator[str]:
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Busy) as server:
        server.daemon_threads = True
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def test_what_a_busy_service_has_not_taken_is_sent_again(busy: str) -> None:
    Busy.left, Busy.after = 2, "0"
    with Client(busy, retries=2) as client:
        assert client.robots() == []
    Busy.left = 3
    with Client(busy, retries=2) as client, pytest.raises(UnavailableError, match="too much"):
        client.robots()


def test_a_pause_that_is_longer_than_the_patience_is_not_made(busy: str) -> None:
    Busy.left, Busy.after = 1, "3600"
    with Client(busy) as client, pytest.raises(UnavailableError) as refused:
        client.robots()
    assert refused.value.retry_after_s == 3600
    assert Busy.left == 0


def test_an_answer_of_something_else_is_not_taken_for_one(busy: str) -> None:
    Busy.left = 0
    with Client(busy) as client:
        with pytest.raises(ForeignAnswerError, match="not as a revprio service"):
            client.scenarios()
        with pytest.raises(ForeignAnswerError):
            client.resolve(tasks=[ResolveTask(axes=["x"], velocity=[1])])  # it has no POST


@pytest.mark.parametrize("how", ["session", "stream"])
def test_an_answer_that_does_not_come_in_time_is_late(line: Line, how: str) -> None:
    with (
        Client(line.url) as client,
        Session(client, CONFIG) as session,
        session if how == "session" else session.stream() as controller,
    ):
        controller.step(Q, wrench=np.zeros(6))
        line.stall()
        with pytest.raises(LateAnswerError):
            controller.step(Q, wrench=np.zeros(6))
        line.resume()
        assert controller.step(Q, wrench=np.zeros(6)).sequence == 2


class Arm:
    """An arm that does what it is told, remembers it, and lets something happen once it moves."""

    def __init__(self, once_it_moves: Callable[[], None]) -> None:
        self.q, self.told, self.times = Q, [np.zeros(7)], [time.monotonic()]
        self.happened_at: int | None = None
        self._happen = once_it_moves

    def read(self) -> Measurement:
        if self.happened_at is None and self.told[-1].any():
            self.happened_at = len(self.told)
            self._happen()
        return Measurement(self.q, wrench=np.zeros(6))

    def write(self, command: NDArray[np.float64]) -> None:
        now_s = time.monotonic()
        self.q = self.q + (now_s - self.times[-1]) * command
        self.told.append(command)
        self.times.append(now_s)

    def assert_braked(self, limits: NDArray[np.float64]) -> None:
        """After what happened no joint speeds up or brakes harder than its limit, and all end at rest."""
        assert self.happened_at is not None
        speeds = np.abs(self.told)
        assert not speeds[-1].any()
        # A command was computed after the one before it was heard, and before it was heard itself.
        for k in range(self.happened_at + 1, len(speeds)):
            assert (speeds[k] <= speeds[k - 1] + 1e-12).all()
            assert (speeds[k - 1] - speeds[k] <= limits * (self.times[k] - self.times[k - 2]) + 1e-12).all()


class EnoughError(Exception):
    """Ends a loop."""


def enough() -> None:
    raise EnoughError


def limits_of(client: Client) -> NDArray[np.float64]:
    joints = client.robot("sawyer_dh").joints
    return np.array([joint.acceleration_limit for joint in joints], dtype=float)


def test_a_drive_that_is_interrupted_ends_at_rest(url: str) -> None:
    arm = Arm(once_it_moves=enough)
    with Client(url) as client, Session(client, SLOW) as session:
        limits = limits_of(client)
        with pytest.raises(EnoughError):
            drive(session, arm.read, arm.write, watchdog=Watchdog(limits))
    arm.assert_braked(limits)


def test_a_drive_lasts_as_long_as_it_shall(url: str) -> None:
    arm = Arm(once_it_moves=lambda: None)
    with Client(url) as client, Session(client, SLOW) as session:
        report = drive(session, arm.read, arm.write, watchdog=Watchdog(np.full(7, 8.0)), duration_s=0.1)
    assert 0 < report.periods <= 10
    assert 0 <= report.answered <= report.periods
    assert not arm.told[-1].any()


@pytest.mark.parametrize("how", ["session", "stream"])
def test_an_arm_comes_to_rest_within_its_limits_when_answers_stop(url: str, line: Line, how: str) -> None:
    arm = Arm(once_it_moves=line.stall)
    with Client(url) as direct, Client(line.url, step_timeout_s=1.0, retries=0) as client:
        limits = limits_of(direct)
        session = Session(client, SLOW)
        with session if how == "session" else session.stream() as controller:
            with pytest.raises(LateAnswerError):
                drive(controller, arm.read, arm.write, watchdog=Watchdog(limits))
            line.resume()
    arm.assert_braked(limits)


def test_an_arm_comes_to_rest_when_the_service_dies() -> None:
    with serve() as (url, process), Client(url) as client:
        arm = Arm(once_it_moves=process.kill)
        limits = limits_of(client)
        with pytest.raises(NoAnswerError), Session(client, SLOW) as session:
            drive(session, arm.read, arm.write, watchdog=Watchdog(limits))
    arm.assert_braked(limits)


def test_an_arm_goes_on_when_answers_return(line: Line) -> None:
    arm = Arm(once_it_moves=line.stall)

    def read() -> Measurement:
        state = arm.read()
        silence = len(arm.told) - (arm.happened_at or len(arm.told))
        if silence == 5:
            line.resume()
        if silence > 5 and np.abs(arm.told[-1] - arm.told[-2]).max() > 0.05 * (arm.times[-1] - arm.times[-3]) + 1e-12:
            enough()  # more than a ramp
        return state

    with Client(line.url) as client, Session(client, SLOW) as session, pytest.raises(EnoughError):
        drive(session, read, arm.write, watchdog=Watchdog(np.full(7, 0.05)))
    assert not arm.told[-1].any()


def test_a_refused_state_ends_the_drive_at_rest(url: str) -> None:
    arm = Arm(once_it_moves=lambda: None)

    def read() -> Measurement:
        state = arm.read()
        return state if arm.happened_at is None else Measurement(arm.q[:3], wrench=np.zeros(6))

    with Client(url) as client, Session(client, SLOW) as session:
        limits = limits_of(client)
        with pytest.raises(InvalidError) as refused:
            drive(session, read, arm.write, watchdog=Watchdog(limits))
    assert refused.value.pointer == "/joint_position"
    arm.assert_braked(limits)
