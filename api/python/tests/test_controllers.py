"""Controllers with memory: sessions, stateless controllers and streams."""

from typing import Any

import numpy as np
import pytest
from conftest import FaultyProxy, example
from numpy.typing import NDArray
from plant import Plant, assert_same_run, scenario, simulated

import revprio
from revprio import (
    Client,
    ConflictError,
    Controller,
    ControllerConfig,
    InvalidError,
    NotFoundError,
    ObstacleState,
    RestReading,
    Session,
    State,
    Stateless,
    StreamedTarget,
    Wrench,
)

Q = np.array([2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2])


def run(controller: Controller, periods: int = 20) -> NDArray[np.float64]:
    """Runs a closed loop whose force is 1000 N per rad of the first joint; returns the commands."""
    q, commands = Q, []
    for _ in range(periods):
        answer = controller.step(q, wrench=[1000 * (q[0] - Q[0]), 0, 0, 0, 0, 0])
        commands.append(answer.joint_velocity)
        q = q + controller.period_s * answer.joint_velocity
    return np.array(commands)


@pytest.fixture
def config() -> ControllerConfig:
    return ControllerConfig.model_validate(example("controller"))


def test_session_stateless_and_stream_give_identical_answers(client: Client, config: ControllerConfig) -> None:
    with Session(client, config) as session:
        by_session = run(session)
        assert session.status().last_sequence == 19
    with Stateless(client, config) as stateless:
        by_memory = run(stateless)
    with Session(client, config) as session, session.stream() as stream:
        by_stream = run(stream)
    np.testing.assert_array_equal(by_session, by_memory)
    np.testing.assert_array_equal(by_session, by_stream)
    assert np.abs(by_session).max() > 0


def test_targets_are_followed_by_sessions_stateless_controllers_and_streams(
    client: Client, config: ControllerConfig
) -> None:
    def follow(controller: Controller) -> list[tuple[str | None, float | None, list[float]]]:
        outcomes: list[tuple[str | None, float | None, list[float]]] = []
        for period in range(120):
            # The targets end after 60 ms.
            newest = {"push": StreamedTarget(force=[0.1 * period])} if period % 20 == 0 and period <= 60 else None
            answer = controller.step(Q, wrench=np.zeros(6), targets=newest)
            push = answer.tasks[0]
            outcomes.append((push.target_state, push.target_age_s, answer.joint_velocity.tolist()))
        return outcomes

    with Session(client, config) as session:
        by_session = follow(session)
    with Stateless(client, config) as stateless:
        assert follow(stateless) == by_session
    with Session(client, config) as session, session.stream() as stream:
        assert follow(stream) == by_session
    states = [state for state, _, _ in by_session]
    assert states[0] == "following"
    assert states[1] == states[109] == "extrapolating"
    assert states[112] == "holding"
    assert by_session[119][1] == pytest.approx(0.059)


def test_obstacles_are_sent_by_all_controllers(client: Client) -> None:
    room = ControllerConfig.model_validate(example("controller_room"))
    home = np.array([0.0, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8])
    ball = ObstacleState(name="ball", position=[0.36, 0.0, 0.5])

    def nearest(controller: Controller) -> tuple[str, float]:
        collisions = controller.step(home, obstacles=[ball]).collisions
        assert collisions is not None
        return collisions.pairs[0].b, collisions.pairs[0].distance_m

    with Session(client, room) as session:
        by_session = nearest(session)
    with Stateless(client, room) as stateless:
        assert nearest(stateless) == by_session
    with Session(client, room) as session, session.stream() as stream:
        assert nearest(stream) == by_session
    here = Controller(**room.model_dump(exclude_unset=True))
    assert nearest(here) == by_session
    assert by_session[0] == "ball"
    with pytest.raises(InvalidError) as refused:
        here.step(home)
    assert refused.value.pointer == "/obstacles"


