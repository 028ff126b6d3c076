"""Poses of a moving obstacle: without them the arm does not move, and it brakes when they stop."""

import json
import time

import pytest
from geometry_msgs.msg import PoseStamped
from harness import until
from rclpy.qos import qos_profile_sensor_data

TASK = {
    "name": "hand",
    "axes": ["x", "y", "z"],
    "law": {
        "kind": "velocity",
        "target_velocity": {"kind": "sine", "offset": 0, "amplitude": [0, 0.02, 0], "angular_frequency_rad_s": 1},
    },
}
BALL = {"name": "ball", "sphere": {"radius": 0.05}, "moves": True}


@pytest.fixture
def room(lab, arm, scenario):
    """Starts an arm in a room with a ball that moves; returns the publisher of its poses."""
    scenario["contacts"] = []
    scenario["controller"] |= {"tasks": [TASK], "collisions": {"own_links": False, "obstacles": [BALL]}}
    lab.node("simulator", scenario=lab.file("room.json", json.dumps(scenario)))
    text = json.dumps(scenario["controller"])
    lab.node("controller", controller=lab.file("room_controller.json", text), use_wrench="false")
    until(lambda: arm.states, "joint states")
    return arm.node.create_publisher(PoseStamped, "obstacles/ball", qos_profile_sensor_data)


def send(arm, publisher, seconds, frame="base"):
    """Publishes poses of a ball far away at 50 Hz."""
    pose = PoseStamped()
    pose.pose.position.x = -1.5
    for _ in range(round(50 * seconds)):
        pose.header.stamp = arm.node.get_clock().now().to_msg()
        pose.header.frame_id = frame
        publisher.publish(pose)
        time.sleep(1 / 50)


def test_an_arm_moves_while_it_knows_where_the_obstacle_is(arm, room):
    arm.wait_for("no message on `/obstacles/ball` yet")
    until(lambda: (send(arm, room, 0.5), arm.says("controls the arm"))[1], "control")
    # Poses stop: the arm brakes, and says why.
    arm.wait_for("`/obstacles/ball` is stale")
    arm.wait_for_an_arm_at_rest()
    until(lambda: (send(arm, room, 0.5), arm.says("controls the arm"))[1], "control again")


def test_poses_in_another_frame_are_not_used(arm, room):
    until(lambda: (send(arm, room, 0.5, "world"), arm.says("its frame is `world`"))[1], "a refusal")
