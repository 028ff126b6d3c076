"""A peg that presses on an edge, and one that finds a hole by a spiral."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import revprio
from revprio.models import ContactLaw

from contact_mujoco import scene
from contact_mujoco.arm import Arm
from contact_mujoco.conditions import NOISE_N
from contact_mujoco.robots import DOWN, PANDA, Array
from contact_mujoco.tables import DRIVE, short, table

PERIOD_S = 0.002
RADIUS_M = 0.01
"""Radius of the peg, m."""
LENGTH_M = 0.04
DEPTH_M = 0.02
"""Depth of the hole, m."""
HALF_M = 0.1
"""Half of the width of the block, m."""
SLIDING = 0.3
"""Friction between peg and block."""
TARGET_N = 10.0
APPROACH = 0.02
"""Approach speed, m/s."""
GAP_M = 0.003
"""Way to the block at the start, m."""
SEARCH_SPEED = 0.01
"""Speed along the spiral, m/s."""
INSERTED_M = 0.003
"""Depth at which the peg counts as inserted, m."""
TOUCH_M = 1e-4
"""Depth at which the stiffness of a block is set, m."""
DURATION_S = 20.0
AFTER_S = 3.0
"""Time of a run after the peg is inserted, s."""


@dataclass(frozen=True)
class Block:
    """A block below the peg: with a square hole, or with an edge."""

    clearance_m: float | None
    """Play of the peg on each side of the hole, m; `None`: an edge in place of a hole."""
    offset: tuple[float, float]
    """Place of the middle of the hole, or of the edge along x, seen from the peg, m."""
    stiffness: float

    def mjcf(self, bottom: Array) -> str:
        """Returns the block; `bottom`: middle of the lower end of the peg, m."""
        x, y = bottom[:2] + self.offset
        top = bottom[2] - GAP_M
        if self.clearance_m is None:
            return box(x - HALF_M, y, HALF_M, HALF_M, top)
        side = RADIUS_M + self.clearance_m
        wide = 0.5 * (HALF_M - side)
        far = side + wide
        boxes = [
            box(x - far, y, wide, HALF_M, top),
            box(x + far, y, wide, HALF_M, top),
            box(x, y - far, side, wide, top),
            box(x, y + far, side, wide, top),
            box(x, y, side, side, top - DEPTH_M),
        ]
        return "".join(boxes)


def box(x: float, y: float, half_x: float, half_y: float, top: float) -> str:
    """Returns a box whose upper side has a height."""
    half_z = 0.02
    size = f'type="box" size="{half_x} {half_y} {half_z}" pos="{x} {y} {top - half_z}"'
    return f"<geom {size} {scene.friction(SLIDING)} {scene.SURFACE}/>"


def peg() -> str:
    """Returns the peg, whose upper end is at the tool point."""
    shape = f'type="cylinder" size="{RADIUS_M} {LENGTH_M / 2}" pos="0 0 {LENGTH_M / 2}"'
    return f'<geom name="tool" {shape} mass="1e-9" rgba="0.2 0.2 0.2 1"/>'


def spiral(length_m: float, pitch_m: float) -> Array:
    """Returns the place on a spiral of Archimedes after a way along it, 2, m."""
    turn = np.sqrt(4 * np.pi * length_m / pitch_m)
    return np.asarray(pitch_m / (2 * np.pi) * turn * np.array([np.cos(turn), np.sin(turn)]))


@dataclass
class Search:
    """What a run shows; one row per period."""

    time_s: Array
    force: Array
    """Force of the peg on the block, 3, N."""
    points: Array
    """Way of the peg since the start, 3, m."""
    inserted_s: float | None
    """When the peg was inserted, s."""
    state: str
    """State of the law at the end, and its fault."""
    losses: int
    arm: Arm
    """The arm at the end."""


def solref(bottom: Array, stiffness: float) -> list[float]:
    """Returns `solref` for a stiffness of each point of contact, N/m, from a peg on a block without a hole."""
    touching = bottom - (GAP_M + TOUCH_M) * DOWN
    model = scene.model(PANDA, Block(None, (0.0, 0.0), stiffness).mjcf(touching), peg())
    data = mujoco.MjData(model)
    data.qpos[:] = PANDA.start
    mujoco.mj_forward(model, data)
    return scene.spring(data, int(data.contact[0].efc_address), stiffness)


class Cell:
    """The arm with its peg above a block, and its controller."""

    def __init__(self, block: Block) -> None:
        """Builds all."""
        pose = revprio.kinematics(robot="panda", joint_position=PANDA.start).pose
        self.home = np.asarray(pose.position)
        bottom = self.home + LENGTH_M * DOWN
        model = scene.model(PANDA, block.mjcf(bottom), peg())
        model.geom_solref[model.geom_priority == 1] = solref(bottom, block.stiffness)
        self.arm = Arm(model, PANDA.start, DRIVE, PERIOD_S, 1e-4)
        drive = revprio.JointDrive(lag_s=DRIVE.lag_s, delay_periods=DRIVE.delay_periods)
        press = ContactLaw(target_force=revprio.ConstantProfile(value=-TARGET_N), approach_speed=APPROACH)
        tasks = [
            revprio.ControllerTask(name="press", axes=["z"], law=press),
            revprio.ControllerTask(name="search", axes=["x", "y"], law=revprio.PoseLaw(gain=10.0)),
            revprio.ControllerTask(name="hold", axes=["rx", "ry", "rz"], law=revprio.PoseLaw(gain=2.0)),
        ]
        self.law = revprio.Controller(robot="panda", period_s=PERIOD_S, drive=drive, tasks=tasks)
        self._noise = np.random.default_rng(1)

    def step(self, place: Array) -> revprio.StepAnswer:
        """Runs a period; `place`: where the peg should be, seen from the start, 2, m."""
        wrench = self.arm.filtered.copy()
        wrench[:3] += NOISE_N * self._noise.normal(size=3)
        pose = revprio.StreamedPose(position=[*(self.home[:2] + place), self.home[2]])
        answer = self.law.step(
            self.arm.position,
            joint_velocity=self.arm.velocity,
            wrench=wrench,
            targets={"search": revprio.StreamedTarget(pose=pose)},
        )
        self.arm.follow(np.asarray(answer.joint_velocity))
        return answer


def search(block: Block, pitch_m: float = 0.0) -> Search:
    """Presses, and looks for the hole along a spiral from the touch on; `pitch_m`: 0 for none."""
    cell = Cell(block)
    rows, inserted_s, way_m, place, losses = [], None, 0.0, np.zeros(2), 0
    duration_s = DURATION_S if pitch_m else AFTER_S
    for number in range(round(duration_s / PERIOD_S)):
        now_s = number * PERIOD_S
        answer = cell.step(place)
        moved = cell.arm.point - cell.home
        rows.append((now_s, cell.arm.filtered[:3].copy(), moved))
        losses += answer.tasks[0].contact[0].event == "loss"
        if inserted_s is None and moved[2] < -GAP_M - INSERTED_M:
            inserted_s = now_s
        if inserted_s is None and pitch_m and -cell.arm.filtered[2] > 0.5 * TARGET_N:
            way_m += SEARCH_SPEED * PERIOD_S
            place = spiral(way_m, pitch_m)
        if inserted_s is not None and now_s > inserted_s + AFTER_S:
            break
    time_s, forces, points = (np.array(column) for column in zip(*rows, strict=True))
    report = answer.tasks[0].contact[0]
    state = f"fault: {report.fault}" if report.fault else report.state
    return Search(time_s, forces, points, inserted_s, state, losses, cell.arm)


def row(found: Search) -> list[object]:
    """Returns the cells that both tables share: the last force, the largest ones, losses and state."""
    last = -found.force[-200:, 2].mean()
    across = np.linalg.norm(found.force[:, :2], axis=1).max()
    return [f"{last:.2f}", f"{-found.force[:, 2].min():.1f}", f"{across:.1f}", found.losses, found.state]


LAST = ["most, N", "most across, N", "losses", "state"]


def edges() -> str:
    """Returns the table of pegs that press on an edge."""
    rows = []
    for over_m in (0.005, 0.0, -0.005, -0.009):
        for stiffness in (1e4, 1e5):
            found = search(Block(None, (over_m, 0.0), stiffness))
            rows.append([f"{1e3 * (RADIUS_M + over_m):.0f}", short(stiffness), *row(found)])
    head = [
        "on the block, mm of 20",
        "K of a point, N/m",
        "force at the end, N",
        "most, N",
        "most across, N",
        "losses",
        "state",
    ]
    return table(head, rows)


def holes() -> str:
    """Returns the table of searches."""
    rows = []
    for clearance_m in (0.0002, 0.0005):
        for offset in ((0.001, 0.0), (0.002, -0.002), (-0.004, 0.003)):
            for stiffness in (1e4, 1e5):
                found = search(Block(clearance_m, offset, stiffness), 2 * clearance_m)
                name = f"{1e3 * offset[0]:.0f}, {1e3 * offset[1]:.0f}"
                inserted = "–" if found.inserted_s is None else f"{found.inserted_s:.1f}"
                rows.append([1e3 * clearance_m, name, short(stiffness), inserted, *row(found)])
    head = ["clearance, mm", "hole at x, y, mm", "K of a point, N/m", "inserted after, s", "force at the end, N"]
    return table([*head, *LAST], rows)
