"""Controllers in one line: `push panda z -15` and `wipe panda z -15 y` in place of a JSON file."""

from __future__ import annotations

import re
from typing import Any

import revprio

PERIOD_S = 0.01
"""Control period of a controller that states none, s."""

USAGE = {
    "push": "push ROBOT AXIS NEWTONS [NAME=VALUE …], as in `push panda z -15 approach_speed=0.01`",
    "wipe": "wipe ROBOT AXIS NEWTONS ALONG [NAME=VALUE …], as in `wipe panda z -15 y stroke_m=0.2`",
}

DRIVE = ("lag_s", "delay_periods")

OPTIONS = {
    "push": (*DRIVE, "approach_speed", "stiffest", "max_force"),
    "wipe": (*DRIVE, "approach_speed", "stiffest", "max_force", "stroke_m", "speed"),
}


class PresetError(ValueError):
    """A line has a wrong word; the text says which, and what to do."""


def is_preset(text: str) -> bool:
    """Returns whether a text is a controller in one line: it begins with the word `push` or `wipe`."""
    return re.match(r"(push|wipe)(\s|$)", text) is not None


def body(text: str, period_s: float = 0.0) -> dict[str, Any]:
    """Returns the body of `POST /v1/controllers` of a line; `period_s` 0: 0.01 s. Raises a `PresetError`.

    The tasks are those of `revprio.presets`. With `lag_s` (s) or `delay_periods`, the controller has a `drive`.
    """
    kind, *words = text.split()
    names = ("robot", "axis", "newtons", "along") if kind == "wipe" else ("robot", "axis", "newtons")
    places, options = words[: len(names)], words[len(names) :]
    if len(places) < len(names) or any("=" in word for word in places):
        raise PresetError(f"{text!r} lacks a word; write {USAGE[kind]}")
    given = dict(zip(names, places, strict=True))
    numbers: dict[str, float] = {}
    for name, value in (option(kind, word) for word in options):
        if name in numbers:
            raise PresetError(f"{text!r} gives {name} twice")
        numbers[name] = value
    period_s = period_s or PERIOD_S
    robot, newtons = given.pop("robot"), number("NEWTONS", given.pop("newtons"))
    try:
        tasks = getattr(revprio.presets, kind)(**given, newtons=newtons, period_s=period_s, **numbers)
    except revprio.InvalidError as error:
        raise PresetError(f"{text!r}: {error.problem.pointer}: {error.problem.detail}") from error
    drive = {name: numbers[name] for name in DRIVE if name in numbers}
    made = [task.model_dump(mode="json", exclude_none=True) for task in tasks]
    return {"robot": robot, "period_s": period_s, "tasks": made, **({"drive": drive} if drive else {})}


def option(kind: str, word: str) -> tuple[str, float]:
    """Returns the name and the number of an option."""
    name, equals, value = word.partition("=")
    if not equals or name not in OPTIONS[kind]:
        names = ", ".join(OPTIONS[kind])
        period = "; the period is the parameter `period_s` of the node"
        raise PresetError(f"{word!r} is no option of `{kind}`; there are {names}, as NAME=VALUE{period}")
    found = number(name, value)
    if name != "delay_periods":
        return name, found
    if not found.is_integer():
        raise PresetError(f"{name}: {value!r} is not a whole number")
    return name, int(found)


def number(name: str, text: str) -> float:
    """Returns the number that a word states; Python would also read `1_000` and other digits."""
    if not re.fullmatch(r"[-+]?[0-9.]+([eE][-+]?[0-9]+)?", text):
        raise PresetError(f"{name}: {text!r} is not a number like -15 or 0.02")
    try:
        return float(text)
    except ValueError:
        raise PresetError(f"{name}: {text!r} is not a number like -15 or 0.02") from None
