"""MJCF models of an arm with a tool, in front of what it touches."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import mujoco
import numpy as np

from contact_mujoco.robots import ARMATURE, Array, Robot

TOOL_RADIUS_M = 0.02
"""Radius of the ball that presses, m. The tool point is its middle."""
BALL = f'<geom name="tool" type="sphere" size="{TOOL_RADIUS_M}" mass="1e-9" rgba="0.2 0.2 0.2 1"/>'
"""The tool of most runs. It has no weight, so that the sensor behind it measures the contact."""
IMPEDANCE = 1e-3
"""Impedance d of each contact (`solimp`). It is so small that the force is that of a spring; see `set_stiffness`."""
SURFACE = f'solimp="{IMPEDANCE} {IMPEDANCE} 0.001 0.5 2" solref="-1 -1" priority="1" rgba="0.6 0.7 0.8 1"'
"""Attributes of everything that the tool touches; `set_stiffness` completes them."""
REFERENCE_MASS_KG = 5.0
DAMPING_RATIO = 0.02
"""Damping of each contact: this share of the critical one for the reference mass."""


def numbers(values: Array | list[float]) -> str:
    """Returns an attribute of MJCF."""
    return " ".join(f"{float(value):.17g}" for value in values)


def model(robot: Robot, world: str = "", tool: str = BALL, more: str = "") -> mujoco.MjModel:
    """Returns the model of an arm with motors.

    `world`: MJCF of what is around the arm; `tool`: MJCF of what is fixed to the tool frame; `more`: MJCF of the rest.
    """
    root = ET.Element("mujoco", model=robot.name)
    ET.SubElement(root, "compiler", angle="radian", eulerseq="XYZ")
    ET.SubElement(root, "option", integrator="Euler", cone="elliptic", tolerance="1e-12", impratio="1000")
    visual = ET.SubElement(root, "visual")
    ET.SubElement(visual, "global", offwidth="1280", offheight="960")
    white = {"type": "skybox", "builtin": "flat", "rgb1": "1 1 1", "width": "8", "height": "8"}
    ET.SubElement(ET.SubElement(root, "asset"), "texture", white)
    scene = ET.SubElement(root, "worldbody")
    ET.SubElement(scene, "light", pos="1 -1 3", dir="-0.3 0.3 -1", diffuse="0.8 0.8 0.8")
    actuators = ET.SubElement(root, "actuator")
    body = scene
    number = 0
    for joint in robot.joints:
        body = add_link(body, joint)
        if joint.attrib["type"] == "revolute":
            add_joint(body, joint, actuators)
            centre = middle(robot, number)
            ET.SubElement(body, "inertial", robot.inertial(number, body.attrib["name"], centre))
            number += 1
    body.append(ET.fromstring(f'<body name="end"><site name="sensor" size="0.001"/>{tool}</body>'))
    root.append(ET.fromstring('<sensor><force site="sensor"/><torque site="sensor"/></sensor>'))
    scene.extend(ET.fromstring(f"<world>{world}</world>"))
    root.extend(ET.fromstring(f"<more>{more}</more>"))
    return mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))


def middle(robot: Robot, number: int) -> Array:
    """Returns the middle between the ends of the link behind a moving joint, in its frame, m."""
    joints = robot.joints
    behind = [index for index, joint in enumerate(joints) if joint.attrib["type"] == "revolute"][number] + 1
    if behind == len(joints):
        return np.zeros(3)
    return 0.5 * np.array(joints[behind].find("origin").attrib["xyz"].split(), dtype=float)  # type: ignore[union-attr]


def add_link(parent: ET.Element, joint: ET.Element) -> ET.Element:
    """Adds the body behind a joint, and a capsule to it that is only visible."""
    origin = joint.find("origin").attrib  # type: ignore[union-attr]
    if np.any(np.array(origin["xyz"].split(), dtype=float)):
        shape = {"type": "capsule", "fromto": f"0 0 0 {origin['xyz']}", "size": "0.03", "rgba": "0.75 0.3 0.2 1"}
        ET.SubElement(parent, "geom", shape | {"contype": "0", "conaffinity": "0", "mass": "0"})
    child = joint.find("child").attrib["link"]  # type: ignore[union-attr]
    return ET.SubElement(parent, "body", name=child, pos=origin["xyz"], euler=origin["rpy"])


def add_joint(body: ET.Element, joint: ET.Element, actuators: ET.Element) -> None:
    """Adds a joint and a motor with the torque limit of the URDF file."""
    name, limit = joint.attrib["name"], joint.find("limit").attrib  # type: ignore[union-attr]
    ET.SubElement(body, "joint", name=name, axis="0 0 1", armature=f"{ARMATURE}")
    effort = float(limit["effort"])
    ET.SubElement(actuators, "motor", joint=name, ctrllimited="true", ctrlrange=f"{-effort} {effort}")


def friction(sliding: float) -> str:
    """Returns the attributes of a surface with Coulomb friction."""
    return 'condim="1"' if sliding == 0 else f'condim="3" friction="{sliding} 0 0"'


def wall(position: Array, outward: Array, sliding: float = 0.0) -> str:
    """Returns a plane that a run can move; `outward`: its normal, towards the tool; `sliding`: Coulomb friction."""
    axes = f'pos="{numbers(position)}" quat="{numbers(turn_to(outward))}"'
    geom = f'<geom name="surface" type="plane" size="0.3 0.3 0.01" {friction(sliding)} {SURFACE}/>'
    return f'<body name="wall" mocap="true" {axes}>{geom}</body>'


def turn_to(direction: Array) -> Array:
    """Returns the quaternion w, x, y, z that turns the axis z to a direction."""
    unit = direction / np.linalg.norm(direction)
    if unit[2] < -1 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    quaternion = np.array([1 + unit[2], -unit[1], unit[0], 0.0])
    return np.asarray(quaternion / np.linalg.norm(quaternion))


def set_stiffness(model: mujoco.MjModel, data: mujoco.MjData, surface: int, stiffness: float) -> None:
    """Gives a surface the stiffness K, N/m, and a damping. `data`: a state in which the tool touches it.

    A contact of MuJoCo has the force (a_ref − a)/R, a_ref = −b v − k d r. With a small impedance d, R is so large that
    the acceleration a hardly counts; then the stiffness is k d/R, whatever the posture.
    """
    scratch = mujoco.MjData(model)
    scratch.qpos[:], scratch.mocap_pos[:], scratch.mocap_quat[:] = data.qpos, data.mocap_pos, data.mocap_quat
    model.geom_solref[surface] = [-1.0, -1.0]
    mujoco.mj_forward(model, scratch)
    rows = [c.efc_address for c in scratch.contact if surface in c.geom]
    if not rows:
        raise ValueError(f"the tool does not touch {model.geom(surface).name}")
    model.geom_solref[surface] = spring(scratch, rows[0], stiffness)


def spring(data: mujoco.MjData, row: int, stiffness: float) -> list[float]:
    """Returns `solref` for a stiffness, N/m, of a constraint that has the `solref` of −1 and −1 now."""
    k, b, impedance, _ = data.efc_KBIP[row]
    resistance = data.efc_R[row]
    damping = 2 * DAMPING_RATIO * np.sqrt(stiffness * REFERENCE_MASS_KG)
    return [-stiffness * resistance / (k * impedance), -damping * resistance / b]
