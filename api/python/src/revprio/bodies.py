"""Base classes of request and answer bodies, and the types of their NumPy arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike as AnyArrayLike
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, PlainSerializer, PlainValidator


def _array(value: Any) -> NDArray[np.float64]:  # noqa: ANN401
    """Converts numbers to an array; `None` becomes nan."""
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


def _bounds(value: Any, none: float) -> NDArray[np.float64]:  # noqa: ANN401
    """Converts bounds to an array with `none` for no bound; a nan is an error, because it is no bound by mistake."""
    try:
        array = _array([none if bound is None else bound for bound in value])
    except TypeError as error:
        raise ValueError(str(error)) from error
    if not (np.isfinite(array) | (array == none)).all():
        message = f"every bound must be a finite number, or None or {none} for no bound"
        raise ValueError(message)
    return array


def _lower(value: Any) -> NDArray[np.float64]:  # noqa: ANN401
    return _bounds(value, -np.inf)


def _upper(value: Any) -> NDArray[np.float64]:  # noqa: ANN401
    return _bounds(value, np.inf)


def _joints(value: Any) -> NDArray[np.float64] | dict[str, float]:  # noqa: ANN401
    if isinstance(value, Mapping):
        return {str(name): float(_finite(number)) for name, number in value.items()}
    return _finite(value)


def _plain(value: NDArray[np.float64] | dict[str, float]) -> Any:  # noqa: ANN401
    return value if isinstance(value, dict) else value.tolist()


def _plain_bounds(value: NDArray[np.float64]) -> list[float | None]:
    return [bound if np.isfinite(bound) else None for bound in value.tolist()]


FloatArray: TypeAlias = Annotated[NDArray[np.float64], PlainValidator(_array), PlainSerializer(_plain)]
"""An array in an answer; `null` in JSON is nan here."""

ArrayLike: TypeAlias = Annotated[AnyArrayLike, PlainValidator(_finite), PlainSerializer(_plain)]
"""An array in a request: anything that NumPy converts to an array of finite numbers."""

LowerBounds: TypeAlias = Annotated[
    AnyArrayLike | Sequence[float | None], PlainValidator(_lower), PlainSerializer(_plain_bounds)
]
"""Lower bounds, one per row: finite numbers, or `None` or -inf for no bound."""

UpperBounds: TypeAlias = Annotated[
    AnyArrayLike | Sequence[float | None], PlainValidator(_upper), PlainSerializer(_plain_bounds)
]
"""Upper bounds, one per row: finite numbers, or `None` or inf for no bound."""

JointVector: TypeAlias = Annotated[AnyArrayLike | Mapping[str, float], PlainValidator(_joints), PlainSerializer(_plain)]
"""One number per joint: an array in the robot's joint order, or a mapping by joint name in any order."""


class Body(BaseModel):
    """Part of a request. Fields that were not set are not sent; the service then uses its defaults."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, arbitrary_types_allowed=True)

    def json_bytes(self) -> bytes:
        """Returns the JSON text to send."""
        return self.model_dump_json(exclude_unset=True).encode()


class Tagged(Body):
    """A variant of a union; the field `kind` names the variant."""

    def model_post_init(self, _context: object, /) -> None:
        """Marks `kind` as set, so that it is sent."""
        self.model_fields_set.add("kind")


class Answer(BaseModel):
    """Part of an answer. Unknown fields, such as those of a newer service, are ignored."""

    model_config = ConfigDict(extra="ignore", frozen=True, arbitrary_types_allowed=True)