def test_wrenches_of_tips_are_sent_by_all_controllers(client: Client) -> None:
    robot = example("robot_two_arms")
    client.register_robot(**{**robot, "name": "two-arms-wrenches"})
    revprio.register_robot(**{**robot, "name": "two-arms-wrenches"})
    law = {"kind": "impedance", "inertia": [1], "damping": [50], "stiffness": [500]}
    hands = [{"name": tip, "link": tip, "axes": ["x"], "law": law} for tip in ("left", "right")]
    config = ControllerConfig.model_validate({"robot": "two-arms-wrenches", "period_s": 0.004, "tasks": hands})
    q = np.array([0.1, 0.6, -0.9, 0.3, -0.5, 0.8, -0.2])
    pushed = Wrench(force=np.array([10.0, 0.0, 0.0]), torque=np.zeros(3))

    def velocities(controller: Controller) -> list[float]:
        answer = controller.step(q, wrenches={"left": np.zeros(6), "right": pushed})
        return [float(task.requested[0]) for task in answer.tasks]

    with Session(client, config) as session:
        by_session = velocities(session)
    with Stateless(client, config) as stateless:
        assert velocities(stateless) == by_session
    with Session(client, config) as session, session.stream() as stream:
        assert velocities(stream) == by_session
    here = Controller(**config.model_dump(exclude_unset=True))
    assert velocities(here) == by_session
    assert by_session[0] == 0.0
    assert by_session[1] < 0.0
    with pytest.raises(InvalidError) as refused:
        here.step(q, wrench=np.zeros(6))
    assert refused.value.pointer == "/wrenches/right"
    with pytest.raises(InvalidError) as refused:
        here.step(q, wrenches={"left": np.zeros(6), "right": np.zeros(5)})
    assert refused.value.pointer == "/wrenches/right"
    with pytest.raises(InvalidError) as refused:
        here.step(q, wrenches={"left/~": np.zeros(5)})
    assert refused.value.pointer == "/wrenches/left~1~0"


def test_a_target_that_does_not_fit_is_refused(client: Client, config: ControllerConfig) -> None:
    with Session(client, config) as session, pytest.raises(InvalidError) as refused:
        session.step(Q, wrench=np.zeros(6), targets={"push": StreamedTarget(joint_position=Q)})
    assert refused.value.pointer == "/targets/push/joint_position"
    assert "`force`" in str(refused.value)


def test_a_closed_loop_equals_the_built_in_simulation(client: Client) -> None:
    touch = scenario(client)
    plant = Plant(client, touch)
    states: list[dict[str, Any]] = []
    with Session(client, touch.controller) as session, session.stream() as stream:
        for state in plant.periods():
            states.append(state)
            plant.advance(stream.step(**state).joint_velocity)
    assert_same_run(states, simulated(client))


def test_a_session_ends_with_its_with_block(client: Client, config: ControllerConfig) -> None:
    with Session(client, config) as session:
        session.step(Q, wrench=np.zeros(6))
    with pytest.raises(NotFoundError) as ended:
        session.status()
    assert ended.value.type == "/problems/unknown-controller"


def test_a_session_and_its_stream_share_sequence_numbers(client: Client, config: ControllerConfig) -> None:
    with Session(client, config) as session, session.stream() as stream:
        sequences = [controller.step(Q, wrench=np.zeros(6)).sequence for controller in (session, stream, session)]
    assert sequences == [0, 1, 2]


def test_a_repeated_state_is_not_run_twice_and_an_older_one_is_refused(
    client: Client, config: ControllerConfig
) -> None:
    states = [state(number) for number in (0, 1)]
    with Session(client, config) as session:
        session.step_state(states[0])
        first, again = (session.step_state(states[1]) for _ in range(2))
        np.testing.assert_array_equal(first.joint_velocity, again.joint_velocity)
        assert (session.status().steps, session.status().retries) == (2, 1)
        with pytest.raises(ConflictError) as older:
            session.step_state(states[0])
        assert older.value.type == "/problems/sequence"


