"""Tests of the message conversion with simple objects as messages, without ROS and without revprio:

PYTHONPATH=api/ros2 python3 -m unittest api/ros2/test/test_conversion.py
"""

import math
import unittest
from types import SimpleNamespace as Message

from revprio_ros import conversion

JOINTS = ["shoulder", "elbow", "wrist"]


def stamp(seconds):
    sec = math.floor(seconds)
    return Message(sec=sec, nanosec=round(1e9 * (seconds - sec)))


def xyz(x, y, z):
    return Message(x=x, y=y, z=z)


def joint_state(seconds=100.0, **changed):
    """A message whose joints have another order than the robot's, with one joint that is not part of the robot."""
    fields = {
        "name": ["wrist", "finger", "shoulder", "elbow"],
        "position": [0.3, 9.0, 0.1, 0.2],
        "velocity": [3.0, 9.0, 1.0, 2.0],
        "effort": [],
    }
    return Message(header=Message(stamp=stamp(seconds), frame_id=""), **fields | changed)


def wrench_stamped(seconds=100.0):
    wrench = Message(force=xyz(1.0, 2.0, 3.0), torque=xyz(4.0, 5.0, 6.0))
    return Message(header=Message(stamp=stamp(seconds), frame_id="tool0"), wrench=wrench)


def measurement(joints=None, wrench=None, transform=None):
    return conversion.measurement(joints or joint_state(), wrench or wrench_stamped(), JOINTS, transform)


class Measurements(unittest.TestCase):
    def test_joints_are_matched_by_name_and_other_joints_are_ignored(self):
        self.assertEqual(measurement()["joint_position"], {"shoulder": 0.1, "elbow": 0.2, "wrist": 0.3})
        self.assertEqual(measurement()["joint_velocity"], {"shoulder": 1.0, "elbow": 2.0, "wrist": 3.0})

    def test_a_controller_without_wrench_gets_none(self):
        self.assertNotIn("wrench", conversion.measurement(joint_state(), None, JOINTS))

    def test_an_unmeasured_velocity_is_not_sent(self):
        for velocity in ([], [math.nan] * 4, [3.0, 9.0, math.nan, 2.0]):
            self.assertNotIn("joint_velocity", measurement(joint_state(velocity=velocity)))

    def test_a_missing_joint_is_named(self):
        with self.assertRaisesRegex(conversion.NotUsable, "lacks elbow and has wrist, finger, shoulder, knee"):
            measurement(joint_state(name=["wrist", "finger", "shoulder", "knee"]))

    def test_values_that_are_not_finite_cannot_be_used(self):
        for position in ([0.3, 9.0, math.inf, 0.2], [0.3, 9.0, math.nan, 0.2], [0.3]):
            with self.assertRaisesRegex(conversion.NotUsable, "missing or not finite"):
                measurement(joint_state(position=position))
        wrench = wrench_stamped()
        wrench.wrench.force.y = math.nan
        with self.assertRaisesRegex(conversion.NotUsable, "`wrench`"):
            measurement(wrench=wrench)

    def test_a_stamp_is_converted_to_seconds(self):
        self.assertEqual(conversion.seconds(Message(sec=1_700_000_000, nanosec=250_000_000)), 1_700_000_000.25)


class Wrenches(unittest.TestCase):
    def test_a_wrench_without_transform_is_unchanged(self):
        self.assertEqual(measurement()["wrench"], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0])

    def test_a_rotation_by_90_degrees_about_z_maps_x_to_y(self):
        half = math.sqrt(0.5)
        rotation = Message(rotation=Message(w=half, x=0.0, y=0.0, z=half), translation=xyz(0.0, 0.0, 0.0))
        moved = measurement(transform=rotation)["wrench"]
        for actual, expected in zip(moved, [-2.0, 1.0, 3.0, -5.0, 4.0, 6.0]):
            self.assertAlmostEqual(actual, expected, places=12)

    def test_a_translation_adds_the_torque_of_the_force(self):
        translation = Message(rotation=Message(w=1.0, x=0.0, y=0.0, z=0.0), translation=xyz(0.0, 0.0, 0.1))
        moved = measurement(transform=translation)["wrench"]
        for actual, expected in zip(moved, [1.0, 2.0, 3.0, 4.0 - 0.2, 5.0 + 0.1, 6.0]):
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


class Targets(unittest.TestCase):
    def test_a_twist_becomes_one_velocity_per_row(self):
        twist = Message(linear=xyz(0.1, 0.2, 0.3), angular=xyz(0.4, 0.5, math.nan))
        self.assertEqual(conversion.twist_rows(twist, ["y", "rx"]), [0.2, 0.4])
        with self.assertRaisesRegex(conversion.NotUsable, "not finite"):
            conversion.twist_rows(twist, ["rz"])

    def test_a_pose_has_a_quaternion_of_unit_length(self):
        pose = Message(position=xyz(1.0, 2.0, 3.0), orientation=Message(w=1.0004, x=0.0, y=0.0, z=0.0))
        self.assertEqual(conversion.pose(pose), ([1.0, 2.0, 3.0], {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0}))
        for changed in (
            {"position": xyz(math.inf, 0.0, 0.0)},
            {"orientation": Message(w=0.0, x=0.0, y=0.0, z=0.0)},
            {"orientation": Message(w=math.nan, x=0.0, y=0.0, z=0.0)},
        ):
            with self.assertRaises(conversion.NotUsable):
                conversion.pose(Message(**vars(pose) | changed))


class Chunks(unittest.TestCase):
    def test_a_trajectory_becomes_actions_of_the_joints_of_the_task(self):
        points = [Message(positions=[0.3, 9.0, 0.1, 0.2], time_from_start=stamp(k / 30)) for k in range(2)]
        message = Message(joint_names=["wrist", "finger", "shoulder", "elbow"], points=points)
        first, second = conversion.trajectory_actions(message, JOINTS)
        self.assertEqual(first, (0.0, {"joint_position": {"shoulder": 0.1, "elbow": 0.2, "wrist": 0.3}}))
        self.assertAlmostEqual(second[0], 1 / 30)
        with self.assertRaisesRegex(conversion.NotUsable, "lacks knee"):
            conversion.trajectory_actions(message, ["knee"])
        points[1].positions = [math.nan] * 4
        with self.assertRaisesRegex(conversion.NotUsable, "finite"):
            conversion.trajectory_actions(message, JOINTS)

    def test_poses_become_actions_at_an_interval(self):
        entry = Message(position=xyz(1.0, 2.0, 3.0), orientation=Message(w=0.0, x=1.0, y=0.0, z=0.0))
        actions = conversion.pose_actions(Message(poses=[entry, entry]), 0.1)
        self.assertEqual([time for time, _ in actions], [0.0, 0.1])
        self.assertEqual(actions[1][1]["position"], [1.0, 2.0, 3.0])
        self.assertEqual(actions[1][1]["orientation"], {"w": 0.0, "x": 1.0, "y": 0.0, "z": 0.0})


if __name__ == "__main__":
    unittest.main()
