"""Tests of the arms, the walls and the score: `python -m unittest contact_mujoco.test_contact_mujoco`."""

from __future__ import annotations

import unittest

import numpy as np
import revprio

from contact_mujoco import door, friction, peg, pressing, scene, surfaces, turning
from contact_mujoco.arm import Arm, Drive
from contact_mujoco.conditions import Conditions, draw
from contact_mujoco.pressing import Trace, Wall
from contact_mujoco.robots import DOWN, PANDA, ROBOTS, SAWYER
from contact_mujoco.score import score
from contact_mujoco.tables import terms


def arm_above_wall(bandwidth: float = 150.0) -> tuple[Arm, Wall]:
    """Returns a Panda whose tool is a millimetre above a wall of 1e5 N/m."""
    model = scene.model(PANDA, scene.wall(np.zeros(3), -DOWN))
    arm = Arm(model, PANDA.start, Drive(bandwidth), 0.002, 1e-4)
    wall = Wall(arm, -DOWN)
    wall.touch(1e5, 1e-3)
    return arm, wall


def pressed(stiffness: float) -> tuple[float, float]:
    """Returns the force and the depth of a tool that a wall has pushed back, N and m."""
    arm, wall = arm_above_wall(400.0)
    wall.touch(stiffness, 0.0)
    wall.move(-5 / stiffness)
    for _ in range(200):
        arm.follow(np.zeros(7))
    return float(arm.wrench()[:3] @ DOWN), wall.depth