def state(sequence: int) -> State:
    return State(sequence=sequence, time_s=0, joint_position=Q, wrench=Wrench(force=[1, 0, 0], torque=[0, 0, 0]))


def test_a_step_goes_on_after_the_largest_number_of_the_states(client: Client, config: ControllerConfig) -> None:
    here = Controller(**{name: getattr(config, name) for name in config.model_fields_set})
    with Session(client, config) as session, Session(client, config) as streamed, streamed.stream() as stream:
        for controller in (here, session, stream, Stateless(client, config)):
            controller.step_state(state(100))
            assert controller.step(Q, wrench=np.zeros(6)).sequence == 101
            with pytest.raises(ConflictError):
                controller.step_state(state(5))
            assert controller.step(Q, wrench=np.zeros(6)).sequence == 102


def test_a_state_is_sent_again_with_its_number_if_the_answer_is_lost(
    proxy: FaultyProxy, config: ControllerConfig
) -> None:
    with Client(proxy.url, step_timeout_s=30) as client, Session(client, config) as session:
        session.step(Q, wrench=np.zeros(6))
        proxy.drop_next_answer()
        assert session.step(Q, wrench=np.zeros(6)).sequence == 1
        status = session.status()
    assert (status.steps, status.retries) == (2, 1)


def test_a_refused_state_does_not_end_a_stream(client: Client, config: ControllerConfig) -> None:
    with Session(client, config) as session, session.stream() as stream:
        with pytest.raises(InvalidError) as refused:
            stream.step(Q[:3], wrench=np.zeros(6))
        assert refused.value.pointer == "/joint_position"
        assert stream.step(Q, wrench=np.zeros(6)).sequence == 1


def test_a_stream_of_an_ended_session_is_refused(client: Client, config: ControllerConfig) -> None:
    session = Session(client, config)
    session.close()
    with pytest.raises(NotFoundError):
        session.stream()


def test_a_wrench_is_six_numbers_or_a_wrench_object(client: Client, config: ControllerConfig) -> None:
    with Session(client, config) as session:
        with pytest.raises(ValueError, match="six numbers"):
            session.step(Q, wrench=[1, 2, 3])
        with pytest.raises(InvalidError) as refusal:
            session.step(Q, wrench=[0, 0, 0, np.nan, 0, 0])
        assert refusal.value.pointer == "/wrench/torque"
        assert session.step(Q, wrench=Wrench(force=[0, 0, 0], torque=[0, 0, 0])).sequence == 0


def test_a_tared_session_keeps_its_bias_when_tasks_change(client: Client, config: ControllerConfig) -> None:
    reading = RestReading(joint_position=Q, wrench=Wrench(force=[3, 0, -1], torque=[0, 0.1, 0]))
    with Session(client, config) as session:
        assert np.linalg.norm(session.tare(readings=[reading] * 20).bias.force) == pytest.approx(np.sqrt(10))
        session.change(tasks=config.tasks)
        answer = session.step(Q, wrench=[3, 0, -1, 0, 0.1, 0])
        assert answer.wrench is not None
        assert answer.wrench.force == pytest.approx([0, 0, 0], abs=1e-12)
        with session.stream() as stream:
            session.tare(readings=[reading] * 20)
            session.change(valid_for_ms=150)
            stream.change(tasks=config.tasks)
            answer = stream.step(Q, wrench=[3, 0, -1, 0, 0.1, 0])
            assert answer.wrench is not None
            assert answer.wrench.force == pytest.approx([0, 0, 0], abs=1e-12)
            assert (answer.valid_for_ms, stream.config) == (150, session.config)
        moving = RestReading(joint_position=Q + 0.1, wrench=reading.wrench)
        with pytest.raises(InvalidError, match="tare with an arm that rests"):
            session.tare(readings=[reading] * 20 + [moving])
