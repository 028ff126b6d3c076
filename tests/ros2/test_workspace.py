"""The package builds in a workspace with the commands of docs/guides/ros2.md, and its programs control the arm."""

import json
import os
import re
import subprocess

import numpy as np
from harness import REPOSITORY, ros_arguments, until

PAGE = (REPOSITORY / "docs/guides/ros2.md").read_text()
BLOCK = re.compile(r"<!-- not run: tests/ros2/run runs it in a workspace -->\n```sh\n(?P<commands>.*?)```", re.DOTALL)


def test_the_commands_build_the_package_and_its_programs_control_the_arm(lab, arm, scenario):
    (lab.directory / "ros2_ws/src").mkdir(parents=True)
    # The last command finds the programs as `ros2 run` does: by the index of packages that setup.bash has extended.
    where = "import ament_index_python as index; print(index.get_package_prefix('revprio_ros'))"
    commands = BLOCK.search(PAGE)["commands"] + f'\npython3 -c "{where}"'
    built = subprocess.run(
        ["bash", "-e", "-o", "pipefail", "-c", commands],
        cwd=REPOSITORY,
        env=os.environ | {"HOME": str(lab.directory)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    prefix = built.stdout.splitlines()[-1]
    assert prefix.startswith(str(lab.directory))

    def start(executable, **parameters):
        # The package is imported from the workspace, not from the virtual environment.
        packages = f"PYTHONPATH={prefix}/lib/python3.11/site-packages"
        program = f"{prefix}/lib/revprio_ros/{executable}"
        return lab.start(["env", packages, program, *ros_arguments("", parameters, {})])

    start("simulator", scenario=lab.file("wall.json", json.dumps(scenario)))
    start("controller", controller=lab.file("push.json", json.dumps(scenario["controller"])))
    until(lambda: abs(np.linalg.norm(arm.force) - 20) < 1, "20 N at the wall")
