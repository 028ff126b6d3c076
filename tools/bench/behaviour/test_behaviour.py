"""Tests of the plant and of the score: `python -m unittest behaviour.test_behaviour`."""

from __future__ import annotations

import unittest

import numpy as np

from behaviour import arm as model
from behaviour import report, score
from behaviour.families import PERIOD_S, families
from behaviour.plant import IDEAL, REAL, Condition, Plant, brake
from behaviour.rotations import from_quaternion, from_rotation_vector, rotation_angle, rotation_vector, to_quaternion
from behaviour.simulate import Record, newest


class Tests(unittest.TestCase):
    """The parts that all entries share."""

    def test_tool_of_the_home_posture_is_that_of_the_manufacturer(self) -> None:
        """The Panda's flange is 0.307 m in front of its base and 0.59 m above it, and points down."""
        tool = model.load().tool(model.HOME)
        np.testing.assert_allclose(tool[:3, 3], [0.3069, 0, 0.5903], atol=1e-4)
        np.testing.assert_allclose(tool[:3, 2], [0, 0, -1], atol=1e-12)

    def test_rotations_agree(self) -> None:
        """Vector, matrix and quaternion describe the same rotation, also near a half turn."""
        random = np.random.default_rng(0)
        for angle in (1e-9, 1e-3, 1.0, 3.1, np.pi - 1e-7):
            axis = random.normal(size=3)
            vector = angle * axis / np.linalg.norm(axis)
            rotation = from_rotation_vector(vector)
            self.assertAlmostEqual(rotation_angle(rotation), angle, delta=1e-7)
            np.testing.assert_allclose(rotation_vector(rotation), vector, atol=1e-6)
            np.testing.assert_allclose(from_quaternion(*to_quaternion(rotation)), rotation, atol=1e-12)

    def test_plant_is_the_limit_of_small_steps(self) -> None:
        """One period of lag equals many Euler steps, and a command arrives one period late."""
        start, command = np.zeros(7), np.linspace(-1, 1, 7)
        plant = Plant(start, Condition("lag and delay", lag_s=0.02, delay_periods=1))
        plant.move(command)
        np.testing.assert_array_equal(plant.position, start)
        plant.move(np.zeros(7))
        position, velocity, step_s = np.zeros(7), np.zeros(7), PERIOD_S / 20_000
        for _ in range(20_000):
            velocity = velocity + step_s / 0.02 * (command - velocity)
            position = position + step_s * velocity
        np.testing.assert_allclose(plant.position, position, atol=1e-6)
        np.testing.assert_allclose(plant.velocity, velocity, atol=1e-4)

    def test_noise_is_the_same_in_each_run(self) -> None:
        """All controllers see the same noise."""
        first, second = (Plant(model.HOME, REAL).measure() for _ in range(2))
        np.testing.assert_array_equal(first, second)
        self.assertGreater(np.abs(first - model.HOME).max(), 1e-5)

    def test_braking_ends_at_rest(self) -> None:
        """Braking never reverses a joint."""
        command = np.array([0.05, -0.05, 1.0, 0, 0, 0, -2.0])
        for _ in range(60):
            command = brake(command)
        np.testing.assert_array_equal(command, 0)

    def test_targets_arrive_once_and_in_order(self) -> None:
        """A target that is overtaken by a newer one is never delivered."""
        family = next(family for family in families(quick=False) if family.name == "jumping")
        arrivals = newest(family.targets())
        delivered = [next(arrivals) for _ in range(round(family.duration_s / PERIOD_S))]
        times_s = [target.measured_s for target in delivered if target is not None]
        self.assertEqual(times_s, sorted(set(times_s)))
        self.assertGreater(len(times_s), 0.7 * 45 * (family.duration_s - 1.2))

    def test_an_arm_that_ignores_a_jump_freezes_and_never_recovers(self) -> None:
        """It rests while the target rests, so its tracking error is zero; then it misses the jump at 1 s."""
        family = families(quick=True)[4]
        rest = np.tile(model.HOME, (200, 1))
        result = score.score(Record(rest, np.zeros_like(rest), np.zeros(200)), family)
        self.assertLess(result.tracking_mm, 1e-9)
        self.assertEqual((result.violations, result.freezes, result.failures), (0, 1, 0))
        self.assertEqual(result.recoveries_missed, 1)

    def test_faults_are_counted(self) -> None:
        """A joint outside its range, a command above its limit, a standstill and a failure are seen."""
        family = families(quick=False)[0]
        position = np.tile(model.HOME, (1200, 1))
        position[100:103, 3] = 0.0
        command = np.zeros_like(position)
        command[200, 0] = 2.2
        failed = np.zeros(1200)
        failed[7] = 1
        result = score.score(Record(position, command, failed), family)
        self.assertEqual(result.violations, 4)
        self.assertAlmostEqual(result.outside_mrad, 69.8)
        self.assertEqual(result.failures, 1)
        self.assertGreaterEqual(result.freezes, 1)
        self.assertAlmostEqual(result.acceleration_over_limit, 220 / 15)

    def test_the_tolerance_of_a_solver_is_no_fault(self) -> None:
        """A command above its limit by less than a ten-thousandth does not count, above that it does."""
        family = families(quick=True)[0]
        position = np.tile(model.HOME, (200, 1))
        command = np.zeros_like(position)
        command[10, 3], command[20, 3] = model.load().velocity[3] * np.array([1 + 5e-5, 1 + 2e-4])
        self.assertEqual(score.score(Record(position, command, np.zeros(200)), family).violations, 1)

    def test_runs_with_faults_are_counted(self) -> None:
        """A run with a failure is faulty, one at rest on its target is not."""
        family = families(quick=True)[0]
        rest = np.tile(model.HOME, (10, 1))
        clean, failed = np.zeros(10), np.ones(10)
        results = [score.score(Record(rest, np.zeros_like(rest), flags), family) for flags in (clean, failed)]
        self.assertEqual([report.is_faulty(result) for result in results], [False, True])

    def test_recovery_must_last(self) -> None:
        """A short moment of small error is no recovery."""
        error = np.full(500, 0.1)
        error[110:115] = 0
        error[200:] = 0
        self.assertAlmostEqual(score.recovery(error, 1.0, 5.0) or 0.0, 1.0)
        self.assertIsNone(score.recovery(error, 1.0, 2.1))

    def test_power_is_that_of_a_sine(self) -> None:
        """A sine of amplitude a has the power a²/2, and only above the cut-off."""
        times_s = PERIOD_S * np.arange(1000)
        for frequency_hz, expected in ((2.0, 0.0), (10.0, 0.125)):
            command = 0.5 * np.sin(2 * np.pi * frequency_hz * times_s)[:, None]
            self.assertAlmostEqual(score.power_above(command), expected, delta=1e-9)

    def test_ideal_is_the_plain_integral(self) -> None:
        """Without lag and delay the arm moves by T times the command."""
        plant = Plant(model.HOME, IDEAL)
        plant.move(np.ones(7))
        np.testing.assert_allclose(plant.position, model.HOME + PERIOD_S)


if __name__ == "__main__":
    unittest.main()
