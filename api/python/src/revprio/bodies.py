"""The base class of request bodies, and the types of their NumPy arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Self, TypeAlias, TypeVar

import numpy as np
import pydantic_core
from numpy.typing import ArrayLike as AnyArrayLike
from numpy.typing import NDArray
from pydantic import BaseModel, BeforeValidator, ConfigDict, PlainSerializer, PlainValidator, ValidationError

from revprio.answers import Readable
from revprio.invalid import invalid

T = TypeVar("T")


def _array(value: Any) -> NDArray[np.float64]:  # noqa: ANN401
    """Converts numbers to an array; `None` becomes nan."""
    if isinstance(value, np.ma.MaskedArray):
        message = "a masked array has no number where it is masked; give an array, such as `masked.filled(0.0)`"
        raise ValueError(message)
    try:
        array = np.asarray(value)
        # Not complex numbers, dates or records. A copy: the caller may change the array afterwards.
        if array.dtype.kind in "biufOUS":
            return np.array(array, dtype=np.float64)
    except (TypeError, ValueError):
        pass
    message = "give a number, a list or an array of real numbers, with rows of equal length"
    raise ValueError(message)


def finite_array(value: Any) -> NDArray[np.float64]:  # noqa: ANN401
    """Converts numbers to an array; refuses those that are not finite."""
    array = _array(value)
    if not np.isfinite(array).all():
        message = "every number must be finite"
        raise ValueError(message)
    return array


def _vector(value: Any) -> NDArray[np.float64]:  # noqa: ANN401
    return np.atleast_1d(finite_array(value))


def _matrix(value: Any) -> NDArray[np.float64]:  # noqa: ANN401
    return np.atleast_2d(finite_array(value))


def _list(value: Any) -> Any:  # noqa: ANN401
    return [value] if isinstance(value, str) else value


def _bounds(value: Any, none: float) -> NDArray[np.float64]:  # noqa: ANN401
    """Converts bounds to an array with `none` for no bound; a nan is an error, because it is no bound by mistake."""
    try:
        array = _array([none if bound is None else bound for bound in ([value] if np.isscalar(value) else value)])
    except TypeError:
        message = "give one bound per row, None for no bound"
        raise ValueError(message) from None
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
        return {str(name): float(finite_array(number)) for name, number in value.items()}
    return finite_array(value)


def _plain(value: NDArray[np.float64] | dict[str, float]) -> Any:  # noqa: ANN401
    return value if isinstance(value, dict) else value.tolist()


def _plain_bounds(value: NDArray[np.float64]) -> list[float | None]:
    return [bound if np.isfinite(bound) else None for bound in value.tolist()]


FloatArray: TypeAlias = Annotated[NDArray[np.float64], PlainValidator(_array), PlainSerializer(_plain)]
"""An array in an answer; `null` in JSON is nan here."""

ArrayLike: TypeAlias = Annotated[AnyArrayLike, PlainValidator(finite_array), PlainSerializer(_plain)]
"""An array in a request: anything that NumPy converts to an array of finite numbers."""

Vector: TypeAlias = Annotated[AnyArrayLike, PlainValidator(_vector), PlainSerializer(_plain)]
"""A list of finite numbers in a request: anything that NumPy converts to one. A single number is a list of one."""

Matrix: TypeAlias = Annotated[AnyArrayLike, PlainValidator(_matrix), PlainSerializer(_plain)]
"""A matrix of finite numbers in a request, row by row. A list of numbers is a matrix of one row."""

OneOrMore: TypeAlias = Annotated[list[T] | T, BeforeValidator(_list)]
"""A list of words, or one word."""

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


if TYPE_CHECKING:
    # Type checkers must see the metaclass of pydantic, which defines the arguments of the models.
    _Refusing = Readable
else:

    class _BodyMeta(type(BaseModel)):
        def __call__(cls, *args: Any, **fields: Any) -> Any:  # noqa: ANN401
            if args:
                message = f"name the fields: {cls.__name__}(field=value, …)"
                raise TypeError(message)
            try:
                return super().__call__(**fields)
            except ValidationError as error:
                raise invalid(error, fields, cls.model_fields) from None

    class _Refusing(Readable, metaclass=_BodyMeta):
        """A model that raises an `InvalidError` if its fields are wrong, as the service would."""


class Body(_Refusing):
    """Part of a request. Fields that were not set are not sent; the service then uses its defaults."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, arbitrary_types_allowed=True)

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:  # noqa: ANN401
        """Creates the body from a mapping; raises an `InvalidError` that names the wrong field."""
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise invalid(error, obj, cls.model_fields) from None

    @classmethod
    def model_validate_json(cls, json_data: Any, **options: Any) -> Self:  # noqa: ANN401
        """Creates the body from JSON; raises an `InvalidError` that names the wrong field."""
        try:
            return super().model_validate_json(json_data, **options)
        except ValidationError as error:
            given = pydantic_core.from_json(json_data, allow_partial=True)
            raise invalid(error, given, cls.model_fields) from None

    def json_bytes(self) -> bytes:
        """Returns the JSON text to send."""
        return self.model_dump_json(exclude_unset=True).encode()

    def __eq__(self, other: object) -> bool:
        """Returns whether both are of one class and send the same text."""
        return isinstance(other, Body) and type(self) is type(other) and self.json_bytes() == other.json_bytes()

    def __hash__(self) -> int:
        """Returns a hash of the text to send."""
        return hash((type(self), self.json_bytes()))


class Tagged(Body):
    """A variant of a union; the field `kind` names the variant."""

    def model_post_init(self, _context: object, /) -> None:
        """Marks `kind` as set, so that it is sent."""
        self.model_fields_set.add("kind")
