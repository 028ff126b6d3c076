"""The models are those of the OpenAPI document."""

import json
import subprocess
import sys
from typing import Any, get_args

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
    "control": models.SimulationControl,
    "control_end": models.SimulationControl,
    "kinematics": models.KinematicsRequest,
    "resolve": models.ResolveRequest,
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
    "step": models.StepRequest,
    "step_again": models.StepRequest,
    "step_inequality": models.StepRequest,
}


def test_models_are_those_that_the_document_makes() -> None:
    made = subprocess.run(
        [sys.executable, CLIENT / "generate.py", ROOT / "api/openapi.json"], check=True, capture_output=True
    )
    formatted = subprocess.run(
        ["ruff", "format", "--config", CLIENT / "pyproject.toml", "-"],
        input=made.stdout, check=True, capture_output=True,
    )  # fmt: skip
    committed = (CLIENT / "src/revprio/models.py").read_text(encoding="utf-8")
    assert formatted.stdout.decode() == committed, "run the command at the head of generate.py"


def test_there_is_an_example_for_every_request() -> None:
    assert set(REQUESTS) == {path.stem for path in (ROOT / "api/examples").glob("*.json")}


@pytest.mark.parametrize("name", REQUESTS)
def test_an_example_is_sent_as_it_was_read(name: str) -> None:
    body = example(name)
    assert json.loads(REQUESTS[name].model_validate(body).json_bytes()) == body


@pytest.mark.parametrize(
    "route", [value for value in vars(routes).values() if isinstance(value, routes.Route)], ids=lambda route: route.path
)
def test_a_route_answers_as_the_document_says(route: routes.Route[Any], document: dict[str, Any]) -> None:
    operations = {templated(path): item for path, item in document["paths"].items()}
    responses = operations[route.path][route.method.lower()]["responses"]
    (content,) = [response.get("content", {}) for status, response in responses.items() if status.startswith("2")]
    if isinstance(route, routes.TraceRoute):
        assert route.accept in content
    elif content:
        assert schema_name(content["application/json"]["schema"]) == route.answer.__name__
    else:
        assert route.answer is type(None)


def test_every_operation_has_a_method_of_the_client(document: dict[str, Any]) -> None:
    of_the_client = {(route.method, route.path) for route in vars(routes).values() if isinstance(route, routes.Route)}
    of_the_client.add(("GET", routes.STREAM_CONTROLLER))
    operations = {
        (method.upper(), templated(path))
        for path, item in document["paths"].items() for method in item
        if path.startswith("/v1/") and method != "parameters"
    }  # fmt: skip
    looking_on = {
        ("GET", f"/v1/{place}") for place in ("controllers/{}/watch", "simulations/{}/events", "simulations/{}/live")
    }
    assert operations - of_the_client == looking_on


def templated(path: str) -> str:
    return path.replace("{id}", "{}").replace("{name}", "{}")


def schema_name(schema: dict[str, str]) -> str:
    return schema["$ref"].rsplit("/", 1)[1]


def test_unknown_fields_and_numbers_that_are_none_are_refused_before_they_are_sent() -> None:
    for wrong in ({"velocitie": [1]}, {"velocity": [float("nan")]}, {"velocity": [1e400]}, {"velocity": ["a"]}):
        with pytest.raises(ValueError, match="velocit"):
            models.ResolveTask.model_validate({"velocity": [1], **wrong})
    with pytest.raises(ValueError, match="sequence"):
        models.State.model_validate({"time_s": 0, "joint_position": [0]})


def test_what_is_left_out_is_not_sent_but_none_is() -> None:
    task = revprio.ControllerTask(name="t", axes=["x"], law=revprio.VelocityLaw(target_velocity=constant(0.1)))
    config = revprio.ControllerConfig(robot="r", period_s=0.1, tasks=[task], damping=None)
    sent = json.loads(config.json_bytes())
    assert sent["damping"] is None
    assert "method" not in sent
    assert sent["tasks"][0]["law"]["kind"] == "velocity"


def constant(value: float) -> revprio.ConstantProfile:
    return revprio.ConstantProfile(value=value)


def test_an_answer_of_a_newer_service_is_read() -> None:
    answer = models.StabilityAnswer.model_validate(
        {"stable": True, "spectral_radius": 0.5, "stable_at_any_lag": False, "new_field": 1}
    )
    assert answer.stable


def test_kinds_are_told_by_their_field() -> None:
    assert all(issubclass(kind, Body) for kind in get_args(get_args(models.Law)[0]))
