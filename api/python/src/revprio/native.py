"""The core in this process: calls of the extension module, with the types of the package."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, SupportsIndex

from pydantic import BaseModel

from revprio import _native
from revprio.bodies import ArrayLike, Body
from revprio.errors import ProblemError, problem_error
from revprio.models import ChannelInput, ObstacleState, Problem, ResolveAnswer, StepAnswer, StreamedTarget, Wrench
from revprio.states import as_wrenches

DICT = BaseModel.__dict__["__dict__"]
"""The attribute that holds the fields of a model."""

set_fields = DICT.__set__
"""Sets the fields of a model, `set_fields(model, fields)`."""


@cache
def service() -> _native.Service:
    """Returns the service of this process, which knows the built-in robots and those that the process registers."""
    return _native.Service()


def controller(config: bytes) -> _native.Controller:
    """Starts a controller from its JSON."""
    try:
        return service().controller(config)
    except _native.RefusedError as refusal:
        raise problem(refusal) from None


def replace(controller: _native.Controller, config: bytes) -> None:
    """Replaces a controller by that of a JSON."""
    try:
        service().replace(controller, config)
    except _native.RefusedError as refusal:
        raise problem(refusal) from None


def resolve(request: bytes) -> ResolveAnswer:
    """Resolves a request in JSON."""
    try:
        fields = service().resolve(request)
    except _native.RefusedError as refusal:
        raise problem(refusal) from None
    answer = LazyResolveAnswer.__new__(LazyResolveAnswer)
    set_fields(answer, fields)
    return answer


class Targets(Body):
    """Targets by task name."""

    targets: dict[str, StreamedTarget]


def targets_json(targets: Mapping[str, StreamedTarget]) -> bytes:
    """Returns the JSON of the targets of a state."""
    each = Targets(targets=dict(targets)).targets.items()
    return b"{" + b",".join(json.dumps(name).encode() + b":" + target.json_bytes() for name, target in each) + b"}"


class Obstacles(Body):
    """Where obstacles are."""

    obstacles: list[ObstacleState]


def obstacles_json(obstacles: Sequence[ObstacleState]) -> bytes:
    """Returns the JSON of the obstacles of a state."""
    each = Obstacles(obstacles=list(obstacles)).obstacles
    return b"[" + b",".join(obstacle.json_bytes() for obstacle in each) + b"]"


def wrenches_json(wrenches: Mapping[str, Wrench | ArrayLike]) -> bytes:
    """Returns the JSON of the wrenches of a state."""
    each = as_wrenches(wrenches).items()
    return b"{" + b",".join(json.dumps(tip).encode() + b":" + wrench.json_bytes() for tip, wrench in each) + b"}"


class Channels(Body):
    """What arrived for channels by name."""

    channels: dict[str, ChannelInput]


def channels_json(channels: Mapping[str, ChannelInput]) -> bytes:
    """Returns the JSON of the channels of a state."""
    each = Channels(channels=dict(channels)).channels.items()
    return b"{" + b",".join(json.dumps(name).encode() + b":" + channel.json_bytes() for name, channel in each) + b"}"


def call(method: str, path: str, body: bytes) -> bytes:
    """Answers a request to a route, in JSON."""
    try:
        return service().call(method, path, body)
    except _native.RefusedError as refusal:
        raise problem(refusal) from None


def problem(refusal: _native.RefusedError) -> ProblemError:
    """Returns the exception of a refusal, as a client of the service gets it."""
    return problem_error(Problem.model_validate_json(refusal.args[0]))


class Lazy:
    """An answer that reads its fields when one is used that a control loop does not need.

    Reading all fields takes longer than the step. The first use of such a field, and every function of pydantic, turns
    the object into one of its base class.
    """

    @property
    def __dict__(self) -> dict[str, Any]:  # type: ignore[override]
        """All fields."""
        read(self)
        fields: dict[str, Any] = DICT.__get__(self)
        return fields

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401
        """Reads all fields and returns one."""
        read(self)
        return getattr(self, name)

    def __copy__(self) -> Any:  # noqa: ANN401
        """Copies all fields."""
        read(self)
        return self.__copy__()

    def __deepcopy__(self, memo: dict[int, Any] | None = None) -> Any:  # noqa: ANN401
        """Copies all fields."""
        read(self)
        return self.__deepcopy__(memo)

    def __reduce_ex__(self, protocol: SupportsIndex) -> tuple[Any, ...] | str:
        """Copies and stores all fields, as an object of the base class."""
        read(self)
        return self.__reduce_ex__(protocol)


class LazyStepAnswer(Lazy, StepAnswer):
    """An answer whose command is known and whose explanation is read when it is used."""


class LazyResolveAnswer(Lazy, ResolveAnswer):
    """An answer whose joint velocities are known and whose explanation is read when it is used."""


def read(answer: Lazy) -> None:
    """Reads all fields of an answer."""
    known = DICT.__get__(answer)
    source = known.get("_answer")
    if source is None:  # another thread has read it
        return
    kind = StepAnswer if isinstance(source, _native.StepAnswer) else ResolveAnswer
    whole = kind.model_validate_json(source.json())
    object.__setattr__(answer, "__pydantic_fields_set__", whole.model_fields_set)
    object.__setattr__(answer, "__pydantic_extra__", None)
    object.__setattr__(answer, "__pydantic_private__", None)
    # The arrays that were returned before stay the same objects.
    set_fields(answer, {**vars(whole), **{name: value for name, value in known.items() if name != "_answer"}})
    object.__setattr__(answer, "__class__", kind)
