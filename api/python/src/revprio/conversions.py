"""Conversions of what Python users have at hand: quaternions as lists, constants, and paths of URDF files."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, TypeAlias

from pydantic import BaseModel, BeforeValidator, model_validator

from revprio.bodies import Body, finite_array


class Quaternion(Body):
    """A unit quaternion. Four numbers in a list or an array are x, y, z, w, as in ROS and SciPy."""

    @model_validator(mode="before")
    @classmethod
    def _from_numbers(cls, value: Any) -> Any:  # noqa: ANN401
        if isinstance(value, str | Mapping | BaseModel) or value is None:
            return value
        numbers = finite_array(value)
        if numbers.shape != (4,):
            message = "give four numbers, x, y, z, w, or the fields w, x, y and z"
            raise ValueError(message)
        return dict(zip("xyzw", numbers.tolist(), strict=True))


def constant(value: Any) -> Any:  # noqa: ANN401
    """Converts a number or an array to a constant profile."""
    if isinstance(value, str | Mapping | BaseModel) or value is None:
        return value
    return {"kind": "constant", "value": value}


def _urdf_text(value: Any) -> Any:  # noqa: ANN401
    """Reads the file of a path."""
    if isinstance(value, str) and value.lstrip("\ufeff \t\r\n").startswith("<"):
        return value
    if not isinstance(value, str | os.PathLike):
        message = "give URDF text, or the path of a file with it"
        raise ValueError(message)
    path = Path(value)
    if path.suffix == ".xacro":
        message = f"`{path}` is a xacro file; expand it with `revprio.read_xacro`"
        raise ValueError(message)
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        name = str(path) if len(str(path)) <= 80 else f"{str(path)[:77]}…"  # noqa: PLR2004
        message = f"this is no URDF text, `<robot …>`, and no file can be read at `{name}`: {error}"
        raise ValueError(message) from None


UrdfText: TypeAlias = Annotated[str | os.PathLike[str], BeforeValidator(_urdf_text)]
"""URDF text, or the path of a file with it."""
