"""The asyncio client has the same methods as the blocking client and gives the same answers."""

import asyncio
import inspect
from pathlib import Path

import numpy as np
import pytest
from conftest import FaultyProxy, example, serve

import revprio
from revprio import (
    AsyncClient,
    Client,
    ControllerConfig,
    InvalidError,
    LateAnswerError,
    Measurement,
    NotFoundError,
    Problem,
    ResolveAnswer,
    ResolveRequest,
    ResolveTask,
    Scenario,
    Session,
    StreamedTarget,
    UnauthorizedError,
    Watchdog,
    aio,
)
from revprio.bodies import FloatArray
from revprio.simulations import SimulationRun

Q = np.array([2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2])
CONFIG = ControllerConfig.model_validate(example("controller"))
PUSH = ResolveTask(axes=["x"], velocity=[0.05])


@pytest.mark.parametrize(
    ("blocking", "asynchronous"),
    [
        (revprio.Client, aio.AsyncClient),
        (revprio.Session, aio.AsyncSession),
        (revprio.Stateless, aio.AsyncStateless),
        (revprio.Stream, aio.AsyncStream),
        (SimulationRun, aio.AsyncSimulationRun),
    ],
)
def test_both_have_the_same_methods_with_the_same_arguments(blocking: type, asynchronous: type) -> None:
    def methods(kind: type) -> dict[str, list[str]]:
        functions = inspect.getmembers(kind, inspect.isfunction)
        public = {name: list(inspect.signature(f).parameters) for name, f in functions if not name.startswith("_")}
        # `async with` opens what the blocking constructor opens.
        return {name: parameters for name, parameters in public.items() if name != "open"}

    assert methods(blocking) == methods(asynchronous)


def test_an_asynchronous_controller_sends_targets(url: str) -> None:
    async def call() -> str | None:
        async with AsyncClient(url) as client, client.stateless(**example("controller")) as controller:
            answer = await controller.step(Q, wrench=np.zeros(6), targets={"push": StreamedTarget(force=[10.0])})
            return answer.tasks[0].target_state

    assert asyncio.run(call()) == "following"


def test_both_give_the_same_answers(url: str) -> None:
    async def call() -> list[FloatArray]:
        async with AsyncClient(url) as client:
            request = ResolveRequest(robot="sawyer_dh", joint_position=Q, tasks=[PUSH])
            resolved = await client.resolve(robot="sawyer_dh", joint_position=Q, tasks=[PUSH])
            first, second = await client.resolve_batch([request, ResolveRequest(robot="unknown", tasks=[PUSH])])
            assert isinstance(first, ResolveAnswer)
            assert isinstance(second, Problem)
            with pytest.raises(InvalidError):
                await client.resolve(robot="unknown", tasks=[PUSH])
            names = [robot.name for robot in await client.robots()]
            assert (await client.robot("sawyer_dh")).name in names
            assert (await client.scenario("stiff_wall")).name in [entry.name for entry in await client.scenarios()]
            assert await client.is_ready()
            jacobian = (await client.kinematics(robot="sawyer_dh", joint_position=Q)).jacobian
            return [resolved.joint_velocity, first.joint_velocity, jacobian]

    with Client(url) as client:
        resolved = client.resolve(robot="sawyer_dh", joint_position=Q, tasks=[PUSH]).joint_velocity
        jacobian = client.kinematics(robot="sawyer_dh", joint_position=Q).jacobian
    for actual, expected in zip(asyncio.run(call()), [resolved, resolved, jacobian], strict=True):
        np.testing.assert_array_equal(actual, expected)


def test_controllers_give_the_same_answers_as_the_blocking_ones(url: str) -> None:
    wrench = [1, 0, 0, 0, 0, 0]

    async def call() -> list[FloatArray]:
        async with AsyncClient(url, step_timeout_s=30) as client:
            async with aio.AsyncSession(client, CONFIG) as session, session.stream() as stream:
                by_session = [await controller.step(Q, wrench=wrench) for controller in (session, stream, session)]
                assert (await session.status()).steps == 3
            with pytest.raises(NotFoundError):
                await session.status()
            stateless = aio.AsyncStateless(client, CONFIG)
            by_memory = [await stateless.step(Q, wrench=wrench) for _ in range(3)]
            return [answer.joint_velocity for answer in by_session + by_memory]

    with Client(url, step_timeout_s=30) as client, Session(client, CONFIG) as session:
        expected = [session.step(Q, wrench=wrench).joint_velocity for _ in range(3)]
    np.testing.assert_array_equal(asyncio.run(call()), expected * 2)


def test_a_simulation_runs(url: str) -> None:
    async def call() -> int:
        async with AsyncClient(url) as client:
            run = await client.simulate(scenario=Scenario.model_validate(example("simulation_own")["scenario"]))
            assert (await run.result()).metrics is not None
            periods = len((await run.trace())["time_s"])
            await run.cancel()
            return periods

    assert asyncio.run(call()) == 50


def test_the_token_is_sent(tmp_path: Path) -> None:
    async def call(url: str) -> None:
        async with AsyncClient(url) as client:
            with pytest.raises(UnauthorizedError):
                await client.robots()
        async with AsyncClient(url, token="s" * 32) as client:
            assert await client.robots()

    token = tmp_path / "token"
    token.write_text("s" * 32)
    token.chmod(0o600)
    with serve("--token-file", str(token)) as (url, _):
        asyncio.run(call(url))


def test_an_arm_comes_to_rest_when_answers_stop(proxy: FaultyProxy) -> None:
    commands = [np.zeros(7)]
    config = CONFIG.model_copy(update={"period_s": 0.01})

    async def read() -> Measurement:
        if commands[-1].any():
            proxy.stall()
        return Measurement(Q, wrench=np.zeros(6))

    async def run() -> None:
        async with AsyncClient(proxy.url, step_timeout_s=1.0, retries=0) as client:
            session = aio.AsyncSession(client, config)
            await session.open()
            with pytest.raises(LateAnswerError):
                await aio.drive(session, read, commands.append, watchdog=Watchdog(np.full(7, 8.0)))
            proxy.resume()

    asyncio.run(run())
    assert np.abs(commands).max() > 0
    assert not commands[-1].any()
