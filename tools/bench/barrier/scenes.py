"""The two scenes: slides that carry a ball past another one, and a Panda before a post."""

from __future__ import annotations

import functools
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from behaviour.rotations import Array, from_roll_pitch_yaw, rotation_vector

from barrier.referee import Capsule, Joint, distance, link_poses

REPOSITORY = Path(__file__).resolve().parents[3]
PERIOD_S = 0.005
"""Control period T, s."""
MIN_DISTANCE_M = 0.01
"""Distance that all programs are told to keep, m."""
OBSTACLE = "obstacle"
"""Name of the obstacle and of its link in the description for the other programs."""
DURATION_S = 4.0


@dataclass(frozen=True)
class Start:
    """Where the arm starts."""

    name: str
    distance_m: float | None
    """Distance from the obstacle, m; none: at the start of the path."""


STARTS = (Start("outside", None), Start("touching", 0.0), Start("3 mm inside", -0.003))


@dataclass(frozen=True)
class Scene:
    """An arm, an obstacle, and a straight path of the tool."""

    name: str
    title: str
    source: str
    """URDF text without shapes."""
    tip: str
    """Link of the tool."""
    has_orientation: bool
    """Whether the tool keeps its orientation; otherwise only its position in the plane of the slides counts."""
    shapes: dict[str, Capsule]
    """One shape of each link that is watched, in the frame of the link."""
    obstacle: Capsule
    """Obstacle, in the base frame."""
    home: Array
    """Joint positions from which others are computed, n, rad or m."""
    path: tuple[Array, Array]
    """Both ends of the path of the tool, 3, m."""
    path_s: float
    """Time of the whole path, s."""
    acceleration: Array
    """Acceleration limits A, n, rad/s² or m/s²."""

    @functools.cached_property
    def joints(self) -> tuple[Joint, ...]:
        """Joints from the base to the tool."""
        return tuple(joint_of(element) for element in ET.fromstring(self.source).findall("joint"))

    @property
    def names(self) -> list[str]:
        """Names of the moving joints."""
        return [joint.name for joint in self.joints if joint.is_moving]

    @property
    def base(self) -> str:
        """Base link."""
        return ET.fromstring(self.source).findall("link")[0].attrib["name"]

    def limits(self, name: str) -> Array:
        """Returns an attribute of the limits of all moving joints: `lower`, `upper` or `velocity`, n."""
        elements = ET.fromstring(self.source).findall("joint")
        limits = [element.find("limit") for element in elements if element.get("type") != "fixed"]
        return np.array([float(limit.attrib[name]) for limit in limits if limit is not None])

    def tool(self, position: Array) -> Array:
        """Returns the pose of the tool, 4 × 4, m."""
        return link_poses(self.joints, position)[self.tip]

    def distance(self, position: Array) -> Array:
        """Returns the least distance of a link from the obstacle, …, m. `position`: … × n."""
        poses = link_poses(self.joints, position)
        each = [distance(shape.moved(poses[link]), self.obstacle) for link, shape in self.shapes.items()]
        return np.asarray(np.min(each, axis=0))

    def posture(self, tool: Array) -> Array:
        """Returns joint positions with the tool at a position, oriented as at home, n, rad or m."""
        position = self.home.copy()
        rotation = self.tool(self.home)[:3, :3]

        def error(position: Array) -> Array:
            pose = self.tool(position)
            turn = rotation_vector(rotation @ pose[:3, :3].T) if self.has_orientation else np.zeros(0)
            return np.concatenate([tool - pose[:3, 3], turn])

        for _ in range(50):
            rest = error(position)
            steps = 1e-6 * np.eye(len(position))
            jacobian = np.array([(error(position - step) - error(position + step)) / 2e-6 for step in steps]).T
            position = position + np.linalg.lstsq(jacobian, rest, rcond=1e-6)[0]
            if np.abs(rest).max() < 1e-12:
                break
        return position

    def start(self, start: Start) -> Array:
        """Returns the joint positions at the start of a run, n, rad or m."""
        first, last = self.path
        if start.distance_m is None:
            return self.posture(first)
        low, high = 0.0, 0.5
        for _ in range(60):
            middle = (low + high) / 2
            far = bool(self.distance(self.posture(first + middle * (last - first))) > start.distance_m)
            low, high = (middle, high) if far else (low, middle)
        return self.posture(first + (low + high) / 2 * (last - first))

    def targets(self, start: Array) -> Callable[[float], Array]:
        """Returns the target of the tool as a function of the time, 4 × 4, m.

        It moves from the tool's position at the start to the end of the path with the least jerk, and stands then.
        """
        pose = self.tool(start)
        way = self.path[1] - pose[:3, 3]
        whole = float(np.linalg.norm(self.path[1] - self.path[0]))
        time_s = self.path_s * float(np.linalg.norm(way)) / whole

        def target(now_s: float) -> Array:
            share = min(now_s / time_s, 1.0)
            result = pose.copy()
            result[:3, 3] += (10 * share**3 - 15 * share**4 + 6 * share**5) * way
            return result

        return target

    def urdf(self) -> str:
        """Returns the description for the other programs: with shapes, and with the obstacle as a link."""
        root = ET.fromstring(self.source)
        for link in root.findall("link"):
            if (shape := self.shapes.get(link.attrib["name"])) is not None:
                add_shape(link, shape)
        obstacle = ET.SubElement(root, "link", name=OBSTACLE)
        add_shape(obstacle, self.obstacle)
        joint = ET.SubElement(root, "joint", name=f"{OBSTACLE}_joint", type="fixed")
        ET.SubElement(joint, "parent", link=self.base)
        ET.SubElement(joint, "child", link=OBSTACLE)
        return ET.tostring(root, encoding="unicode")

    def urdf_file(self, folder: Path) -> Path:
        """Writes the description for the other programs."""
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{self.name}.urdf"
        path.write_text(self.urdf())
        return path


