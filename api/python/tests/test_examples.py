"""The notebook, the MuJoCo example and the Python snippets of the READMEs run."""

import re
import sys
from pathlib import Path

import nbformat
import numpy as np
import pytest
from conftest import ROOT
from nbclient import NotebookClient

import revprio
from revprio import Client

EXAMPLES = ROOT / "api/python/examples"


@pytest.mark.filterwarnings("ignore")  # Jupyter emits warnings
def test_the_notebook_reproduces_its_figure(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("REVPRIO_URL", url)
    notebook = nbformat.read(EXAMPLES / "stiff_wall.ipynb", as_version=4)
    NotebookClient(notebook, timeout=300).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert any("image/png" in output.get("data", {}) for output in outputs)


def test_the_mujoco_arm_touches_the_wall_and_holds_30_n(
    url: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLES))
    figure = tmp_path / "mujoco.svg"
    monkeypatch.setattr(
        sys, "argv", ["mujoco_wall.py", "--url", url, "--duration", "0.9", "--figure", str(figure)]
    )  # fmt: skip
    import mujoco_wall  # noqa: PLC0415  its directory was added to the path above

    runs = mujoco_wall.main()
    for run in runs.values():
        peak, settling, error = run.measures()
        assert run.force_n[0] == 0
        assert 30 < peak < 100
        assert np.isfinite(settling)
        assert abs(error) < 0.5
    assert figure.stat().st_size > 1000


def test_the_arm_follows_the_hand_and_stops_without_it(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLES))
    monkeypatch.setattr(sys, "argv", ["teleoperation.py", "--url", url, "--duration", "6", "--rates", "45"])
    import teleoperation  # noqa: PLC0415  its directory was added to the path above

    runs = teleoperation.main()
    default = runs["default", 45.0]
    # 12 cm of motion with 10 ms of lag and one period of delay.
    assert default.error_mm() < 10
    assert np.abs(np.diff(default.command, axis=0)).max() <= 10 * teleoperation.PERIOD_S + 1e-9  # limits of the joints
    assert default.rest_s() < 0.2 + 0.2 + teleoperation.LAG_S + 3 * teleoperation.PERIOD_S
    assert {"following", "extrapolating", "holding", "braking"} >= set(default.states) - {"none"}
    assert "braking" in default.states
    jerky = runs["last target only", 45.0]
    assert jerky.error_mm() > 3 * default.error_mm()
    assert jerky.acceleration() > default.acceleration()


@pytest.mark.parametrize(
    "readme",
    [ROOT / "README.md", ROOT / "api/python/README.md", ROOT / "docs/guides/python.md"],
    ids=["project", "client", "guide"],
)
def test_the_snippets_of_the_readme_run(url: str, readme: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    snippets = re.findall(r"```python\n(.*?)```", readme.read_text(encoding="utf-8"), re.DOTALL)
    assert snippets
    names: dict[str, object] = {}
    with Client(url) as client:
        # Snippets use this client instead of the address in their text.
        monkeypatch.setattr(revprio, "Client", lambda *_: client)
        for snippet in snippets:
            exec(snippet, names)
