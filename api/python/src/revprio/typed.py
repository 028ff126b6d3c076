"""Methods that take the fields of a body as keyword arguments, with the types of the body."""

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
    """Lets a method that takes a body take its fields instead: `resolve(request)` becomes `resolve(tasks=…, …)`."""

    def decorate(method: Callable[[S, B], A]) -> Callable[Concatenate[S, P], A]:
        @functools.wraps(method)
        def with_fields(self: S, /, *args: P.args, **fields: P.kwargs) -> A:
            return method(self, body(*args, **fields))

        of_method, of_body = inspect.signature(method), inspect.signature(body)
        this = next(iter(of_method.parameters.values()))
        with_fields.__signature__ = of_body.replace(  # type: ignore[attr-defined]
            parameters=[this, *of_body.parameters.values()],
            return_annotation=of_method.return_annotation,
        )
        return with_fields

    return decorate
