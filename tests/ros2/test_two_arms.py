"""A robot with two tips: frames of targets, and the wrench that the node does not have."""

import json
from types import SimpleNamespace

import pytest
import revprio
from geometry_msgs.msg import PoseArray, PoseStamped, TwistStamped, WrenchStamped
from harness import REPOSITORY, free_port, until
from rclpy.qos import qos_profile_sensor_data
from revprio import ControllerConfig
from revprio_ros.chunks import Chunks
from revprio_ros.targets import Targets
from sensor_msgs.msg import JointState

ROBOT = json.loads((REPOSITORY / "api/examples/robot_two_arms.json").read_text())
STILL = {"kind": "constant", "value": [0, 0]}
MOVE = {"kind": "velocity", "target_velocity": STILL}
HOLD = {"kind": "pose", "gain": 2}
PRESS = {"kind": "impedance", "stiffness": [500], "damping": [50], "inertia": [1]}


def controller(**fields):
    task = {"name": "hand", "axes": ["x", "y"], **fields}
    return {"robot": ROBOT["name"], "period_s": 0.01, "tasks": [task]}


def refusal(kind, fields, message, frame):
    """Returns why a message with this frame is not used, empty if it is used."""
    receivers = []
    node = SimpleNamespace(create_subscription=lambda _kind, _name, receive, _qos: receivers.append(receive))
    clock = SimpleNamespace(now_s=lambda: 0.0, age_s=lambda _stamp: 0.0)
    config = ControllerConfig.model_validate(controller(**fields))
    settings = SimpleNamespace(
        config=config, base_frame="base", tool_frame="tool0", max_age_s=0.1, chunk_interval_s=0.1
    )
    receiver = kind(node, clock, settings)
    message.header.frame_id = frame
    receivers[0](message)
    return receiver.refusals.get("hand", "")


@pytest.mark.parametrize(
    ("kind", "message"), [(Targets, PoseStamped()), (Chunks, PoseArray(poses=[PoseStamped().pose]))]
)
@pytest.mark.parametrize(
    ("fields", "frame"),
    [({}, "base"), ({"link": "right", "relative_to": "left"}, "left"), ({"link": "right", "frame": "tool"}, "base")],
)
def test_the_frame_of_a_pose_is_that_from_which_the_task_is_seen(kind, message, fields, frame):
    assert refusal(kind, {"law": HOLD, **fields}, message, frame) == ""
    assert f"its frame is `left_hand`; transform it to `{frame}`" in refusal(
        kind, {"law": HOLD, **fields}, message, "left_hand"
    )


@pytest.mark.parametrize(
    ("fields", "frame"),
    [
        ({}, "base"),
        ({"relative_to": "left"}, "left"),
        ({"frame": "tool"}, "tool0"),
        ({"frame": "tool", "link": "right"}, "right"),
        ({"frame": "tool", "link": "right", "relative_to": "left"}, "right"),
    ],
)
def test_the_frame_of_a_twist_is_that_of_its_axes(fields, frame):
    assert refusal(Targets, {"law": MOVE, **fields}, TwistStamped(), frame) == ""
    assert f"transform it to `{frame}`" in refusal(Targets, {"law": MOVE, **fields}, TwistStamped(), "world")


@pytest.fixture
def two_arms(lab):
    """Starts a service that knows the robot; returns its address."""
    _, url = lab.service(free_port())
    with revprio.Client(url) as client:
        client.register_robot(**ROBOT)
    return url


def measure(arm):
    """Returns a function that publishes joint states and a wrench."""
    states = arm.node.create_publisher(JointState, "joint_states", qos_profile_sensor_data)
    wrenches = arm.node.create_publisher(WrenchStamped, "wrench", qos_profile_sensor_data)
    sides = [f"{side}_{joint}" for side in ("left", "right") for joint in ("shoulder", "elbow", "wrist")]
    state = JointState(name=["waist", *sides], position=[0.0, 0.6, -0.9, 0.3, -0.6, 0.9, -0.3])

    def publish():
        wrench = WrenchStamped()
        state.header.stamp = wrench.header.stamp = arm.node.get_clock().now().to_msg()
        states.publish(state)
        wrenches.publish(wrench)

    return publish


@pytest.mark.parametrize(
    ("fields", "needed"),
    [
        ({"tasks": [{"name": "press", "link": "right", "axes": ["x"], "law": PRESS}]}, "the law of task `press`"),
        ({"wrench_sensors": {"right": {"bias": {"force": [0, 0, 0], "torque": [0, 0, 0]}}}}, "`wrench_sensors`"),
    ],
)
def test_a_law_that_needs_the_wrench_of_another_tip_ends_the_node(lab, arm, two_arms, fields, needed):
    publish = measure(arm)
    text = json.dumps(controller(law=HOLD) | fields)
    process = lab.node("controller", controller=lab.file("two.json", text), url=two_arms)
    until(lambda: (publish(), process.output())[1].count("revprio_ros: "), "the node ends")
    assert process.wait() == 1
    assert f"parameter `controller`: {needed} needs the wrench of `right`" in process.output()
    assert "Traceback" not in process.output()


@pytest.mark.parametrize("link", ["left", "right"])
def test_laws_of_the_first_tip_and_laws_without_a_wrench_run(lab, arm, two_arms, link):
    publish = measure(arm)
    task = {"axes": ["x"], "law": PRESS} if link == "left" else {"law": HOLD}
    text = json.dumps(controller(link=link, **task))
    lab.node("controller", controller=lab.file("two.json", text), url=two_arms)
    until(lambda: (publish(), arm.says("controls the arm"))[1], "control")
