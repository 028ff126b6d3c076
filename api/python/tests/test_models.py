"""The models and routes of the client agree with the OpenAPI document."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from conftest import ROOT, example

import revprio
from revprio import models, routes
from revprio.bodies import Body

CLIENT = ROOT / "api/python"

REQUESTS: dict[str, type[Body]] = {
    "batch": models.BatchRequest,
    "controller": models.ControllerConfig,
    "controller_laws": models.ControllerConfig,
    "controller_room": models.ControllerConfig,
    "controller_replaced": models.ControllerConfig,
    "control": models.SimulationControl,
    "control_end": models.SimulationControl,
    "kinematics": models.KinematicsRequest,
    "payload": models.PayloadRequest,
    "resolve": models.ResolveRequest,
    "resolve_bounds": models.ResolveRequest,
    "resolve_link": models.ResolveRequest,
    "kinematics_link": models.KinematicsRequest,
    "robot_two_arms": models.RobotRegistration,
    "robot_shapes": models.RobotRegistration,
    "resolve_certificate": models.ResolveRequest,
    "resolve_closed_form": models.ResolveRequest,
    "resolve_everything": models.ResolveRequest,
    "resolve_limits": models.ResolveRequest,
    "robot": models.RobotRegistration,
    "simulation": models.SimulationRequest,
    "simulation_interactive": models.SimulationRequest,
    "simulation_own": models.SimulationRequest,
    "simulation_world": models.SimulationRequest,
    "stability": models.StabilityRequest,
    "stability_impedance": models.StabilityRequest,
    "state": models.State,
    "tare": models.TareRequest,
    "step": models.StepRequest,
    "step_again": models.StepRequest,
    "step_ahead": models.StepRequest,
    "step_chunk": models.StepRequest,
    "step_room": models.StepRequest,
    "step_inequality": models.StepRequest,
    "step_straight": models.StepRequest,
    "step_targets": models.StepRequest,
}


@pytest.mark.parametrize(
    ("module", "command"),
    [
        ("problem", ["generate.py", ROOT / "api/openapi.json", "problem"]),
        ("models", ["generate.py", ROOT / "api/openapi.json", "models"]),
        ("aio", ["generate_aio.py"]),
    ],
)
def test_the_committed_module_is_up_to_date(module: str, command: list[str | Path]) -> None:
    script, *arguments = command
    generated = subprocess.run([sys.executable, CLIENT / script, *arguments], check=True, capture_output=True)
    formatted = subprocess.run(
        ["ruff", "format", "--config", CLIENT / "pyproject.toml", "-"],
        input=generated.stdout, check=True, capture_output=True,
    )  # fmt: skip
    committed = (CLIENT / f"src/revprio/{module}.py").read_text(encoding="utf-8")
    assert formatted.stdout.decode() == committed, f"run the command at the head of {script}"


def test_there_is_an_example_for_every_request() -> None:
    assert set(REQUESTS) == {path.stem for path in (ROOT / "api/examples").glob("*.json")}


@pytest.mark.parametrize("name", REQUESTS)
def test_an_example_is_unchanged_by_reading_and_writing(name: str) -> None:
    body = example(name)
    assert json.loads(REQUESTS[name].model_validate(body).json_bytes()) == body


@pytest.mark.parametrize(
    "route", [value for value in vars(routes).values() if isinstance(value, routes.Route)], ids=lambda route: route.path
)
def test_the_answer_type_of_a_route_is_that_of_the_document(route: routes.Route[Any], document: dict[str, Any]) -> None:
    operations = {templated(path): item for path, item in document["paths"].items()}
    responses = operations[route.path][route.method.lower()]["responses"]
    (content,) = [response.get("content", {}) for status, response in responses.items() if status.startswith("2")]
    if isinstance(route, routes.TraceRoute):
        assert route.accept in content
    elif content:
        assert schema_name(content["application/json"]["schema"]) == route.answer.__name__
    else:
        assert route.answer is type(None)


def test_every_operation_has_a_method_client_routes(document: dict[str, Any]) -> None:
    client_routes = {(route.method, route.path) for route in vars(routes).values() if isinstance(route, routes.Route)}
    client_routes.add(("GET", routes.STREAM_CONTROLLER))
    operations = {
        (method.upper(), templated(path))
        for path, item in document["paths"].items() for method in item
        if path.startswith("/v1/") and method != "parameters"
    }  # fmt: skip
    streams_for_viewers = {
        ("GET", f"/v1/{place}") for place in ("controllers/{}/watch", "simulations/{}/events", "simulations/{}/live")
    }
    assert operations - client_routes == streams_for_viewers


def templated(path: str) -> str:
    return path.replace("{id}", "{}").replace("{name}", "{}")


def schema_name(schema: dict[str, str]) -> str:
    return schema["$ref"].rsplit("/", 1)[1]


def test_unknown_fields_and_non_finite_numbers_are_refused_before_sending() -> None:
    for wrong in ({"velocitie": [1]}, {"velocity": [float("nan")]}, {"velocity": [1e400]}, {"velocity": ["a"]}):
        with pytest.raises(ValueError, match="velocit"):
            models.ResolveTask.model_validate({"velocity": [1], **wrong})
    with pytest.raises(ValueError, match="sequence"):
        models.State.model_validate({"time_s": 0, "joint_position": [0]})


def test_no_bound_is_none_or_an_infinity_on_its_own_side() -> None:
    for none in (None, -np.inf):
        task = models.ResolveTask(axes=["x", "y"], lower=[none, 0.1], upper=np.array([np.inf, 0.2]))
        assert json.loads(task.json_bytes()) == {"axes": ["x", "y"], "lower": [None, 0.1], "upper": [None, 0.2]}
    for wrong in ({"lower": [np.inf]}, {"upper": [-np.inf]}, {"lower": [np.nan]}, {"upper": ["a"]}):
        with pytest.raises(ValueError, match=r"lower|upper"):
            models.ControllerTask.model_validate({"name": "t", "axes": ["x"], **wrong})


def test_unset_fields_are_not_sent_but_none_is() -> None:
    task = revprio.ControllerTask(name="t", axes=["x"], law=revprio.VelocityLaw(target_velocity=constant(0.1)))
    config = revprio.ControllerConfig(robot="r", period_s=0.1, tasks=[task], damping=None)
    sent = json.loads(config.json_bytes())
    assert sent["damping"] is None
    assert "method" not in sent
    assert sent["tasks"][0]["law"]["kind"] == "velocity"


def constant(value: float) -> revprio.ConstantProfile:
    return revprio.ConstantProfile(value=value)


def test_unknown_fields_of_an_answer_are_ignored() -> None:
    answer = models.StabilityAnswer.model_validate(
        {"stable": True, "spectral_radius": 0.5, "stable_at_any_lag": False, "new_field": 1}
    )
    assert answer.stable


def test_the_variants_of_a_union_are_request_bodies() -> None:
    assert all(issubclass(kind, Body) for kind in get_args(get_args(models.Law)[0]))
