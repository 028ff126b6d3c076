"""Threads, forks and other processes."""

import copy
import multiprocessing
import os
import pickle
import threading
import time

import numpy as np
import pytest

import revprio
from revprio import AddressError, Client, InvalidError, NoAnswerError, RevprioError
from revprio.errors import ForeignAnswerError, LateAnswerError, problem_error
from revprio.models import Problem

Q = np.array([0.3, -0.6, 0.2, 1.4, 0.1, 0.9, 0.0])
PUSH = revprio.push("x", 15)


def problem(status: int) -> RevprioError:
    body = Problem(type="/problems/invalid", title="Invalid field", status=status, detail="no", pointer="/axes")
    return problem_error(body, 2.5)


ERRORS = [
    RevprioError("text"), NoAnswerError("http://a", "down"), LateAnswerError("http://a", OSError(3)),
    ForeignAnswerError("http://a", 502, "html"), AddressError("::"), *map(problem, (401, 404, 409, 418, 422, 503)),
]  # fmt: skip


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_errors_are_pickled_with_their_fields(error: RevprioError) -> None:
    for other in (pickle.loads(pickle.dumps(error)), copy.copy(error), copy.deepcopy(error)):
        assert type(other) is type(error)
        assert (str(other), other.is_silence) == (str(error), error.is_silence)
        assert vars(other) == vars(error)


def refused(axis: str) -> None:
    revprio.ResolveTask(axes=axis)  # type: ignore[arg-type]


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_a_pool_gets_the_error_of_its_process(method: str) -> None:
    with multiprocessing.get_context(method).Pool(1) as pool:
        answer = pool.apply_async(refused, ("q",))
        with pytest.raises(InvalidError) as caught:
            answer.get(60)
    assert caught.value.pointer == "/axes/0"


def test_a_running_controller_is_not_copied() -> None:
    arm = revprio.Controller(robot="sawyer_dh", period_s=0.001, tasks=PUSH)
    for make in (pickle.dumps, copy.copy, copy.deepcopy):
        with pytest.raises(TypeError, match="config"):
            make(arm)
    pickle.loads(pickle.dumps(arm.config))


def child(act: object) -> int:
    """Runs `act` in a fork; returns its exit code, 9 if it hangs."""
    process = os.fork()
    if process == 0:
        try:
            os._exit(act())  # type: ignore[operator]
        finally:
            os._exit(8)
    for _ in range(500):
        ended, status = os.waitpid(process, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    os.kill(process, 9)
    os.waitpid(process, 0)
    return 9


def test_after_a_fork_both_processes_have_a_controller() -> None:
    arm = revprio.Controller(robot="sawyer_dh", period_s=0.001, tasks=PUSH)
    first = arm.step(Q, wrench=np.zeros(6)).joint_velocity

    def step() -> int:
        same = np.array_equal(arm.step(Q, wrench=np.zeros(6)).joint_velocity, expected)
        return 0 if same else 1

    other = revprio.Controller(robot="sawyer_dh", period_s=0.001, tasks=PUSH)
    assert np.array_equal(other.step(Q, wrench=np.zeros(6)).joint_velocity, first)
    expected = other.step(Q, wrench=np.zeros(6)).joint_velocity
    assert child(step) == 0
    assert np.array_equal(arm.step(Q, wrench=np.zeros(6)).joint_velocity, expected)


def test_after_a_fork_each_process_has_connections_of_its_own(client: Client) -> None:
    assert client.is_ready()
    before = client._http
    assert child(lambda: 0 if client.is_ready() and client._http is not before else 1) == 0
    assert client._http is before


def test_a_fork_during_a_step_of_another_thread_does_not_block_the_child() -> None:
    arm = revprio.Controller(robot="sawyer_dh", period_s=0.001, tasks=PUSH)
    ends = threading.Event()

    def run() -> None:
        while not ends.is_set():
            arm.step(Q, wrench=np.zeros(6))

    def step() -> int:
        try:
            arm.step(Q, wrench=np.zeros(6))
        except RuntimeError:
            return 3
        return 0

    thread = threading.Thread(target=run)
    thread.start()
    try:
        codes = {child(step) for _ in range(40)}
    finally:
        ends.set()
        thread.join()
    assert codes <= {0, 3}


def test_a_client_opens_its_own_connections_in_a_fork() -> None:
    with revprio.serve() as served, Client(served.url) as client:
        assert client.is_ready()
        names = [robot.name for robot in client.robots()]
        sockets = client._http

        def call() -> int:
            same = [robot.name for robot in client.robots()] == names
            return 0 if same and client._http is not sockets else 1

        assert child(call) == 0
        assert [robot.name for robot in client.robots()] == names
        assert client._http is sockets
