"""Twists and poses that arrive at 30 Hz lead the arm."""

import json
import time

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, TwistStamped
from harness import until
from rclpy.qos import qos_profile_sensor_data

HOLD = {"name": "hold", "axes": ["rx", "ry", "rz"], "law": {"kind": "pose", "gain": 2}}
STILL = {"kind": "constant", "value": [0, 0, 0]}
TASKS = {
    "twist": {"name": "hand", "axes": ["x", "y", "z"], "law": {"kind": "velocity", "target_velocity": STILL}},
    # Another name, because a recorder keeps its publishers and a topic has one type.
    "pose": {"name": "point", "axes": ["x", "y", "z"], "law": {"kind": "pose", "gain": 2}},
}


@pytest.fixture
def follow(lab, arm, scenario):
    """Starts an arm in free space, whose task `hand` follows targets."""

    def start(kind):
        scenario["contacts"] = []
        scenario["controller"]["tasks"] = [TASKS[kind], HOLD]
        lab.node("simulator", scenario=lab.file("free.json", json.dumps(scenario)))
        text = json.dumps(scenario["controller"])
        lab.node("controller", controller=lab.file("follow.json", text), use_wrench="false")
        arm.wait_for("controls the arm")
        until(lambda: arm.states, "joint states")
        return arm.node.create_publisher(
            {"twist": TwistStamped, "pose": PoseStamped}[kind],
            f"targets/{TASKS[kind]['name']}",
            qos_profile_sensor_data,
        )

    return start


def send(arm, publisher, message, seconds, frame="base"):
    """Publishes a target at 30 Hz, stamped with the time of each message."""
    for _ in range(round(30 * seconds)):
        message.header.stamp = arm.node.get_clock().now().to_msg()
        message.header.frame_id = frame
        publisher.publish(message)
        time.sleep(1 / 30)


def test_a_streamed_twist_moves_the_tool_and_its_end_stops_it(arm, follow):
    publisher = follow("twist")
    before = arm.tool()
    twist = TwistStamped()
    twist.twist.linear.y = 0.05
    send(arm, publisher, twist, 2.0)
    moved = arm.tool() - before
    # Time is not exact on a loaded machine, but the direction is.
    assert moved[1] > 0.02
    assert np.abs(moved[[0, 2]]).max() < 0.1 * moved[1]
    arm.wait_for_an_arm_at_rest()
    arm.wait_for("controls the arm")


def test_a_streamed_pose_is_reached(arm, follow):
    publisher = follow("pose")
    goal = arm.tool() + [0.0, 0.03, -0.02]
    pose = PoseStamped()
    pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = goal
    deadline = time.monotonic() + 30
    while np.linalg.norm(arm.tool() - goal) > 1e-3:
        assert time.monotonic() < deadline, arm.tool() - goal
        send(arm, publisher, pose, 0.2)


@pytest.mark.parametrize("kind", ["frame", "NaN", "orientation", "clock"])
def test_a_wrong_target_is_not_used(arm, follow, kind):
    publisher = follow("pose")
    before = arm.tool()
    pose = PoseStamped()
    pose.pose.position.x = np.nan if kind == "NaN" else 0.5
    if kind == "orientation":
        pose.pose.orientation.x = 1.0
    if kind == "clock":
        pose.header.stamp.sec, pose.header.frame_id = 1000, "base"
        until(lambda: (publisher.publish(pose), arm.says("synchronise the clock", "targets"))[1], "a report")
    else:
        send(arm, publisher, pose, 0.5, "world" if kind == "frame" else "base")
    expected = {
        "frame": "its frame is `world`; transform it to `base`",
        "NaN": "not finite",
        "orientation": "not of unit length",
        "clock": "synchronise the clock",
    }[kind]
    arm.wait_for(expected, "targets", level=1)
    arm.wait_for("controls the arm", level=0)
    assert np.linalg.norm(arm.tool() - before) < 1e-3
