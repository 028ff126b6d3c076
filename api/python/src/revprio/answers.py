"""The base class of answers."""

from __future__ import annotations

import inspect

from pydantic import BaseModel, ConfigDict


class _Source:
    """An annotation that is shown as it is written."""

    def __init__(self, text: str) -> None:
        self._text = text

    def __repr__(self) -> str:
        return self._text


class Readable(BaseModel):
    """A model whose signature `help()` shows as it is written."""

    @classmethod
    def __pydantic_init_subclass__(cls, **_: object) -> None:
        """Replaces the annotations in the signature by their source text."""
        bases = reversed(cls.__mro__)
        annotations = {name: text for base in bases for name, text in inspect.get_annotations(base).items()}
        signature = inspect.signature(cls)
        parameters = [
            parameter.replace(annotation=_Source(str(annotations.get(name, parameter.annotation))))
            for name, parameter in signature.parameters.items()
        ]
        cls.__signature__ = signature.replace(parameters=parameters)


class Answer(Readable):
    """Part of an answer. Unknown fields, such as those of a newer service, are ignored."""

    model_config = ConfigDict(extra="ignore", frozen=True, arbitrary_types_allowed=True)
