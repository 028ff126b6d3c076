"""The notebook, the other examples and the Python snippets of the READMEs run, without a server too."""

import re
import sys
from pathlib import Path

import nbformat
import numpy as np
import pytest
from conftest import ROOT
from nbclient import NotebookClient

import revprio
from revprio import Client, Streaming

EXAMPLES = ROOT / "api/python/examples"


@pytest.fixture
def examples(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets the examples be imported, and hides a service of the environment."""
    monkeypatch.syspath_prepend(str(EXAMPLES))
    monkeypatch.delenv("REVPRIO_URL", raising=False)


@pytest.mark.usefixtures("examples")
@pytest.mark.filterwarnings("ignore")  # Jupyter emits warnings
@pytest.mark.parametrize("where", ["own service", "given service"])
def test_the_notebook_reproduces_its_figure(url: str, where: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if where == "given service":
        monkeypatch.setenv("REVPRIO_URL", url)
    notebook = nbformat.read(EXAMPLES / "stiff_wall.ipynb", as_version=4)
    NotebookClient(notebook, timeout=300).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert any("image/png" in output.get("data", {}) for output in outputs)


@pytest.mark.usefixtures("examples")
def test_the_mujoco_arm_touches_the_wall_and_holds_30_n(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    figure = tmp_path / "mujoco.svg"
    monkeypatch.setattr(sys, "argv", ["mujoco_wall.py", "--duration", "0.9", "--figure", str(figure)])
    import mujoco_wall  # noqa: PLC0415  its directory was added to the path

    runs = mujoco_wall.main()
    for run in runs.values():
        peak, settling, error = run.measures()
        assert run.force_n[0] == 0
        assert 30 < peak < 100
        assert np.isfinite(settling)
        assert abs(error) < 0.5
    assert figure.stat().st_size > 1000


@pytest.mark.usefixtures("examples")
@pytest.mark.filterwarnings("ignore:.*WARN.*:UserWarning")  # advice for learning: small and finite spaces
def test_gymnasium_accepts_the_environment() -> None:
    import gymnasium_wall  # noqa: PLC0415  its directory was added to the path
    from gymnasium.utils.env_checker import check_env  # noqa: PLC0415

    check_env(gymnasium_wall.SawyerWall())


@pytest.mark.usefixtures("examples")
def test_the_loop_in_the_process_prints_its_rate_and_ends_at_rest(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["gymnasium_wall.py", "--duration", "1"])
    import gymnasium_wall  # noqa: PLC0415  its directory was added to the path

    report, end = gymnasium_wall.main()
    printed = dict(re.findall(r"^(.*\S)  +([-\d.e]+) ?\S*$", capsys.readouterr().out, re.MULTILINE))
    assert printed["requested rate"] == "500"
    assert float(printed["achieved rate"]) == pytest.approx(1 / report.achieved_period_s, abs=0.1)
    assert float(printed["period, longest"]) >= float(printed["period, 99 %"]) > 0
    assert int(printed["skipped periods"]) == report.skipped
    assert report.steps > 0
    assert np.abs(end["joint_velocity"]).max() < 1e-2


@pytest.mark.usefixtures("examples")
def test_the_arm_follows_the_hand_and_stops_without_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["teleoperation.py", "--duration", "6", "--rates", "45"])
    import teleoperation  # noqa: PLC0415  its directory was added to the path

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


@pytest.mark.usefixtures("examples")
def test_the_hand_leads_the_arm_alike_with_and_without_a_service(client: Client) -> None:
    import teleoperation  # noqa: PLC0415  its directory was added to the path

    here, there = (teleoperation.run(place, 45, Streaming(), 3.2) for place in (revprio.connect(), client))
    assert np.abs(here.command).max() > 0.1
    np.testing.assert_array_equal(here.command, there.command)


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
