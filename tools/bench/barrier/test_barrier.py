"""Tests of the scenes, the plant and the score: `python -m unittest barrier.test_barrier`."""

from __future__ import annotations

import unittest
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
from behaviour import arm
from behaviour.rotations import Array

from barrier import entries
from barrier.controllers.base import Answer
from barrier.plant import LAGGING, PERFECT, PLACES, Plant, brake
from barrier.referee import Capsule, distance
from barrier.scenes import PANDA, PERIOD_S, SCENES, SLIDES, STARTS, Scene, capsule, sphere
from barrier.score import score
from barrier.simulate import run


class Straight:
    """Follows the target without regard to anything."""

    def __init__(self, scene: Scene, last: int | None = None) -> None:
        """`last`: the number of periods after which it refuses."""
        self._last, self._done = last, 0
        self._scene = scene

    def tool(self, position: Array) -> Array:
        """Returns the position of the tool, 3, m."""
        return self._scene.tool(position)[:3, 3]

    def step(self, position: Array, last: Array, target: Array) -> Answer:  # noqa: ARG002
        """Returns the velocity that reaches the target in one period."""
        self._done += 1
        if self._last is not None and self._done > self._last:
            return Answer(None, "enough")
        return Answer((target[:2, 3] - position) / PERIOD_S)

    def close(self) -> None:
        """Does nothing."""