def numbers(text: str) -> Array:
    """Returns the numbers of an attribute."""
    return np.array([float(word) for word in text.split()])


def joint_of(element: ET.Element) -> Joint:
    """Reads a joint of a URDF."""
    pose, axis = np.eye(4), np.array([1.0, 0.0, 0.0])
    if (origin := element.find("origin")) is not None:
        pose[:3, 3] = numbers(origin.get("xyz", "0 0 0"))
        pose[:3, :3] = from_roll_pitch_yaw(list(numbers(origin.get("rpy", "0 0 0"))))
    if (stated := element.find("axis")) is not None:
        axis = numbers(stated.attrib["xyz"])
    child = element.find("child")
    if child is None:
        raise ValueError(f"joint {element.get('name')} has no child")
    return Joint(element.attrib["name"], child.attrib["link"], element.attrib["type"], pose, axis)


def add_shape(link: ET.Element, shape: Capsule) -> None:
    """Adds a shape to a link of a URDF.

    URDF has no capsules. Pinocchio makes one of a cylinder that `collision_checking` names.
    """
    along = shape.end - shape.start
    length = float(np.linalg.norm(along))
    collision = ET.SubElement(link, "collision", name="shape")
    origin = {"xyz": " ".join(repr(float(x)) for x in (shape.start + shape.end) / 2)}
    geometry = ET.Element("geometry")
    if length == 0:
        ET.SubElement(geometry, "sphere", radius=repr(shape.radius))
    else:
        x, y, z = along / length
        origin["rpy"] = f"0 {np.arctan2(np.hypot(x, y), z)!s} {np.arctan2(y, x)!s}"
        ET.SubElement(geometry, "cylinder", radius=repr(shape.radius), length=repr(length))
        ET.SubElement(ET.SubElement(link, "collision_checking"), "capsule", name="shape")
    ET.SubElement(collision, "origin", origin)
    collision.append(geometry)


def sphere(centre: list[float], radius: float) -> Capsule:
    """Returns a sphere."""
    return Capsule(np.array(centre), np.array(centre), radius)


def capsule(start: list[float], end: list[float], radius: float) -> Capsule:
    """Returns a capsule."""
    return Capsule(np.array(start), np.array(end), radius)


SLIDES_URDF = """<robot name="slides">
  <link name="base"/>
  <link name="carriage"/>
  <link name="tool"/>
  <joint name="x" type="prismatic">
    <parent link="base"/>
    <child link="carriage"/>
    <axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" effort="100" velocity="1.5"/>
  </joint>
  <joint name="y" type="prismatic">
    <parent link="carriage"/>
    <child link="tool"/>
    <axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="100" velocity="1.5"/>
  </joint>
</robot>
"""

SLIDES = Scene(
    name="slides",
    title="Two slides and a ball",
    source=SLIDES_URDF,
    tip="tool",
    has_orientation=False,
    shapes={"tool": sphere([0, 0, 0], 0.05)},
    obstacle=sphere([0.5, 0.02, 0], 0.1),
    home=np.zeros(2),
    path=(np.zeros(3), np.array([1.0, 0.0, 0.0])),
    path_s=2.0,
    acceleration=np.full(2, 5.0),
)


def panda_source() -> str:
    """Returns the Panda without what other programs do not read: version, acceleration and jerk."""
    text = (REPOSITORY / "fixtures/robots/panda.urdf").read_text()
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    return re.sub(r' (?:version="1\.2"|acceleration="[^"]*"|jerk="[^"]*")', "", text)


PANDA = Scene(
    name="panda",
    title="A Panda before a post",
    source=panda_source(),
    tip="panda_link8",
    has_orientation=True,
    # The capsules that revprio has for this arm. The base cannot move, so it has none.
    shapes={
        "panda_link1": capsule([0, 0, -0.14], [0, -0.055, 0], 0.077),
        "panda_link2": capsule([0, -0.14, 0], [0, 0, 0.055], 0.077),
        "panda_link3": capsule([0.083, 0.043, 0], [0, 0, -0.08], 0.07),
        "panda_link4": capsule([0, 0, 0.043], [-0.081, 0.084, 0], 0.07),
        "panda_link5": capsule([0, 0.064, 0.004], [0, 0.01, -0.245], 0.068),
        "panda_link6": capsule([0.087, 0.009, 0], [0.023, 0.007, 0.006], 0.075),
        "panda_link7": capsule([0, 0, 0.01], [0, 0, 0.06], 0.06),
    },
    obstacle=capsule([0.52, 0, 0], [0.52, 0, 0.6], 0.04),
    home=np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4]),
    path=(np.array([0.45, 0.3, 0.4]), np.array([0.45, -0.3, 0.4])),
    path_s=1.5,
    acceleration=np.array([15, 7.5, 10, 12.5, 15, 20, 20]),
)

SCENES = (SLIDES, PANDA)
