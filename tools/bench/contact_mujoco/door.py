"""Opening a door whose radius the controller does not know."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import revprio

from contact_mujoco import scene
from contact_mujoco.arm import Arm
from contact_mujoco.conditions import NOISE_N
from contact_mujoco.robots import PANDA, Array
from contact_mujoco.tables import DRIVE, table

PERIOD_S = 0.002
PULL_N = 15.0
"""Force with which the tool pulls, N."""
DAMPING = 300.0
"""Damping of the force law, N·s/m: a free tool moves at 5 cm/s."""
GRIP = 1e4
"""Stiffness between gripper and handle, N/m."""
HINGE_FRICTION = 1.0
"""Friction of the hinge, N·m."""
DURATION_S = 20.0
OPEN_RAD = np.radians(60)
"""Angle at which the door counts as open, rad."""
MEMORY_M = 0.005
"""Way after which a direction of the motion is forgotten to 1/e, m."""


@dataclass
class Opening:
    """What a run shows; one row per period."""

    time_s: Array
    angle: Array
    """Angle of the door, rad."""
    radial: Array
    """Force across the motion of the handle, N."""
    points: Array
    """Places of the tool, 3, m."""
    arm: Arm
    """The arm at the end."""

    @property
    def radius_m(self) -> float:
        """Radius of the circle through the way of the tool, by least squares, m."""
        x, y = self.points[:, 0], self.points[:, 1]
        rows = np.column_stack([2 * x, 2 * y, np.ones_like(x)])
        a, b, c = np.linalg.lstsq(rows, x**2 + y**2, rcond=None)[0]
        return float(np.sqrt(c + a * a + b * b))


def model(radius_m: float, handle: Array) -> mujoco.MjModel:
    """Returns the arm with its gripper at the handle of a door, whose hinge is a radius to the left."""
    joint = f'<joint name="hinge" axis="0 0 1" damping="0.5" frictionloss="{HINGE_FRICTION}"/>'
    looks = 'contype="0" conaffinity="0" mass="5" rgba="0.6 0.5 0.35 1"'
    leaf = f'<geom type="box" size="0.015 {radius_m / 2} 0.3" pos="0.035 {-radius_m / 2} -0.1" {looks}/>'
    site = f'<site name="handle" pos="0 {-radius_m} 0"/>'
    place = scene.numbers(handle + np.array([0, radius_m, 0]))
    door = f'<body name="door" pos="{place}">{joint}{leaf}{site}</body>'
    soft = f'solref="-1 -1" solimp="{scene.IMPEDANCE} {scene.IMPEDANCE} 0.001 0.5 2"'
    grip = f'<equality><connect site1="sensor" site2="handle" {soft}/></equality>'
    return scene.model(PANDA, door, scene.BALL, grip)


def set_grip(arm: Arm) -> None:
    """Gives the grip its stiffness."""
    mujoco.mj_forward(arm.model, arm.data)
    arm.model.eq_solref[0] = scene.spring(arm.data, 0, GRIP)


def tasks() -> list[revprio.ControllerTask]:
    """Returns the tasks: a force along x, none along y and z, and an orientation that stays."""
    target = revprio.ConstantProfile(value=[PULL_N, 0, 0])
    pull = revprio.ForceLaw(inertia=2.0, damping=DAMPING, target_force=target)
    return [
        revprio.ControllerTask(name="pull", axes=["x", "y", "z"], law=pull),
        revprio.ControllerTask(name="hold", axes=["rx", "ry", "rz"], law=revprio.PoseLaw(gain=2.0)),
    ]


def opening(radius_m: float, *, follows: bool) -> Opening:
    """Opens a door; `follows`: whether the force turns with the motion of the tool, otherwise it stays along x."""
    pose = revprio.kinematics(robot="panda", joint_position=PANDA.start).pose
    arm = Arm(model(radius_m, np.asarray(pose.position)), PANDA.start, DRIVE, PERIOD_S, 2e-4)
    set_grip(arm)
    drive = revprio.JointDrive(lag_s=DRIVE.lag_s, delay_periods=DRIVE.delay_periods)
    law = revprio.Controller(robot="panda", period_s=PERIOD_S, drive=drive, tasks=tasks())
    noise = np.random.default_rng(1)
    hinge, direction, last = arm.model.joint("hinge").qposadr[0], np.array([1.0, 0, 0]), arm.point
    rows = []
    for number in range(round(DURATION_S / PERIOD_S)):
        way, last = arm.point - last, arm.point
        direction = direction + way / MEMORY_M
        direction /= np.linalg.norm(direction)
        targets = {"pull": revprio.StreamedTarget(force=PULL_N * direction)} if follows and number % 5 == 0 else None
        wrench = arm.filtered.copy()
        wrench[:3] += NOISE_N * noise.normal(size=3)
        answer = law.step(arm.position, joint_velocity=arm.velocity, wrench=wrench, targets=targets)
        arm.follow(np.asarray(answer.joint_velocity))
        angle = float(arm.data.qpos[hinge])
        rows.append((number * PERIOD_S, angle, arm.filtered[:3] @ [-np.sin(angle), np.cos(angle), 0], arm.point))
        if angle > OPEN_RAD:
            break
    time_s, angles, radial, points = (np.array(column) for column in zip(*rows, strict=True))
    return Opening(time_s, angles, radial, points, arm)


def doors() -> str:
    """Returns the table of doors."""
    rows = []
    for radius_m in (0.2, 0.3, 0.4):
        for follows in (False, True):
            found = opening(radius_m, follows=follows)
            is_open = found.angle[-1] > OPEN_RAD
            cells = [f"{np.degrees(found.angle[-1]):.0f}", f"{found.time_s[-1]:.1f}" if is_open else "–"]
            cells += [f"{np.abs(found.radial).max():.1f}", f"{found.radius_m:.3f}"]
            rows.append([radius_m, "along the motion" if follows else "along x", *cells])
    head = [
        "radius, m",
        "force",
        "angle at the end, °",
        "time to 60°, s",
        "most across the motion, N",
        "radius found, m",
    ]
    return table(head, rows)