class Tests(unittest.TestCase):
    """What every run relies on."""

    def test_models_have_the_kinematics_of_revprio(self) -> None:
        """The sensor is at the tool point."""
        for robot in ROBOTS:
            model = scene.model(robot)
            arm = Arm(model, robot.start + 0.1, Drive(150.0), 0.002, 1e-4)
            pose = revprio.kinematics(robot=robot.name, joint_position=arm.position).pose
            np.testing.assert_allclose(arm.point, np.asarray(pose.position), atol=1e-9)

    def test_walls_have_their_stiffness(self) -> None:
        """A tool at rest feels K times its depth, in N."""
        for stiffness in (1e3, 1e5, 1e6):
            force, depth = pressed(stiffness)
            self.assertGreater(force, 1)
            self.assertAlmostEqual(force / depth / stiffness, 1, delta=1e-3)

    def test_a_changed_stiffness_keeps_the_force(self) -> None:
        """The wall moves with its stiffness."""
        arm, wall = arm_above_wall(400.0)
        wall.touch(1e5, -1e-4)
        arm.follow(np.zeros(7))
        force = 1e5 * wall.depth
        wall.change(10.0)
        self.assertAlmostEqual(1e6 * wall.depth, force, delta=1e-6 * force)

    def test_drives_follow_their_command(self) -> None:
        """After the delay and the lag, the tool has the commanded velocity, and the arm does not sink."""
        model = scene.model(SAWYER)
        command = np.full(7, 0.1)
        arm = Arm(model, SAWYER.start, Drive(150.0, 0.01, 2), 0.002, 1e-4)
        arm.follow(command)
        arm.follow(command)
        np.testing.assert_allclose(arm.position, SAWYER.start, atol=1e-6)
        for _ in range(150):
            arm.follow(command)
        np.testing.assert_allclose(arm.velocity, command, atol=1e-3)
        np.testing.assert_allclose(arm.position, SAWYER.start + (0.3 - 0.01) * command, atol=1e-4)

    def test_a_copy_of_an_arm_moves_alone(self) -> None:
        """What a copy does, the arm does not feel."""
        arm, _ = arm_above_wall()
        arm.copy().follow(np.full(7, 0.5))
        np.testing.assert_array_equal(arm.position, PANDA.start)
        np.testing.assert_array_equal(arm.follow(np.zeros(7)), np.zeros((20, 6)) + arm.wrench())

    def test_full_reversal_has_the_peak_of_its_closed_form(self) -> None:
        """F = K (v τ + v²/2a), up to a period and what the drive yields."""
        stiffness, speed, period_s = 3e4, 0.1, 0.001
        conditions = Conditions(PANDA, Drive(1000.0), period_s, stiffness, speed)
        detection_s = np.sqrt(2 * 0.002 * 3 * 0.2 / (stiffness * speed))
        stop_m = speed**2 / (2 * 4.19)  # joint 2 permits 4.19 m/s² along this motion
        least, most = (stiffness * (speed * (detection_s + moment * period_s) + stop_m) for moment in (0.5, 1.5))
        found = pressing.run(conditions).unavoidable
        self.assertGreater(found, 0.9 * least)
        self.assertLess(found, most)

    def test_the_law_presses(self) -> None:
        """One run reaches all goals."""
        for robot in ROBOTS:
            conditions = Conditions(robot, Drive(150.0, 0.005, 1))
            found = score(conditions, pressing.run(conditions))
            self.assertEqual(found.misses, [])
            self.assertAlmostEqual(found.stiffness, 1e5, delta=1e3)

    def test_scores_see_what_is_bad(self) -> None:
        """A force that swings, one that is wrong, one that is lost, and one that is high at the touch."""
        conditions = Conditions(PANDA, Drive(150.0), stiffness=1e5)
        time = np.arange(0, 2, 1e-3)

        def misses(force: np.ndarray) -> list[str]:
            return score(conditions, Trace(time_s=list(time), force=list(force))).misses

        right = np.where(time > 0.1, 30.0, 0.0)
        self.assertEqual(misses(right), [])
        self.assertEqual(misses(right + 5 * np.sin(10 * np.pi * time) * (time > 0.1)), ["not settled", "late"])
        self.assertEqual(misses(1.01 * right), ["error"])
        self.assertEqual(
            misses(np.where((time > 0.15) & (time < 0.2) | (time > 0.25) & (time < 0.3), 0, right)), ["losses"]
        )
        self.assertEqual(misses(np.where((time > 0.1) & (time < 0.11), 40, right)), ["peak"])
        self.assertEqual(misses(np.where(time > 1.7, 0.0, right)), ["not settled", "late", "error"])

    def test_a_loop_at_its_torque_limit_does_not_wind_up(self) -> None:
        """The reference stays near the arm that a wall holds."""
        arm, _ = arm_above_wall(400.0)
        down = PANDA.start * 0
        down[1], down[3] = 0.3, -0.3
        for _ in range(40):
            arm.follow(down)
        self.assertGreater(arm.wrench()[:3] @ DOWN, 100)
        self.assertLess(np.abs(arm.reference - arm.position).max(), 0.05)

    def test_walls_have_their_friction(self) -> None:
        """A tool that slides is held back by µ times the normal force."""
        rig = friction.Wiping(terms(PANDA, 1e4, target=20.0), 0.5)
        for _ in range(600):
            rig.arm.follow(np.asarray(rig.step().joint_velocity))
        wrench = rig.arm.wrench()
        self.assertAlmostEqual(-wrench[2], 20, delta=1)
        self.assertAlmostEqual(np.hypot(*wrench[:2]) / -wrench[2], 0.5, delta=1e-3)

    def test_torques_settle(self) -> None:
        """A ball at a lever presses with 3 N·m."""
        conditions = terms(PANDA, 1e5)
        found = score(conditions, pressing.press(turning.Turning(conditions)))
        self.assertTrue(found.settled)

    def test_the_way_of_a_handle_shows_its_radius(self) -> None:
        """The circle through points of an arc has the right radius."""
        angle = np.linspace(0, 1, 50)
        points = np.column_stack([0.4 * np.sin(angle) + 3, 0.4 * np.cos(angle) - 2, 0 * angle])
        run = door.Opening(angle, angle, angle, points, arm_above_wall()[0])
        self.assertAlmostEqual(run.radius_m, 0.4, delta=1e-9)

    def test_spirals_have_their_pitch_and_their_length(self) -> None:
        """Turns are a pitch apart, and way along the spiral is what was asked for."""
        places = np.array([peg.spiral(way, 0.001) for way in np.linspace(0, 0.1, 20_001)])
        length = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
        self.assertAlmostEqual(length, 0.1, delta=0.002)
        crossings = places[:-1][(places[:-1, 1] < 0) & (places[1:, 1] >= 0) & (places[1:, 0] > 0), 0]
        np.testing.assert_allclose(np.diff(crossings), 0.001, atol=2e-5)

    def test_the_normal_of_a_cylinder_follows_the_tool(self) -> None:
        """Above its axis it points up."""
        rig = surfaces.Wiping(terms(PANDA, 1e4), surfaces.Surface(0.0, None))
        np.testing.assert_allclose(rig.normal(rig.arm), -DOWN, atol=1e-6)

    def test_conditions_are_the_same_in_each_run(self) -> None:
        """All stiffnesses occur equally often."""
        drawn = draw(PANDA, 150.0, 14)
        self.assertEqual(drawn, draw(PANDA, 150.0, 14))
        self.assertEqual({sum(c.stiffness == d.stiffness for d in drawn) for c in drawn}, {2})


if __name__ == "__main__":
    unittest.main()
