"""Tools with a weight, and a sensor with a bias."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import mujoco
import numpy as np
import revprio
from revprio.models import ContactLaw, SineProfile

from contact_mujoco import pressing, scene
from contact_mujoco.arm import Arm
from contact_mujoco.conditions import NOISE_N, Conditions
from contact_mujoco.pressing import Rig
from contact_mujoco.robots import DOWN, PANDA, Array
from contact_mujoco.score import score
from contact_mujoco.tables import VERDICT, table, terms, verdict

GRAVITY = 9.81
"""m/s²."""
CENTRE_M = 0.05
"""Distance of the centre of mass from the tool point, along the axis of the tool, m."""
BIAS_N = np.array([2.0, -1.0, 2.0])
"""Bias of the sensor, 3 N, along its axes."""
TURN_RAD = 0.7
"""How far the tool turns while it presses, rad."""


@dataclass(frozen=True)
class Weight:
    """A tool with a weight, and what the controller is told about it."""

    mass_kg: float
    stated_kg: float
    compensates: bool = False
    """Whether the controller subtracts the inertia of the tool."""
    turns: bool = False
    """Whether the tool turns to and fro about x of the base."""
    left_n: float = 0.0
    """`bias` of the law: the error that the controller is told to expect, N."""


class Heavy(Rig):
    """The sensor carries a heavy tool, has a bias, and is tared at the start."""

    def __init__(self, conditions: Conditions, weight: Weight) -> None:
        """Builds all."""
        self._weight = weight
        self._touched = False
        self.false_contacts = 0
        """Periods before the touch in which the law saw a contact."""
        super().__init__(conditions)

    def model(self) -> mujoco.MjModel:
        """Returns the model with the weight."""
        place = f'pos="0 0 {-CENTRE_M}" mass="{self._weight.mass_kg}"'
        mass = f'<geom type="sphere" size="0.01" {place} contype="0" conaffinity="0"/>'
        return scene.model(self.conditions.robot, scene.wall(np.zeros(3), -DOWN), scene.BALL + mass)

    def reading(self, samples: int = 1) -> Array:
        """Returns the mean of some readings, 6, along the axes of the sensor."""
        axes = self.arm.data.site("sensor").xmat.reshape(3, 3)
        wrench = (self.arm.filtered.reshape(2, 3) @ axes).ravel()
        wrench[:3] += BIAS_N + NOISE_N / np.sqrt(samples) * self._noise.normal(size=3)
        return np.asarray(wrench)

    def tare(self) -> revprio.Wrench:
        """Returns the bias: the reading at rest without the weight that the controller knows."""
        self._noise = np.random.default_rng(self.conditions.seed)
        for _ in range(50):
            self.arm.follow(np.zeros(self.arm.joints))
        axes = self.arm.data.site("sensor").xmat.reshape(3, 3)
        weight = -GRAVITY * self._weight.stated_kg * (axes.T @ DOWN)
        rest = self.reading(100) - np.concatenate([weight, np.cross([0, 0, -CENTRE_M], weight)])
        return revprio.Wrench(force=rest[:3], torque=rest[3:])

    def tasks(self) -> list[revprio.ControllerTask]:
        """Returns the tasks of `push`, or the same with a tool that turns."""
        tasks = super().tasks()
        law = tasks[0].law
        assert isinstance(law, ContactLaw)
        fields: dict[str, Any] = {name: getattr(law, name) for name in law.model_fields_set}
        law = ContactLaw(**(fields | {"bias": self._weight.left_n}))
        tasks[0] = tasks[0].model_copy(update={"law": law})
        if not self._weight.turns:
            return tasks
        sway = SineProfile(offset=0.0, amplitude=TURN_RAD, angular_frequency_rad_s=1.0)
        hold = revprio.ControllerTask(name="hold", axes=["x", "y", "ry", "rz"], law=tasks[1].law)
        turn = revprio.ControllerTask(name="turn", axes=["rx"], law=revprio.PoseLaw(gain=2.0, target_displacement=sway))
        return [tasks[0], turn, hold]

    def controller(self) -> revprio.Controller:
        """Returns the controller with its sensor."""
        told, weight = self.conditions.told, self._weight
        payload = revprio.Payload(mass_kg=weight.stated_kg, center_of_mass=[0, 0, -CENTRE_M])
        sensor = revprio.WrenchSensor(
            bias=self.tare(),
            payload=payload,
            compensate_inertia=weight.compensates,
        )
        return revprio.Controller(
            robot=self.conditions.robot.name,
            period_s=self.conditions.period_s,
            drive=revprio.JointDrive(lag_s=told.lag_s, delay_periods=told.delay_periods),
            tasks=self.tasks(),
            wrench_frame="tool",
            wrench_sensor=sensor,
        )

    def step(self) -> revprio.StepAnswer:
        """Gives the reading along the axes of the sensor."""
        answer = self.law.step(self.arm.position, joint_velocity=self.arm.velocity, wrench=self.reading())
        self._touched = self._touched or self.wall.depth > 0
        if not self._touched:
            self.false_contacts += answer.tasks[0].contact[0].state != "approach"
        return answer

    def forces(self, arm: Arm, wrenches: Array) -> Array:
        """Returns the force between ball and wall at the end of the period: the sensor measures the weight too."""
        data = arm.data
        depth = data.mocap_pos[0, 2] - data.site_xpos[arm.site, 2] + scene.TOOL_RADIUS_M
        return np.full(len(wrenches), max(0.0, self.conditions.stiffness * depth))


def weights() -> str:
    """Returns the table of tools with a weight."""
    rows = []
    for mass, compensates, left, speed in product((0.5, 1.0, 2.0), (False, True), (0.0, 1.0), (0.01, 0.1)):
        conditions = terms(PANDA, 1e4, speed=speed)
        rig = Heavy(conditions, Weight(mass, mass, compensates, left_n=left))
        try:
            found = verdict(score(conditions, pressing.press(rig)))
        except pressing.NoTouchError as error:
            found = [f"does not arrive: {error}", "–", "–", "–", "–"]
        cells = [mass, "yes" if compensates else "no", f"{left:.0f}", f"{100 * speed:.0f}"]
        rows.append([*cells, rig.false_contacts, *found])
    head = ["tool, kg", "inertia compensated", "`bias`, N", "approach, cm/s", "periods of false contact", *VERDICT]
    return table(head, rows)


def postures() -> str:
    """Returns the table of a tool that turns by ± 40° while it presses: errors of the true force in the last 6.3 s."""
    rows = []
    for mass, stated in ((0.5, 0.5), (2.0, 2.0), (0.5, 0.4), (0.5, 0.0)):
        conditions = terms(PANDA, 1e4)
        try:
            trace = pressing.press(Heavy(conditions, Weight(mass, stated, compensates=True, turns=True)), extra_s=6.3)
        except pressing.NoTouchError as error:
            rows.append([mass, stated, "–", "–", f"does not arrive: {error}"])
            continue
        force = np.array(trace.force)[np.array(trace.time_s) > trace.time_s[-1] - 6.3] - conditions.target
        rows.append([mass, stated, f"{force.mean():.2f}", f"{force.min():.2f}, {force.max():.2f}", trace.fault or "–"])
    return table(["tool, kg", "stated, kg", "mean error, N", "least, most, N", "fault"], rows)
