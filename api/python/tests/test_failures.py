"""Failures of the token, the connection and the service, overload, and their effect on the arm."""

import http.server
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from conftest import FaultyProxy, example, serve
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


def test_the_error_of_an_unreachable_service_suggests_a_cause() -> None:
    with (
        Client("http://127.0.0.1:9", retries=1) as client,
        pytest.raises(NoAnswerError, match="is the service running"),
    ):
        client.robots()
    assert not Client("http://127.0.0.1:9").is_ready()


@pytest.mark.parametrize("token", ["ü" * 32, "s" * 32 + "\nt"])
def test_a_token_that_cannot_be_sent_is_refused_without_being_shown(token: str) -> None:
    with pytest.raises(ValueError, match="characters that cannot be sent") as refused:
        Client(token=token)
    assert token[:32] not in str(refused.value)


def test_a_service_with_a_token_refuses_clients_without_it(tmp_path: Path) -> None:
    token = tmp_path / "token"
    token.write_text("s" * 32 + "\n")
    token.chmod(0o600)
    with serve("--token-file", str(token)) as (url, _):
        with Client(url, token=token.read_text()) as client:
            assert client.robots()
        for wrong in (None, "t" * 32):
            with Client(url, token=wrong) as client, pytest.raises(UnauthorizedError) as refused:
                client.robots()
            assert refused.value.status == 401
            assert "Authorization" in refused.value.remedy
        with Client(url, token="s" * 32) as client, Session(client, CONFIG) as session, session.stream() as stream:
            assert stream.step(Q, wrench=np.zeros(6)).sequence == 0


def test_a_full_service_reports_when_to_retry() -> None:
    with serve("--max-sessions", "1") as (url, _), Client(url, retries=0) as client, Session(client, CONFIG):
        with pytest.raises(UnavailableError) as refused:
            Session(client, CONFIG)
        assert refused.value.status == 503
        assert refused.value.retry_after_s == 1
        assert refused.value.is_silence


class Busy(http.server.BaseHTTPRequestHandler):
    """A server that answers 503 to the first `remaining` requests, and 200 to later ones."""

    protocol_version = "HTTP/1.1"
    remaining = 2
    retry_after = "0"

    def do_GET(self) -> None:
        Busy.remaining -= 1
        if Busy.remaining >= 0:
            problem = b'{"type": "/problems/overloaded", "title": "t", "status": 503, "detail": "too much"}'
            self._send(503, problem, {"retry-after": Busy.retry_after})
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


def test_a_request_that_was_refused_because_of_overload_is_sent_again(busy: str) -> None:
    Busy.remaining, Busy.retry_after = 2, "0"
    with Client(busy, retries=2) as client:
        assert client.robots() == []
    Busy.remaining = 3
    with Client(busy, retries=2) as client, pytest.raises(UnavailableError, match="too much"):
        client.robots()


def test_a_pause_beyond_the_time_limit_raises_at_once(busy: str) -> None:
    Busy.remaining, Busy.retry_after = 1, "3600"
    with Client(busy) as client, pytest.raises(UnavailableError) as refused:
        client.robots()
    assert refused.value.retry_after_s == 3600
    assert Busy.remaining == 0


def test_the_answer_of_another_server_is_rejected(busy: str) -> None:
    Busy.remaining = 0
    with Client(busy) as client:
        with pytest.raises(ForeignAnswerError, match="not from a revprio service"):
            client.scenarios()
        with pytest.raises(ForeignAnswerError):
            client.resolve(tasks=[ResolveTask(axes=["x"], velocity=[1])])  # the server has no POST


@pytest.mark.parametrize("how", ["session", "stream"])
def test_a_missing_answer_raises_late_answer_error(proxy: FaultyProxy, how: str) -> None:
    with (
        Client(proxy.url) as client,
        Session(client, CONFIG) as session,
        session if how == "session" else session.stream() as controller,
    ):
        controller.step(Q, wrench=np.zeros(6))
        proxy.stall()
        with pytest.raises(LateAnswerError):
            controller.step(Q, wrench=np.zeros(6))
        proxy.resume()
        assert controller.step(Q, wrench=np.zeros(6)).sequence == 2