class Tests(unittest.TestCase):
    """The parts that all entries share."""

    def test_distances_are_those_of_a_search(self) -> None:
        """Capsules, spheres, and capsules that are nearly or exactly parallel."""
        random = np.random.default_rng(0)
        places = np.linspace(0, 1, 201)
        for number in range(60):
            first, second = random.normal(size=(2, 2, 3))
            if number % 3 == 1:
                second[1] = second[0] + 0.7 * (first[1] - first[0]) + (number % 2) * 1e-7
            if number % 3 == 2:
                first[1] = first[0]
            one, other = (Capsule(ends[0], ends[1], 0.1) for ends in (first, second))
            a, b = (ends[0] + places[:, None] * (ends[1] - ends[0]) for ends in (first, second))
            searched = np.linalg.norm(a[:, None] - b[None], axis=2).min() - 0.2
            self.assertLessEqual(float(distance(one, other)), searched + 1e-12)
            self.assertGreater(float(distance(one, other)), searched - 0.03)
            self.assertAlmostEqual(float(distance(one, other)), float(distance(other, one)), places=12)

    def test_crossing_segments_intersect_by_their_radii(self) -> None:
        """The distance of axes that cross is zero."""
        cross = distance(capsule([-1, 0, 0], [1, 0, 0], 0.1), capsule([0, -1, 0], [0, 1, 0], 0.2))
        self.assertAlmostEqual(float(cross), -0.3, places=15)
        self.assertAlmostEqual(float(distance(sphere([0, 0, 0], 0.1), sphere([1, 0, 0], 0.2))), 0.7, places=15)

    def test_panda_has_the_kinematics_and_limits_of_the_other_comparison(self) -> None:
        """Two readers of the same description agree."""
        other = arm.load()
        random = np.random.default_rng(1)
        for position in random.uniform(other.lower, other.upper, size=(20, 7)):
            np.testing.assert_allclose(PANDA.tool(position), other.tool(position), atol=1e-12)
        np.testing.assert_array_equal(PANDA.acceleration, other.acceleration)
        np.testing.assert_array_equal(PANDA.limits("velocity"), other.velocity)
        self.assertEqual(PANDA.names, other.names)

    def test_runs_start_where_they_should(self) -> None:
        """Outside, touching and 3 mm inside, within the limits of the joints."""
        for scene in SCENES:
            for start in STARTS:
                position = scene.start(start)
                self.assertTrue(np.all((scene.limits("lower") < position) & (position < scene.limits("upper"))))
                if start.distance_m is None:
                    self.assertGreater(scene.distance(position), 0.1)
                else:
                    self.assertAlmostEqual(float(scene.distance(position)), start.distance_m, places=9)

    def test_path_leads_through_the_obstacle(self) -> None:
        """Each arm that follows it hits the obstacle."""
        for scene in SCENES:
            first, last = scene.path
            shares = np.linspace(0, 1, 21)
            least = min(float(scene.distance(scene.posture(first + share * (last - first)))) for share in shares)
            self.assertLess(least, -0.02)

    def test_targets_end_at_rest(self) -> None:
        """Position and velocity are continuous at both ends."""
        target = SLIDES.targets(np.zeros(2))
        self.assertLess(np.abs(target(1e-4) - target(0.0)).max(), 1e-9)
        np.testing.assert_array_equal(target(SLIDES.path_s), target(9.0))
        self.assertLess(np.abs(target(SLIDES.path_s - 1e-4) - target(9.0)).max(), 1e-9)

    def test_description_for_others_has_all_shapes_and_the_obstacle(self) -> None:
        """One shape each, and no limits that older parsers do not know."""
        root = ET.fromstring(PANDA.urdf())
        self.assertEqual(len(root.findall("link/collision")), len(PANDA.shapes) + 1)
        self.assertEqual(len(root.findall("link/collision_checking/capsule")), len(PANDA.shapes) + 1)
        self.assertNotIn("acceleration", PANDA.urdf())

    def test_plant_is_the_limit_of_small_steps(self) -> None:
        """One period of lag equals many Euler steps, at each place."""
        plant = Plant(np.zeros(2), LAGGING)
        places = plant.move(np.array([1.0, -2.0]))
        position, velocity, steps = np.zeros(2), np.zeros(2), 20_000
        step_s = PERIOD_S / steps
        for number in range(1, steps + 1):
            velocity = velocity + step_s / LAGGING.lag_s * (np.array([1.0, -2.0]) - velocity)
            position = position + step_s * velocity
            if number * PLACES % steps == 0:
                np.testing.assert_allclose(places[number * PLACES // steps - 1], position, atol=1e-6)
        np.testing.assert_allclose(plant.velocity, velocity, atol=1e-4)

    def test_braking_ends_at_rest(self) -> None:
        """Braking never reverses a joint."""
        velocity = np.array([0.01, -1.0])
        for _ in range(60):
            velocity = brake(velocity, np.array([5.0, 5.0]))
        np.testing.assert_array_equal(velocity, 0)

    def test_an_arm_that_ignores_the_obstacle_goes_through_it(self) -> None:
        """Both balls are concentric but for 20 mm; the path has known accelerations."""
        record = run(lambda: Straight(SLIDES), SLIDES, STARTS[0], PERFECT)
        result = score(record, SLIDES)
        self.assertAlmostEqual(result.least_mm, -130, delta=0.1)
        self.assertTrue(result.is_too_near and result.reached and result.rests and result.has_left)
        self.assertEqual(result.refused, 0)
        self.assertAlmostEqual(result.acceleration_over_limit, 10 / 3**0.5 / SLIDES.path_s**2 / 5, delta=0.01)

    def test_an_arm_without_commands_brakes_within_its_limits(self) -> None:
        """It rests before its target, and each missing command counts."""
        record = run(lambda: Straight(SLIDES, last=100), SLIDES, STARTS[0], PERFECT)
        result = score(record, SLIDES)
        self.assertEqual(result.refused, 700)
        self.assertLessEqual(result.acceleration_over_limit, 1 + 1e-9)
        self.assertTrue(result.rests)
        self.assertFalse(result.reached)

    def test_files_of_runs_differ(self) -> None:
        """No run overwrites another one."""
        paths = {
            entries.path_of(Path("out"), name, scene, start, drive)
            for name in entries.ENTRIES
            for scene in SCENES
            for start in STARTS
            for drive in (PERFECT, LAGGING)
        }
        self.assertEqual(len(paths), 6 * 2 * len(entries.ENTRIES))


if __name__ == "__main__":
    unittest.main()
