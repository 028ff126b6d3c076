"""Tests of the message conversion with simple objects as messages: python3 -m unittest discover -s api/ros2"""

import math
import unittest
from types import SimpleNamespace as Message

import conversion

JOINTS = ["shoulder", "elbow", "wrist"]


def stamp(seconds):
    sec = math.floor(seconds)
    return Message(sec=sec, nanosec=round(1e9 * (seconds - sec)))


def xyz(x, y, z):
    return Message(x=x, y=y, z=z)


def joint_state(seconds=100.0, **changed):
    """A message whose joints have another order than the robot's, with one joint that is not part of the robot."""
    fields = {"name": ["wrist", "finger", "shoulder", "elbow"], "position": [0.3, 9.0, 0.1, 0.2],
              "velocity": [3.0, 9.0, 1.0, 2.0], "effort": []}
    return Message(header=Message(stamp=stamp(seconds), frame_id=""), **fields | changed)


def wrench_stamped(seconds=100.0):
    wrench = Message(force=xyz(1.0, 2.0, 3.0), torque=xyz(4.0, 5.0, 6.0))
    return Message(header=Message(stamp=stamp(seconds), frame_id="tool0"), wrench=wrench)


def state(joints=None, wrench=None, **changed):
    options = {"sequence": 7, "start_s": 99.5, "now_s": 100.001, "max_age_s": 0.02} | changed
    return conversion.state(joints or joint_state(), wrench or wrench_stamped(), JOINTS, **options)


class States(unittest.TestCase):
    def test_joints_are_matched_by_name_and_other_joints_are_ignored(self):
        self.assertEqual(state()["joint_position"], {"shoulder": 0.1, "elbow": 0.2, "wrist": 0.3})
        self.assertEqual(state()["joint_velocity"], {"shoulder": 1.0, "elbow": 2.0, "wrist": 3.0})

    def test_time_counts_from_the_start(self):
        epoch = 1_700_000_000
        joints = joint_state()
        joints.header.stamp = Message(sec=epoch, nanosec=250_000_000)
        body = state(joints, wrench_stamped(epoch + 0.25), start_s=float(epoch), now_s=epoch + 0.25)
        self.assertAlmostEqual(body["time_s"], 0.25, places=6)
        self.assertEqual(body["sequence"], 7)

    def test_an_unmeasured_velocity_is_not_sent(self):
        for velocity in ([], [math.nan] * 4, [3.0, 9.0, math.nan, 2.0]):
            self.assertNotIn("joint_velocity", state(joint_state(velocity=velocity)))

    def test_a_missing_position_raises_not_fresh(self):
        for changed in ({"name": ["wrist", "finger", "shoulder", "knee"]}, {"position": [0.3, 9.0, math.inf, 0.2]}):
            with self.assertRaisesRegex(conversion.NotFresh, "shoulder, elbow, wrist"):
                state(joint_state(**changed))

    def test_messages_that_are_too_old_or_from_the_future_raise_not_fresh(self):
        self.assertIn("wrench", state(now_s=100.0199))
        for late in ({"now_s": 100.021}, {"joints": joint_state(99.9)}, {"wrench": wrench_stamped(99.9)}, {"now_s": 99.9}):
            with self.assertRaisesRegex(conversion.NotFresh, "0.02 s"):
                state(**late)
        with self.assertRaises(conversion.NotFresh):
            conversion.state(None, None, JOINTS, sequence=1, start_s=0, now_s=0, max_age_s=1)


class Wrenches(unittest.TestCase):
    def test_a_wrench_without_transform_is_unchanged(self):
        self.assertEqual(state()["wrench"], {"force": [1.0, 2.0, 3.0], "torque": [4.0, 5.0, 6.0]})

    def test_a_rotation_by_90_degrees_about_z_maps_x_to_y(self):
        half = math.sqrt(0.5)
        rotation = Message(rotation=Message(w=half, x=0.0, y=0.0, z=half), translation=xyz(0.0, 0.0, 0.0))
        moved = state(transform=rotation)["wrench"]
        for actual, expected in zip(moved["force"] + moved["torque"], [-2.0, 1.0, 3.0, -5.0, 4.0, 6.0]):
            self.assertAlmostEqual(actual, expected, places=12)

    def test_a_translation_adds_the_torque_of_the_force(self):
        translation = Message(rotation=Message(w=1.0, x=0.0, y=0.0, z=0.0), translation=xyz(0.0, 0.0, 0.1))
        moved = state(transform=translation)["wrench"]
        self.assertEqual(moved["force"], [1.0, 2.0, 3.0])
        for actual, expected in zip(moved["torque"], [4.0 - 0.2, 5.0 + 0.1, 6.0]):
            self.assertAlmostEqual(actual, expected, places=12)

    def test_a_rotation_and_its_inverse_cancel(self):
        w, x, y, z = 0.5, -0.5, 0.5, 0.5
        there = Message(w=w, x=x, y=y, z=z)
        back = Message(w=w, x=-x, y=-y, z=-z)
        rotated = conversion.rotated(there, [1.0, 2.0, 3.0])
        for actual, expected in zip(conversion.rotated(back, rotated), [1.0, 2.0, 3.0]):
            self.assertAlmostEqual(actual, expected, places=12)


