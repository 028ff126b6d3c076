"""xacro files."""

from pathlib import Path

import pytest

import revprio

ROBOT = """<robot name="lift" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="speed" default="0.2"/>
  <xacro:include filename="$(find rails)/rail.xacro"/>
  <link name="base"/><link name="carriage"/>
  <xacro:rail speed="$(arg speed)"/>
</robot>"""

RAIL = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="rail" params="speed">
    <joint name="rail" type="prismatic">
      <parent link="base"/><child link="carriage"/><axis xyz="0 0 1"/>
      <limit lower="0" upper="1.5" velocity="${speed}"/>
    </joint>
  </xacro:macro>
</robot>"""


def written(directory: Path) -> Path:
    (directory / "rail.xacro").write_text(RAIL, encoding="utf-8")
    robot = directory / "lift.urdf.xacro"
    robot.write_text(ROBOT, encoding="utf-8")
    return robot


@pytest.mark.parametrize("speed", ["0.5", 0.5])
def test_a_xacro_file_is_expanded_with_its_arguments_and_packages(tmp_path: Path, speed: str | float) -> None:
    urdf = revprio.read_xacro(written(tmp_path), mappings={"speed": speed}, packages={"rails": tmp_path})
    robot = revprio.register_robot(name="lift", urdf=urdf)
    try:
        assert robot.joints[0].velocity_limit == pytest.approx(0.5)
        assert robot.chain is not None
        assert robot.chain.tip == "carriage"
    finally:
        revprio.delete_robot("lift")


def test_paths_are_relative_to_the_present_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = written(tmp_path)
    (tmp_path / "robots").mkdir()
    robot = robot.rename(tmp_path / "robots" / robot.name)
    monkeypatch.chdir(tmp_path)
    assert 'name="rail"' in revprio.read_xacro(robot.relative_to(tmp_path), packages={"rails": "."})


def test_an_error_names_the_file_and_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"lift.urdf.xacro.*`rails` in `packages`"):
        revprio.read_xacro(written(tmp_path))
    broken = tmp_path / "broken.xacro"
    broken.write_text("<robot>", encoding="utf-8")
    with pytest.raises(ValueError, match=r"broken.xacro"):
        revprio.read_xacro(broken)
