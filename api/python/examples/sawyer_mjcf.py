"""Creates a MuJoCo model of a torque-controlled Sawyer arm with a wall, from the URDF file in `fixtures`."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

# Mass (kg), centre of mass x y z (m), inertia xx yy zz xy xz yz (kg m²), all in the frame of the link.
# Published by the manufacturer: RethinkRobotics/sawyer_robot, sawyer_description/urdf/sawyer_base.urdf.xacro.
INERTIAL: dict[str, tuple[float, str, str]] = {
    "right_l0": (5.3213, "0.024366 0.010969 0.14363", "0.053314 0.057902 0.023659 0.0047093 0.011734 0.0080179"),
    "right_l1": (4.505, "-0.0030849 -0.026811 0.092521", "0.022398 0.014613 0.017295 -2.3986e-4 -2.9362e-4 -6.0875e-3"),
    "right_l2": (1.745, "-0.00016044 -0.014967 0.13582", "0.025506 0.0253 0.0034179 4.4101e-6 1.4955e-5 -3.3204e-3"),
    "right_l3": (2.5097, "-0.0048135 -0.0281 -0.084154", "0.01016 0.0065685 0.0069078 -9.7452e-6 2.6624e-4 3.0316e-3"),
    "right_l4": (1.1136, "-0.0018844 0.0069001 0.1341", "0.013557 0.013555 0.0013658 1.8109e-5 1.3523e-4 1.0561e-3"),
    "right_l5": (1.5625, "0.0061133 -0.023697 0.076416",
                 "0.0047328 0.0029676 0.0031762 1.1526e-4 4.6269e-5 -1.1557e-3"),
    "right_l6": (0.3292, "-8.0726e-6 0.0085838 -0.0049566",
                 "3.1105e-4 2.1549e-4 3.5976e-4 1.4771e-6 -3.7074e-7 -8.4533e-6"),
}  # fmt: skip
TOOL_RADIUS_M = 0.02


def sawyer_with_wall(urdf: Path, wall_x_m: float, timestep_s: float, contact_time_s: float, friction: float) -> str:
    """Returns the MJCF text of the model.

    `wall_x_m`: x coordinate of the tool point at first contact, base frame, m.
    `contact_time_s`: time constant of the contact (`solref`), s; a longer time constant makes the wall softer.
    `friction`: Coulomb friction in each joint, N·m.
    """
    robot = ET.parse(urdf).getroot()
    mjcf = ET.Element("mujoco", model="sawyer at a wall")
    ET.SubElement(mjcf, "compiler", angle="radian", eulerseq="XYZ")  # URDF: roll, pitch, yaw about fixed axes
    ET.SubElement(mjcf, "option", timestep=f"{timestep_s}", integrator="implicitfast", cone="elliptic")
    world = ET.SubElement(mjcf, "worldbody")
    surface = {"solref": f"{contact_time_s} 1", "friction": "0.2 0.005 0.0001"}
    at = f"{wall_x_m + TOOL_RADIUS_M + 0.05} 0 0.3"
    ET.SubElement(world, "geom", {"name": "wall", "type": "box", "size": "0.05 0.6 0.6", "pos": at} | surface)
    actuators = ET.SubElement(mjcf, "actuator")
    bodies = {"base": world}
    for joint in robot.findall("joint"):
        parent, child = (joint.find(end).attrib["link"] for end in ("parent", "child"))  # type: ignore[union-attr]
        origin = joint.find("origin").attrib  # type: ignore[union-attr]
        draw_link(bodies[parent], origin["xyz"])
        body = ET.SubElement(bodies[parent], "body", name=child, pos=origin["xyz"], euler=origin["rpy"])
        bodies[child] = body
        if joint.attrib["type"] == "revolute":
            add_joint(body, joint, actuators, friction)
            mass, centre, inertia = INERTIAL[child]
            ET.SubElement(body, "inertial", mass=f"{mass}", pos=centre, fullinertia=inertia)
    tool = {"name": "tool", "type": "sphere", "size": f"{TOOL_RADIUS_M}", "mass": "0.05"}
    ET.SubElement(bodies["tool"], "geom", tool | surface)
    return ET.tostring(mjcf, encoding="unicode")


def add_joint(body: ET.Element, joint: ET.Element, actuators: ET.Element, friction: float) -> None:
    """Adds a joint with its limits and friction, and a motor with the torque limit of the URDF file."""
    name, limit = joint.attrib["name"], joint.find("limit").attrib  # type: ignore[union-attr]
    bounds = f"{limit['lower']} {limit['upper']}"
    ET.SubElement(body, "joint", name=name, axis="0 0 1", range=bounds, frictionloss=f"{friction}", armature="0.1")
    effort = float(limit["effort"])
    ET.SubElement(actuators, "motor", joint=name, ctrllimited="true", ctrlrange=f"{-effort} {effort}")


def draw_link(body: ET.Element, end: str) -> None:
    """Adds a capsule to the next joint. It is only visible: it has no mass and no contacts."""
    if np.any(np.array(end.split(), dtype=float)):
        shape = {"type": "capsule", "fromto": f"0 0 0 {end}", "size": "0.045"}
        looks = {"contype": "0", "conaffinity": "0", "mass": "0", "rgba": "0.6 0.1 0.1 1"}
        ET.SubElement(body, "geom", shape | looks)


def posture() -> NDArray[np.float64]:
    """Returns the nominal posture of the scenarios as joint positions of the URDF model, rad."""
    signs, offsets = np.array([1, -1, 1, 1, 1, -1, 1]), np.radians([180, -90, 180, 0, 180, 0, 0])
    result: NDArray[np.float64] = signs * (np.array([2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2]) - offsets)
    return result
