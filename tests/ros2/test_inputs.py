"""Stamps become times of the loop's clock once."""

from itertools import count
from types import SimpleNamespace

import pytest
from revprio_ros.conversion import NotUsable
from revprio_ros.inputs import Inputs
from sensor_msgs.msg import JointState


class UnevenClock:
    """A clock whose two times are not read at the same moment."""

    def __init__(self):
        self.time_s, self.reads = 50.0, count()

    def now_s(self):
        return self.time_s

    def age_s(self, stamp):
        return self.time_s - (stamp.sec + 1e-9 * stamp.nanosec) + 1e-6 * next(self.reads)


@pytest.fixture
def inputs():
    receivers = {}

    def subscribe(_kind, topic, callback, _qos):
        receivers[topic] = callback
        return SimpleNamespace(topic_name=f"/arm/{topic}")

    clock = UnevenClock()
    settings = SimpleNamespace(use_wrench=False, max_age_s=0.05, sensor_transform=None)
    return Inputs(SimpleNamespace(create_subscription=subscribe), clock, settings), clock, receivers


def message(sec):
    joint_state = JointState(name=["a"], position=[0.5])
    joint_state.header.stamp.sec = sec
    return joint_state


def test_a_repeated_measurement_keeps_its_time(inputs):
    inputs, clock, receivers = inputs
    receivers["joint_states"](message(50))
    times = []
    for _ in range(4):
        clock.time_s += 0.01
        times.append(inputs.measurement(["a"])[1])
    assert len(set(times)) == 1


@pytest.mark.parametrize(
    ("sec", "reason"), [(40, "is stale: its newest stamp is 10.0"), (60, "10.000 s in the future")]
)
def test_a_stamp_far_from_the_clock_is_not_used(inputs, sec, reason):
    inputs, _, receivers = inputs
    with pytest.raises(NotUsable, match="no message on `/arm/joint_states`"):
        inputs.check_fresh()
    receivers["joint_states"](message(sec))
    with pytest.raises(NotUsable, match=reason):
        inputs.check_fresh()
