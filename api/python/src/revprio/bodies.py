"""What all bodies have in common, and NumPy arrays inside them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike as AnyArrayLike
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, PlainSerializer, PlainValidator


def _array(value: Any) -> NDArray[np.float64]:  # noqa: ANN401
    """Numbers as an array; `null` is nan."""
    try:
        return np.asarray(value, dtype=np.float64)
    except TypeError as error:
        raise ValueError(str(error)) from error


def _finite(value: Any) -> NDArray[np.float64]:  # noqa: ANN401
    array = _array(value)
    if not np.isfinite(array).all():
        message = "every number must be finite"
        raise ValueError(message)
    return array


def _joints(value: Any) -> NDArray[np.float64] | dict[str, float]:  # noqa: ANN401
    if isinstance(value, Mapping):
        return {str(name): float(_finite(number)) for name, number in value.items()}
    return _finite(value)


def _plain(value: NDArray[np.float64] | dict[str, float]) -> Any:  # noqa: ANN401
    return value if isinstance(value, dict) else value.tolist()


FloatArray: TypeAlias = Annotated[NDArray[np.float64], PlainValidator(_array), PlainSerializer(_plain)]
"""An array of an answer; nan where there is no number."""

ArrayLike: TypeAlias = Annotated[AnyArrayLike, PlainValidator(_finite), PlainSerializer(_plain)]
"""An array of a request, or what NumPy makes one of: numbers, lists, arrays. All must be finite."""

JointVector: TypeAlias = Annotated[AnyArrayLike | Mapping[str, float], PlainValidator(_joints), PlainSerializer(_plain)]
"""One number per joint: an array in the robot's joint order, or a mapping by joint name in any order."""


class Body(BaseModel):
    """Part of a request. What is left out is not sent; the service then takes its default."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, arbitrary_types_allowed=True)

    def json_bytes(self) -> bytes:
        """As it is sent."""
        return self.model_dump_json(exclude_unset=True).encode()


class Tagged(Body):
    """One of several kinds, which the field `kind` names."""

    def model_post_init(self, _context: object, /) -> None:
        """Counts `kind` as set, so that it is sent."""
        self.model_fields_set.add("kind")


class Answer(BaseModel):
    """Part of an answer. Fields that a newer service may add are ignored."""

    model_config = ConfigDict(extra="ignore", frozen=True, arbitrary_types_allowed=True)
