"""Runs of the law `contact`: an arm approaches a wall and presses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import mujoco
import numpy as np
import revprio

from contact_mujoco import scene
from contact_mujoco.arm import Arm
from contact_mujoco.conditions import NOISE_N, Conditions
from contact_mujoco.robots import DOWN, Array

LONGEST_APPROACH_S = 5.0
"""Time in which the tool must touch, s."""
HOLD_S = 1.6
"""Time of a run after the travel, s."""
DEPTH_M = 1e-6
"""Depth at which the stiffness of the wall is set, m."""
MAX_ACCELERATION = 5.0
"""Largest acceleration of the law along an axis, m/s²: its default."""
LONGEST_REVERSAL_S = 1.0
"""Longest time from a touch to the end of a full reversal, s."""


@dataclass
class Trace:
    """What a run shows."""

    time_s: list[float] = field(default_factory=list)
    force: list[float] = field(default_factory=list)
    """True force along the pressing direction at each step of the physics, N."""
    touched_s: float = 0.0
    """Start of the period of the first touch, s."""
    unavoidable: float = 0.0
    """Peak under full reversal, N."""
    fault: str | None = None
    """Why the law gave up."""
    state: str = ""
    """State of the law at the end."""
    stiffness: float = 0.0
    """Stiffness of the contact at the end, as F/depth shows it, N/m."""


class NoTouchError(Exception):
    """The tool has not reached the wall; the message is the fault or the state of the law."""


class Wall:
    """A plane in front of the tool, which can move and change its stiffness."""

    def __init__(self, arm: Arm, outward: Array) -> None:
        """Finds the wall of a model; `outward`: its normal."""
        self.arm, self.outward = arm, outward
        self.surface = arm.model.geom("surface").id

    def touch(self, stiffness: float, gap: float) -> None:
        """Sets the stiffness, N/m, and puts the wall a distance from the tool, m."""
        data = self.arm.data
        ball = self.arm.point - scene.TOOL_RADIUS_M * self.outward
        data.mocap_pos[0] = ball + DEPTH_M * self.outward
        scene.set_stiffness(self.arm.model, data, self.surface, stiffness)
        self.stiffness = stiffness
        self.place = ball - gap * self.outward
        data.mocap_pos[0] = self.place

    @property
    def depth(self) -> float:
        """Depth of the tool in the wall, m."""
        ball = self.arm.point - scene.TOOL_RADIUS_M * self.outward
        return float(self.outward @ (self.arm.data.mocap_pos[0] - ball))

    def move(self, way: float) -> None:
        """Moves the wall away from the tool, m, from where `touch` has put it."""
        self.arm.data.mocap_pos[0] = self.place - way * self.outward

    def change(self, factor: float) -> None:
        """Changes the stiffness by a factor; the wall moves so that the force stays."""
        depth = self.depth
        self.arm.model.geom_solref[self.surface] *= [factor, np.sqrt(factor)]
        self.stiffness *= factor
        self.place = self.arm.data.mocap_pos[0] + depth * (1 / factor - 1) * self.outward
        self.arm.data.mocap_pos[0] = self.place


Event = Callable[[float, Wall], None]
"""What happens to the wall: gets the time since the first touch, s, once per period."""


class Rig:
    """An arm at rest above its wall, its controller, and what its sensors read."""

    row = np.array([0, 0, -1.0, 0, 0, 0])
    """What measures the force: the row times the wrench on the wall is F."""

    def __init__(self, conditions: Conditions) -> None:
        """Builds all."""
        self.conditions = conditions
        self.arm = Arm(
            self.model(), conditions.robot.start, conditions.drive, conditions.period_s, conditions.timestep_s
        )
        self.wall = self.stand()
        self.law = self.controller()
        self._noise = np.random.default_rng(conditions.seed)

    def model(self) -> mujoco.MjModel:
        """Returns the model."""
        return scene.model(self.conditions.robot, scene.wall(np.zeros(3), -DOWN))

    def stand(self) -> Wall:
        """Returns the wall, in its place."""
        wall = Wall(self.arm, -DOWN)
        wall.touch(self.conditions.stiffness, gap_m(self.conditions))
        return wall

    def tasks(self) -> list[revprio.ControllerTask]:
        """Returns the tasks of the preset `push`, told the drive and not the stiffness."""
        terms, told = self.conditions, self.conditions.told
        return revprio.push(
            "z",
            -terms.target,
            period_s=terms.period_s,
            lag_s=told.lag_s,
            delay_periods=told.delay_periods,
            approach_speed=terms.speed,
        )

    def controller(self) -> revprio.Controller:
        """Returns the controller."""
        told = self.conditions.told
        drive = revprio.JointDrive(lag_s=told.lag_s, delay_periods=told.delay_periods)
        robot, period_s = self.conditions.robot.name, self.conditions.period_s
        return revprio.Controller(robot=robot, period_s=period_s, drive=drive, tasks=self.tasks())

    def step(self) -> revprio.StepAnswer:
        """Gives the controller what the sensors read; returns its answer."""
        wrench = self.arm.filtered.copy()
        wrench[:3] += NOISE_N * self._noise.normal(size=3)
        return self.law.step(self.arm.position, joint_velocity=self.arm.velocity, wrench=wrench)

    def forces(self, arm: Arm, wrenches: Array) -> Array:
        """Returns the force F of each step of an arm, N; 0 without contact, but for the weight of the ball."""
        del arm
        forces = wrenches @ self.row
        return np.where(forces > 1e-6, forces, 0.0)


def gap_m(conditions: Conditions) -> float:
    """Returns the way to the wall, m: the tool has its speed before it touches."""
    random = np.random.default_rng([conditions.seed, 1])
    drive, speed = conditions.drive, conditions.speed
    reaction = 5 * drive.lag_s + (drive.delay_periods + random.random()) * conditions.period_s + 5 / drive.bandwidth
    return speed * (0.05 + reaction) + speed**2


def run(conditions: Conditions, event: Event | None = None, extra_s: float = 0.0) -> Trace:
    """Lets the arm press; `event`: what happens after the touch; `extra_s`: how much longer the run is."""
    return press(Rig(conditions), event, extra_s)


def press(rig: Rig, event: Event | None = None, extra_s: float = 0.0) -> Trace:
    """Lets the arm of a rig press."""
    arm, wall, period_s = rig.arm, rig.wall, rig.conditions.period_s
    trace, touched_s, now_s = Trace(), None, 0.0
    end_s, approach = LONGEST_APPROACH_S, np.zeros(arm.joints)
    while now_s < end_s:
        if touched_s is not None and event is not None:
            event(now_s - touched_s, wall)
        answer = rig.step()
        command = np.asarray(answer.joint_velocity)
        forces = rig.forces(arm, arm.follow(command))
        trace.force.extend(forces)
        trace.time_s.extend(now_s + arm.timestep_s * np.arange(1, arm.substeps + 1))
        if touched_s is None:
            approach = max(approach, command, key=np.linalg.norm)
        if touched_s is None and forces.any():
            touched_s = trace.touched_s = now_s
            end_s = now_s + HOLD_S + 1.5 * rig.conditions.travel_s + extra_s
            # Nothing has shown the touch before this period ends.
            trace.unavoidable = max(float(forces.max()), reversal(rig, approach))
        now_s += period_s
    report = answer.tasks[0].contact[0]
    if touched_s is None:
        raise NoTouchError(report.fault or report.state)
    trace.state, trace.fault = report.state, report.fault
    trace.stiffness = trace.force[-1] / wall.depth if wall.depth > 0 else 0.0
    return trace


def reversal(rig: Rig, command: Array) -> float:
    """Returns the peak force under a full reversal, N: the command of the approach falls by a T in each period.

    It begins with the first reading whose part without noise exceeds 3 σ. On a rigid drive no controller that reacts
    then or later, and brakes with a at most, has a smaller peak; see docs/contact.md. a is 5 m/s², or what the joints
    permit along this motion. The arm of the rig has just touched; it stays where it is.
    """
    arm, conditions = rig.arm.copy(), rig.conditions
    joint_rate = np.abs(command) / conditions.speed
    limits = conditions.robot.acceleration_limits
    acceleration = min(MAX_ACCELERATION, float(np.min(limits / np.maximum(joint_rate, 1e-9))))
    step = acceleration * conditions.period_s / conditions.speed
    peak, share, detected = 0.0, 1.0, False
    for _ in range(round(LONGEST_REVERSAL_S / conditions.period_s)):
        detected = detected or bool(arm.filtered @ rig.row > 3 * NOISE_N)
        share -= step if detected else 0.0
        force = float(rig.forces(arm, arm.follow(share * command)).max())
        peak = max(peak, force)
        if detected and force == 0:
            break
    return peak
