"""The pages for users of other programs: both blocks of each arrive, the first one where its program is installed."""

import re
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

import revprio

PROGRAMS = {
    "pink": ["pink", "daqp"],
    "mink": ["mink", "daqp"],
    "placo": ["placo"],
    "lerobot": ["lerobot.model.kinematics", "placo"],
    "moveit-servo": [],
}


def blocks(name: str, kind: str) -> list[str]:
    """Returns the blocks of a page."""
    text = (ROOT / f"docs/guides/coming-from-{name}.md").read_text(encoding="utf-8")
    return re.findall(rf"```{kind}\n(.*?)```", text, re.DOTALL)


def moved(names: dict[str, Any]) -> float:
    """Returns how far the tool is from 0.1 m along y from its start, m."""
    start = revprio.kinematics(robot="panda", joint_position=[0, -0.785, 0, -2.356, 0, 1.571, 0.785]).pose
    end = revprio.kinematics(robot="panda", joint_position=names["q"]).pose
    return float(np.abs(np.asarray(end.position) - np.asarray(start.position) - [0, 0.1, 0]).max())


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_block_after_reaches_the_goal(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    names: dict[str, Any] = {}
    (after,) = blocks(name, "python")
    exec(after, names)
    assert moved(names) < 2e-3


@pytest.mark.parametrize("name", [name for name, modules in PROGRAMS.items() if modules])
def test_the_block_before_reaches_the_goal(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in PROGRAMS[name]:
        pytest.importorskip(module)
    monkeypatch.chdir(ROOT)
    names: dict[str, Any] = {}
    (before,) = blocks(name, "python before")
    exec(before, names)
    assert moved(names) < 5e-3
