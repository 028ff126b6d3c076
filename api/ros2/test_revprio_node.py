"""Tests of the node without ROS, with a running service: REVPRIO=target/debug/revprio python3 -m unittest …"""

import json
import os
import subprocess
import sys
import unittest
from pathlib import Path
from types import ModuleType
from types import SimpleNamespace as Message

REPOSITORY = Path(__file__).resolve().parents[2]


class FakeNode:
    """Implements the part of rclpy's Node that the example uses. Tests set its clock."""

    def __init__(self, name):
        self.callbacks, self.time_ns, self.errors, self.published = {}, 0, [], []

    def create_subscription(self, kind, topic, callback, qos):
        self.callbacks[topic] = callback

    def create_publisher(self, kind, topic, depth):
        return Message(publish=lambda message: self.published.append(list(message.data)))

    def create_timer(self, period_s, callback):
        self.period_s, self.tick = period_s, callback

    def get_clock(self):
        return Message(now=lambda: Message(nanoseconds=self.time_ns))

    def get_logger(self):
        return Message(error=lambda text, throttle_duration_sec: self.errors.append(text))


def add_fake_module(name, **contents):
    module = ModuleType(name)
    module.__dict__.update(contents)
    sys.modules[name] = module


for name, contents in {
    "rclpy": {}, "rclpy.node": {"Node": FakeNode}, "rclpy.qos": {"qos_profile_sensor_data": None},
    "geometry_msgs": {}, "geometry_msgs.msg": {"WrenchStamped": None},
    "sensor_msgs": {}, "sensor_msgs.msg": {"JointState": None},
    "std_msgs": {}, "std_msgs.msg": {"Float64MultiArray": Message},
}.items():
    add_fake_module(name, **contents)

from revprio_node import Revprio  # noqa: E402 (it imports ROS)


@unittest.skipUnless("REVPRIO" in os.environ, "the variable REVPRIO is not set")
class Nodes(unittest.TestCase):
    def setUp(self):
        command = [os.environ["REVPRIO"], "serve", "--listen", "127.0.0.1:0"]
        self.server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.address = self.server.stdout.readline().strip().removeprefix("listening on http://")
        controller = json.loads((REPOSITORY / "api/examples/controller.json").read_text())
        self.node = Revprio(controller | {"period_s": 0.01}, self.address)
        # The clock of the test stands still during a call, so a call may take long.
        self.node.service.connection.close()
        self.node.service.connection.timeout = 5.0
        self.position = dict(zip(self.node.joints, [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2]))

    def tearDown(self):
        self.node.service.connection.close()
        self.server.kill()
        self.server.wait()
        self.server.stdout.close()

    def send_messages(self, force_x=0.0):
        header = Message(stamp=Message(sec=self.node.time_ns // 10**9, nanosec=self.node.time_ns % 10**9))
        names = list(reversed(self.position))
        values = [self.position[name] for name in names]
        self.node.callbacks["joint_states"](Message(header=header, name=names, position=values, velocity=[]))
        zero = Message(x=0.0, y=0.0, z=0.0)
        wrench = Message(force=Message(x=force_x, y=0.0, z=0.0), torque=zero)
        self.node.callbacks["wrench"](Message(header=header, wrench=wrench))

    def tick(self):
        """Runs one control period and moves an ideal arm by its command."""
        self.node.tick()
        for name, speed in zip(self.node.joints, self.node.published[-1]):
            self.position[name] += self.node.period_s * speed
        self.node.time_ns += round(1e9 * self.node.period_s)

    def test_the_arm_approaches_without_contact_and_retreats_when_the_force_is_too_large(self):
        for _ in range(50):
            self.send_messages()
            self.tick()
        self.assertEqual(self.node.errors, [])
        free = self.node.published[-1]
        self.assertGreater(max(map(abs, free)), 0.05)
        for _ in range(50):
            self.send_messages(force_x=60.0)
            self.tick()
        retreating = self.node.published[-1]
        self.assertLess(sum(a * b for a, b in zip(free, retreating)), 0.0)

    def test_without_messages_or_service_the_arm_comes_to_rest(self):
        self.node.tick()
        self.assertEqual(self.node.published, [[0.0] * 7])
        for _ in range(50):
            self.send_messages()
            self.tick()
        moving = self.node.published[-1]
        self.server.kill()
        self.server.wait()
        for _ in range(30):
            self.send_messages()
            self.tick()
        # An answer is valid for 100 ms. The arm keeps the tenth command until 110 ms, so this one brakes.
        self.assertEqual(self.node.published[-22], moving)
        self.assertLess(abs(self.node.published[-21][3]), abs(moving[3]))
        self.assertEqual(self.node.published[-1], [0.0] * 7)
        self.assertEqual(len(self.node.errors), 31)

    def test_a_refusal_contains_status_and_field(self):
        with self.assertRaisesRegex(ValueError, r"422, /robot"):
            self.node.service.call("POST", "/v1/controllers", {"robot": "none", "period_s": 0.01, "tasks": []})


if __name__ == "__main__":
    unittest.main()
