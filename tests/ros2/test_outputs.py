"""What the node keeps between its periods: trajectory points, chunks and poses of obstacles, without other nodes."""

from types import SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from revprio_ros.chunks import Chunks
from revprio_ros.obstacles import Obstacles
from revprio_ros.outputs import MAX_LEAD, Outputs
from revprio_ros.parameters import ParameterError
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

PERIOD_S = 0.002


class Messages:
    """A node that keeps what is published, and what receives."""

    def __init__(self):
        self.published, self.receivers = [], {}

    def create_publisher(self, _kind, _topic, _depth):
        return SimpleNamespace(publish=self.published.append)

    def create_subscription(self, _kind, topic, callback, _qos):
        self.receivers[topic] = callback
        return SimpleNamespace(topic_name=f"/{topic}")


class FakeClock:
    """Both clocks; that of the loop jitters, as two clocks that are read one after the other do."""

    def __init__(self):
        self.time_s, self.jitter_s = 100.0, 0.0

    def now_s(self):
        self.jitter_s += 1e-6
        return self.time_s + self.jitter_s

    def age_s(self, stamp):
        return self.time_s - stamp.sec - 1e-9 * stamp.nanosec


def test_points_follow_a_ramp_whose_measured_position_is_old():
    node = Messages()
    outputs = Outputs(node, SimpleNamespace(command_joints=None, output="trajectory"))
    speed, q = 1.5, 0.0
    for k in range(400):
        # The arm follows 40 ms behind; after 0.4 s no measurement arrives, and the node brakes.
        lead = min(k * PERIOD_S, 0.04) * 1.5
        fresh = ({"a": q - lead}, 0.001) if k < 200 else None
        speed = 1.5 if k < 200 else max(speed - 5.0 * PERIOD_S, 0.0)
        q += speed * PERIOD_S
        outputs.publish(["a"], [speed], fresh, PERIOD_S)
    positions = [message.points[0].positions[0] for message in node.published]
    accelerations = np.diff(positions, 2) / PERIOD_S**2
    assert np.abs(accelerations).max() < 5.0 + 1e-6
    outputs.rest()
    outputs.publish(["a"], [0.0], None, PERIOD_S)
    assert len(node.published) == 400, "no point without a place to begin"
    # An arm that is held back does not let the points run away.
    for _ in range(400):
        outputs.publish(["a"], [1.5], ({"a": 0.0}, 0.04), PERIOD_S)
    assert node.published[-1].points[0].positions[0] == pytest.approx(MAX_LEAD + 1.5 * (0.04 + PERIOD_S))


def posture(name):
    return SimpleNamespace(name=name, frame=None, law=SimpleNamespace(kind="posture", joints=["a"]))


def chunk_message():
    point = JointTrajectoryPoint(positions=[0.1])
    return JointTrajectory(joint_names=["a"], points=[point])


def test_a_chunk_is_sent_until_a_state_with_it_is_answered():
    node = Messages()
    settings = SimpleNamespace(config=SimpleNamespace(tasks=[posture("reach")]))
    chunks = Chunks(node, FakeClock(), settings)
    node.receivers["chunks/reach"](chunk_message())
    assert list(chunks.current(0.0, 5)) == ["reach"]
    assert list(chunks.current(0.0, 5)) == ["reach"], "the state was not answered"
    node.receivers["chunks/reach"](chunk_message())
    assert list(chunks.current(0.0, 6)) == ["reach"], "another one has arrived meanwhile"
    assert not chunks.current(0.0, 7)


def test_two_tasks_of_one_chunk_topic_are_refused():
    settings = SimpleNamespace(config=SimpleNamespace(tasks=[posture("a b"), posture("a_b")]))
    with pytest.raises(ParameterError, match="two tasks have the topic chunks/a_b"):
        Chunks(Messages(), FakeClock(), settings)


def test_a_repeated_pose_of_an_obstacle_is_no_rest():
    node, clock = Messages(), FakeClock()
    ball = SimpleNamespace(name="ball", moves=True)
    config = SimpleNamespace(collisions=SimpleNamespace(obstacles=[ball]))
    obstacles = Obstacles(node, clock, SimpleNamespace(config=config, base_frame="base", max_age_s=0.1))

    def pose(time_s, x):
        message = PoseStamped()
        message.header.frame_id = "base"
        message.header.stamp.sec, message.header.stamp.nanosec = int(time_s), round(1e9 * (time_s % 1))
        message.pose.position.x = x
        node.receivers["obstacles/ball"](message)

    def velocity():
        return obstacles.current()[0].velocity[0]

    pose(100.0, 0.0)
    clock.time_s = 100.0625
    pose(100.0625, 0.03125)
    assert velocity() == pytest.approx(0.5)
    for x in (0.03125, 0.0322):
        clock.time_s += 0.01
        pose(100.0625, x)
        pose(100.03125, 0.01)
        assert velocity() == pytest.approx(0.5), "repeated and late poses"
    clock.time_s = 50.0
    pose(50.0, 0.0)
    assert velocity() == 0.0, "after a jump of the clock"
