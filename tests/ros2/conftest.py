"""Objects of the tests."""

import json

import pytest
from harness import PACKAGE, Lab, recorder


@pytest.fixture
def lab(tmp_path):
    """Starts nodes and ends them after the test; shows what they printed if the test fails."""
    lab = Lab(tmp_path)
    yield lab
    for number, process in enumerate(lab.processes):
        print(f"-- process {number}\n{process.output()}")
    lab.end()


@pytest.fixture
def arm():
    """Records the arm without namespace."""
    return recorder()


@pytest.fixture
def scenario():
    """Returns the scenario of the guide: a wall 3 cm in front of the tool."""
    return json.loads((PACKAGE / "config/wall.json").read_text())
