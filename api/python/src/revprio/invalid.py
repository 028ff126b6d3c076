"""Errors of bodies that the client refuses itself, in the words of the service."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from revprio.errors import InvalidError, pointer_to
from revprio.problem import Problem

if TYPE_CHECKING:
    from pydantic import ValidationError
    from pydantic_core import ErrorDetails

TEXTS = {
    "missing": "this field is missing",
    "union_tag_not_found": "`kind` is missing; it names the variant: {expected_tags}",
    "union_tag_invalid": "there is no `kind` {tag!r}; give one of {expected_tags}",
    "literal_error": "{input!r} is unknown; give {expected}",
    "value_error": "{error}",
    "finite_number": "the number must be finite",
    "json_invalid": "this is not JSON: {error}",
}
"""What is wrong, by pydantic's kind of error; with the values of its context."""

KINDS = {
    "int": "a whole number", "float": "a number", "bool": "True or False", "string": "a string",
    "list": "a list", "dict": "a mapping", "model": "an object with these fields",
}  # fmt: skip
"""What a field must be, by the beginning of pydantic's kind of error."""


def invalid(error: ValidationError, given: object, known: Iterable[str]) -> InvalidError:
    """Returns the exception for a body with wrong fields, which names one of them.

    `given`: the fields; `known`: the names of all fields of the body.
    """
    details = error.errors(include_url=False)
    unknown = [detail for detail in details if detail["type"] == "extra_forbidden"]
    # An unknown field is often a misspelled one, which is then missing. Of several types, the nearest has most parts.
    first = max(unknown or details, key=lambda detail: len(detail["loc"]) if _is_union(details) else 0)
    pointer = pointer_to(*_place(first["loc"], given))
    problem = Problem(type="/problems/invalid", title="Invalid field", status=422, detail=_text(first, known))
    return InvalidError(problem.model_copy(update={"pointer": pointer or None}))


def _is_union(details: Sequence[ErrorDetails]) -> bool:
    """Returns whether all errors are about one field of several possible types."""
    return len({detail["loc"][:1] for detail in details}) == 1


def _place(loc: tuple[int | str, ...], given: object) -> list[int | str]:
    """Removes the names of variants and types, which pydantic puts between the fields."""
    place: list[int | str] = []
    for i, part in enumerate(loc):
        found, inner = _entry(given, part)
        if found or (i == len(loc) - 1 and str(part).isidentifier()):
            place.append(part)
            given = inner
    return place


def _entry(given: object, part: int | str) -> tuple[bool, object]:
    """Returns whether an object has this part, and the part."""
    if isinstance(part, int):
        is_item = isinstance(given, Sequence) and part < len(given)
        return True, given[part] if is_item else None  # type: ignore[index]
    if isinstance(given, Mapping):
        return part in given, given.get(part)
    return hasattr(given, part), getattr(given, part, None)


def _text(detail: ErrorDetails, known: Iterable[str]) -> str:
    kind, context = detail["type"], {"input": detail["input"], **detail.get("ctx", {})}
    if kind == "extra_forbidden":
        return _unknown_field(str(detail["loc"][-1]), known)
    if kind in TEXTS:
        return TEXTS[kind].format_map(_Lenient(context))
    expected = KINDS.get(kind.partition("_")[0])
    return f"{_short(detail['input'])} is not {expected}" if expected else detail["msg"]


def _unknown_field(name: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, known, 1)
    hint = f"did you mean `{near[0]}`?" if near else "see `help()` of its class for the fields"
    return f"there is no field `{name}`; {hint}"


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}…"  # noqa: PLR2004


class _Lenient(dict[str, Any]):
    """The values of a context; an unknown one is empty."""

    def __missing__(self, key: str) -> str:
        return ""