class Arm:
    """An arm that follows its commands exactly and records them. It calls `on_first_motion` once it moves."""

    def __init__(self, on_first_motion: Callable[[], None]) -> None:
        self.q, self.commands, self.times = Q, [np.zeros(7)], [time.monotonic()]
        self.event_index: int | None = None
        self._on_first_motion = on_first_motion

    def read(self) -> Measurement:
        if self.event_index is None and self.commands[-1].any():
            self.event_index = len(self.commands)
            self._on_first_motion()
        return Measurement(self.q, wrench=np.zeros(6))

    def write(self, command: NDArray[np.float64]) -> None:
        now_s = time.monotonic()
        self.q = self.q + (now_s - self.times[-1]) * command
        self.commands.append(command)
        self.times.append(now_s)

    def assert_braked(self, limits: NDArray[np.float64]) -> None:
        """Asserts that after the event no joint speeds up or exceeds its braking limit, and that all end at rest."""
        assert self.event_index is not None
        speeds = np.abs(self.commands)
        assert not speeds[-1].any()
        # Command k was computed after command k - 2 was written, and before command k was written. The first command of
        # the ramp is that of a period later, however short the period before was.
        for k in range(self.event_index + 1, len(speeds)):
            elapsed_s = max(self.times[k] - self.times[k - 2], SLOW.period_s)
            assert (speeds[k] <= speeds[k - 1] + 1e-12).all()
            assert (speeds[k - 1] - speeds[k] <= limits * elapsed_s + 1e-12).all()


class StopLoopError(Exception):
    """Ends a loop."""


def stop_loop() -> None:
    raise StopLoopError


def acceleration_limits(client: Client) -> NDArray[np.float64]:
    joints = client.robot("sawyer_dh").joints
    return np.array([joint.acceleration_limit for joint in joints], dtype=float)


def test_a_drive_that_is_interrupted_ends_at_rest(url: str) -> None:
    arm = Arm(on_first_motion=stop_loop)
    with Client(url) as client, Session(client, SLOW) as session:
        limits = acceleration_limits(client)
        with pytest.raises(StopLoopError):
            drive(session, arm.read, arm.write, watchdog=Watchdog(limits))
    arm.assert_braked(limits)


def test_a_drive_ends_after_its_duration(url: str) -> None:
    arm = Arm(on_first_motion=lambda: None)
    with Client(url) as client, Session(client, SLOW) as session:
        report = drive(session, arm.read, arm.write, watchdog=Watchdog(np.full(7, 8.0)), duration_s=0.1)
    assert 0 < report.periods <= 10
    assert 0 <= report.answered <= report.periods
    assert not arm.commands[-1].any()


@pytest.mark.parametrize("how", ["session", "stream"])
def test_an_arm_comes_to_rest_within_its_limits_when_answers_stop(url: str, proxy: FaultyProxy, how: str) -> None:
    arm = Arm(on_first_motion=proxy.stall)
    with Client(url) as direct, Client(proxy.url, step_timeout_s=1.0, retries=0) as client:
        limits = acceleration_limits(direct)
        session = Session(client, SLOW)
        with session if how == "session" else session.stream() as controller:
            with pytest.raises(LateAnswerError):
                drive(controller, arm.read, arm.write, watchdog=Watchdog(limits))
            proxy.resume()
    arm.assert_braked(limits)


def test_an_arm_comes_to_rest_when_the_service_is_killed() -> None:
    with serve() as (url, process), Client(url) as client:
        arm = Arm(on_first_motion=process.kill)
        limits = acceleration_limits(client)
        with pytest.raises(NoAnswerError), Session(client, SLOW) as session:
            drive(session, arm.read, arm.write, watchdog=Watchdog(limits))
    arm.assert_braked(limits)


def test_an_arm_continues_when_answers_return(proxy: FaultyProxy) -> None:
    arm = Arm(on_first_motion=proxy.stall)

    def read() -> Measurement:
        state = arm.read()
        silent_periods = len(arm.commands) - (arm.event_index or len(arm.commands))
        if silent_periods == 5:
            proxy.resume()
        if (
            silent_periods > 5
            and np.abs(arm.commands[-1] - arm.commands[-2]).max() > 0.05 * (arm.times[-1] - arm.times[-3]) + 1e-12
        ):
            stop_loop()  # the command changed by more than the ramp allows
        return state

    with Client(proxy.url) as client, Session(client, SLOW) as session, pytest.raises(StopLoopError):
        drive(session, read, arm.write, watchdog=Watchdog(np.full(7, 0.05)))
    assert not arm.commands[-1].any()


def test_a_refused_state_ends_the_drive_at_rest(url: str) -> None:
    arm = Arm(on_first_motion=lambda: None)

    def read() -> Measurement:
        state = arm.read()
        return state if arm.event_index is None else Measurement(arm.q[:3], wrench=np.zeros(6))

    with Client(url) as client, Session(client, SLOW) as session:
        limits = acceleration_limits(client)
        with pytest.raises(InvalidError) as refused:
            drive(session, read, arm.write, watchdog=Watchdog(limits))
    assert refused.value.pointer == "/joint_position"
    arm.assert_braked(limits)
