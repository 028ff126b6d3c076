"""Calls without a controller: velocity resolution, kinematics, robots, scenarios and simulations."""

import inspect
import time

import numpy as np
import pytest
from conftest import ROOT, example

from revprio import (
    Client,
    ConstantProfile,
    ControllerTask,
    EnvironmentAxis,
    Interactive,
    InvalidError,
    NotFoundError,
    Problem,
    ResolveAnswer,
    ResolveRequest,
    ResolveTask,
    Scenario,
    SimulationError,
    VelocityLaw,
    WrenchSensor,
)

Q = np.array([0.3, -0.6, 0.2, 1.4, 0.1, 0.9, 0.0])
PUSH = ResolveTask(axes=["x"], velocity=np.array([0.05]))


def test_the_resolved_velocity_gives_the_tool_the_velocity_of_the_task(client: Client) -> None:
    answer = client.resolve(robot="sawyer_dh", joint_position=Q, tasks=[PUSH])
    jacobian = client.kinematics(robot="sawyer_dh", joint_position=Q).jacobian
    assert jacobian.shape == (6, 7)
    assert answer.joint_velocity.dtype == np.float64
    np.testing.assert_allclose(jacobian[0] @ answer.joint_velocity, 0.05, atol=1e-12)


def test_joint_positions_can_be_given_by_name(client: Client) -> None:
    names = [joint.name for joint in client.robot("sawyer_dh").joints]
    named = dict(reversed(list(zip(names, Q, strict=True))))
    by_name = client.resolve(robot="sawyer_dh", joint_position=named, tasks=[PUSH])
    in_order = client.resolve(robot="sawyer_dh", joint_position=Q, tasks=[PUSH])
    np.testing.assert_array_equal(by_name.joint_velocity, in_order.joint_velocity)


def test_a_batch_keeps_its_order_and_reports_a_problem_per_item(client: Client) -> None:
    good = ResolveRequest(robot="sawyer_dh", joint_position=Q, tasks=[PUSH])
    bad = ResolveRequest(robot="unknown", joint_position=Q, tasks=[PUSH])
    first, second, third = client.resolve_batch([good, bad, good])
    assert isinstance(first, ResolveAnswer)
    assert isinstance(second, Problem)
    assert second.pointer == "/items/1/robot"
    assert isinstance(third, ResolveAnswer)


def test_a_problem_names_the_error_the_field_and_the_remedy(client: Client) -> None:
    with pytest.raises(InvalidError) as refused:
        client.resolve(robot="sawyer_dh", joint_position=Q[:2], tasks=[PUSH])
    error = refused.value
    assert (error.status, error.type, error.pointer) == (422, "/problems/invalid", "/joint_position")
    assert "2 numbers for 7 joints" in error.detail
    assert "Change the field" in error.remedy
    assert not error.is_silence
    for part in (error.detail, error.remedy, "/joint_position"):
        assert part in str(error)
    with pytest.raises(NotFoundError):
        client.robot("no/such name")


def test_keyword_arguments_are_the_fields_of_the_body(client: Client) -> None:
    assert list(inspect.signature(client.resolve).parameters) == list(ResolveRequest.model_fields)
    with pytest.raises(ValueError, match="did you mean `tasks`"):
        client.resolve(task=[PUSH])  # type: ignore[call-arg]


def test_the_maximum_lag_equals_the_value_in_the_documentation(client: Client) -> None:
    wall = EnvironmentAxis(stiffness=1e5)
    answer = client.stability(inertia=15, damping=150, environment=wall, period_s=0.001, lag_s=0.005)
    assert not answer.stable
    assert answer.largest_lag_s == pytest.approx(0.0015, rel=1e-3)


def test_a_payload_is_identified_and_a_wrong_sign_is_refused(client: Client) -> None:
    request = example("payload")
    found = client.payload(**request)
    assert found.axes_verified
    assert found.payload.mass_kg == pytest.approx(0.5, abs=0.05)
    sensor = WrenchSensor(bias=found.bias, payload=found.payload)
    assert sensor.payload is not None
    with pytest.raises(InvalidError, match="the other sign"):
        client.payload(**{**request, "wrench_convention": "on_environment"})


def test_a_robot_can_be_registered_and_deleted(client: Client) -> None:
    urdf = (ROOT / "fixtures/robots/planar_3r.urdf").read_text(encoding="utf-8")
    assert client.register_robot(name="mine", urdf=urdf).name == "mine"
    assert "mine" in [robot.name for robot in client.robots()]
    client.delete_robot("mine")
    assert "mine" not in [robot.name for robot in client.robots()]


def test_a_simulation_runs_and_has_a_trace(client: Client) -> None:
    own = example("simulation_own")
    seen: list[float] = []
    run = client.simulate(scenario=Scenario.model_validate(own["scenario"]))
    status = run.result(lambda status: seen.append(status.progress))
    trace = run.trace()
    assert status.metrics is not None
    assert trace["time_s"].shape == (50,)
    assert trace["position_j1_rad"][0] == 2.9
    assert set(trace["status"]) == {"optimal"}
    run.cancel()
    with pytest.raises(NotFoundError):
        run.status()


def test_an_interactive_simulation_follows_commands_and_returns_its_cycle(client: Client) -> None:
    run = client.simulate(scenario="stiff_wall", interactive=Interactive(paused=True))
    while run.status().state == "queued":
        time.sleep(0.01)
    run.control(step=10)
    while run.status().progress < 10 / 5000:
        time.sleep(0.01)
    cycle = run.cycle()
    assert client.step(controller=cycle.controller, state=cycle.state, memory=cycle.memory).solver.status == "optimal"
    assert run.control(end=True).scenario == "stiff_wall"
    run.result()
    assert run.trace()["time_s"].size in (10, 11)  # the period that waits for the service is completed first


def test_open_sessions_are_listed(client: Client) -> None:
    hold = ControllerTask(name="hold", axes=["x"], law=VelocityLaw(target_velocity=ConstantProfile(value=0)))
    with client.session(robot="sawyer_dh", period_s=0.001, tasks=[hold]) as session:
        assert session.id in [entry.id for entry in client.sessions()]


def test_a_cancelled_simulation_has_no_result(client: Client) -> None:
    run = client.simulate(scenario=client.scenarios()[0].name)
    run.cancel()
    with pytest.raises((SimulationError, NotFoundError)):
        run.result()


def test_the_client_reports_that_the_service_is_ready(client: Client) -> None:
    assert client.is_ready()
