"""A decorator for methods whose keyword arguments are the fields of a body, with their types."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Concatenate, ParamSpec, TypeVar

from revprio.bodies import Body

P = ParamSpec("P")
S = TypeVar("S")
B = TypeVar("B", bound=Body)
A = TypeVar("A")


def fields_of(body: Callable[P, B]) -> Callable[[Callable[[S, B], A]], Callable[Concatenate[S, P], A]]:
    """Replaces the body argument of a method by the fields of the body: `resolve(request)` → `resolve(tasks=…, …)`."""

    def decorate(method: Callable[[S, B], A]) -> Callable[Concatenate[S, P], A]:
        @functools.wraps(method)
        def with_fields(self: S, /, *args: P.args, **fields: P.kwargs) -> A:
            return method(self, body(*args, **fields))

        of_method, of_body = inspect.signature(method), inspect.signature(body)
        receiver = next(iter(of_method.parameters.values()))
        with_fields.__signature__ = of_body.replace(  # type: ignore[attr-defined]
            parameters=[receiver, *of_body.parameters.values()],
            return_annotation=of_method.return_annotation,
        )
        with_fields.__doc__ = "\n\n".join(filter(None, [inspect.getdoc(method), _fields(body)]))
        return with_fields

    return decorate


def _fields(body: object) -> str:
    """Returns the description of the fields of a body, for `help()`."""
    _, heading, fields = (inspect.getdoc(body) or "").partition("Fields:")
    return heading + fields