class Commands(unittest.TestCase):
    def test_velocities_are_reordered_for_the_ros_controller(self):
        self.assertEqual(conversion.in_order([1.0, 2.0, 3.0], JOINTS, ["wrist", "shoulder", "elbow"]), [3.0, 1.0, 2.0])
        with self.assertRaises(ValueError):
            conversion.in_order([1.0, 2.0], JOINTS, JOINTS)

    def test_a_trajectory_point_lies_one_period_ahead(self):
        positions, velocities, time = conversion.trajectory_point([0.1, 0.2], [1.0, -2.0], 0.01)
        self.assertEqual((velocities, time), ([1.0, -2.0], (0, 10_000_000)))
        for actual, expected in zip(positions, [0.11, 0.18]):
            self.assertAlmostEqual(actual, expected, places=12)

    def test_a_twist_becomes_two_tasks_with_translation_first(self):
        twist = Message(linear=xyz(0.1, 0.2, 0.3), angular=xyz(0.4, 0.5, 0.6))
        body = conversion.twist_problem("panda", {"a": 0.0}, twist, 0.01)
        tasks = [(task["axes"], task["velocity"]) for task in body["tasks"]]
        self.assertEqual(tasks, [(["x", "y", "z"], [0.1, 0.2, 0.3]), (["rx", "ry", "rz"], [0.4, 0.5, 0.6])])


class Watchdogs(unittest.TestCase):
    def setUp(self):
        self.watchdog = conversion.Watchdog([10.0, 5.0], 0.01)

    def test_nothing_moves_before_the_first_answer(self):
        self.assertEqual(self.watchdog.command(0.0), [0.0, 0.0])

    def test_an_answer_is_held_for_its_validity_from_the_measurement(self):
        self.watchdog.update({"joint_velocity": [0.25, -0.12], "valid_for_ms": 100}, 1.0)
        self.assertEqual(self.watchdog.command(1.09), [0.25, -0.12])
        self.assertNotEqual(self.watchdog.command(1.1), [0.25, -0.12])

    def test_after_that_each_joint_brakes_at_its_own_limit_to_rest(self):
        self.watchdog.update({"joint_velocity": [0.25, -0.12], "valid_for_ms": 100}, 1.0)
        ramp = [self.watchdog.command(1.1 + 0.01 * i) for i in range(5)]
        for actual, expected in zip(ramp, [[0.15, -0.07], [0.05, -0.02], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]]):
            for a, b in zip(actual, expected):
                self.assertAlmostEqual(a, b, places=12)

    def test_a_joint_without_an_acceleration_limit_stops_at_once(self):
        watchdog = conversion.Watchdog([None, 5.0], 0.01)
        watchdog.update({"joint_velocity": [0.25, -0.12], "valid_for_ms": 100}, 1.0)
        velocity = watchdog.command(1.1)
        self.assertEqual(velocity[0], 0.0)
        self.assertAlmostEqual(velocity[1], -0.07, places=12)

    def test_the_deceleration_of_the_answer_has_precedence(self):
        answer = {"joint_velocity": [0.25, -0.12], "valid_for_ms": 20, "braking_deceleration": [4.0, None]}
        self.watchdog.update(answer, 1.0)
        self.assertEqual(self.watchdog.command(1.01), [0.25, -0.12])
        velocity = self.watchdog.command(1.02)
        self.assertAlmostEqual(velocity[0], 0.21, places=12)
        self.assertAlmostEqual(velocity[1], -0.07, places=12)

    def test_a_new_answer_ends_the_ramp(self):
        self.watchdog.update({"joint_velocity": [0.25, -0.12], "valid_for_ms": 100}, 1.0)
        self.watchdog.command(2.0)
        self.watchdog.update({"joint_velocity": [0.2, 0.1], "valid_for_ms": 100}, 2.0)
        self.assertEqual(self.watchdog.command(2.05), [0.2, 0.1])


if __name__ == "__main__":
    unittest.main()
