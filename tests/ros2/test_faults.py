"""What happens when something fails: the arm brakes, the diagnostics say why, and control goes on."""

import json
import signal
import time

import numpy as np
import pytest
import revprio
from harness import free_port, until
from rosgraph_msgs.msg import Clock


@pytest.fixture
def free_arm(lab, arm, scenario):
    """Starts an arm that moves slowly through free space for minutes."""
    scenario["contacts"] = []
    scenario["controller"]["tasks"][0]["law"]["damping"] = 2000
    path = lab.file("push.json", json.dumps(scenario["controller"]))
    lab.node("simulator", scenario=lab.file("free.json", json.dumps(scenario)))

    def start(**parameters):
        node = lab.node("controller", controller=path, **parameters)
        arm.wait_for_motion()
        return node

    return start


def check_braking(arm, since):
    """Checks that the commands from an index on go to rest at no more than the deceleration of the joints."""
    times = np.array([at_s for at_s, _ in arm.commands[since:]])
    commands = np.array([command for _, command in arm.commands[since:]])
    at_rest = int(np.argmax(~commands.any(axis=1)))
    assert not commands[at_rest].any()
    limits = np.array([joint.acceleration_limit for joint in revprio.robot("sawyer").joints])
    # The node's periods are not exact; the time of arrival is less exact.
    allowed = limits * (np.diff(times[: at_rest + 1])[:, None] + 0.02)
    steps = np.abs(np.diff(commands[: at_rest + 1], axis=0))
    assert (steps <= allowed).all(), (steps / allowed).max()


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_service_that_dies_or_hangs_and_comes_back(lab, arm, free_arm, number):
    port = free_port()
    service, url = lab.service(port)
    free_arm(url=url)
    since = len(arm.commands)
    service.signal(number)
    arm.wait_for_rest()
    check_braking(arm, since)
    arm.wait_for("no answer from", level=2)
    if number == signal.SIGKILL:
        lab.service(port)
    else:
        service.signal(signal.SIGCONT)
    arm.wait_for_motion()
    assert int(arm.wait_for("controls the arm").values["sessions"]) >= 2


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_node_ends_at_rest_while_its_service_hangs(lab, arm, free_arm, number):
    service, url = lab.service(free_port())
    node = free_arm(url=url)
    service.signal(signal.SIGSTOP)
    node.signal(number)
    assert node.wait() == 0
    arm.wait_for_an_arm_at_rest()
    assert not arm.commands[-1][1].any()


def test_a_refused_state_is_reported(lab, arm, scenario):
    scenario["contacts"] = []
    lab.node("simulator", scenario=lab.file("free.json", json.dumps(scenario)))
    text = json.dumps(scenario["controller"])
    lab.node("controller", controller=f"'{text}'", use_wrench="false")
    arm.wait_for("wrench", level=2)
    assert not any(command.any() for _, command in arm.commands)


def test_the_node_waits_for_a_service(lab, arm, scenario):
    scenario["contacts"] = []
    lab.node("simulator", scenario=lab.file("free.json", json.dumps(scenario)))
    port = free_port()
    path = lab.file("push.json", json.dumps(scenario["controller"]))
    lab.node("controller", controller=path, url=f"127.0.0.1:{port}")
    arm.wait_for("no answer from", level=1)
    assert not arm.commands
    lab.service(port)
    arm.wait_for_motion()


@pytest.mark.parametrize(
    ("fault", "reason"),
    [
        ("stale joint_states", "`/joint_states` is stale"),
        ("stale wrench", "`/wrench` is stale"),
        ("no joint_states", "`/joint_states` is stale"),
        ("NaN in joint_states", "not finite"),
    ],
)
def test_unusable_messages(arm, free_arm, fault, reason):
    free_arm()
    since = len(arm.commands)
    arm.set_fault(fault)
    arm.wait_for_rest()
    check_braking(arm, since)
    arm.wait_for(reason, level=2)
    arm.set_fault("none")
    arm.wait_for_motion()
    assert int(arm.wait_for("controls the arm").values["sessions"]) >= 2


def test_other_joint_names(lab, arm, scenario):
    lab.node("simulator", scenario=lab.file("wall.json", json.dumps(scenario)), joint_prefix="left_")
    lab.node("controller", controller=lab.file("push.json", json.dumps(scenario["controller"])))
    status = arm.wait_for("`joint_states` lacks right_j0")
    assert "has left_right_j0" in status.message
    assert not any(command.any() for _, command in arm.commands)


def test_a_node_that_is_stopped_for_a_while(arm, free_arm):
    node = free_arm()
    until(lambda: arm.states and np.abs(arm.velocity()).max() > 1e-3, "a moving arm")
    node.signal(signal.SIGSTOP)
    arm.wait_for_an_arm_at_rest()
    node.signal(signal.SIGCONT)
    until(lambda: arm.sessions() >= 2, "a new session")
    arm.wait_for_motion()


@pytest.mark.parametrize("place", ["in this process", "at a service"])
def test_the_wrong_sign_of_the_wrench(lab, arm, scenario, place):
    lab.node("simulator", scenario=lab.file("wall.json", json.dumps(scenario)))
    url = lab.service(free_port())[1] if place == "at a service" else ""
    path = lab.file("push.json", json.dumps(scenario["controller"]))
    lab.node("controller", controller=path, wrench_convention="on_environment", url=url)
    status = arm.wait_for("the wrench has probably the wrong sign")
    assert status.level == 2
    arm.wait_for_rest()
    arm.wait_for_an_arm_at_rest()
    force = np.linalg.norm(arm.force)
    time.sleep(1.0)
    assert abs(np.linalg.norm(arm.force) - force) < 0.5, "the arm no longer pushes"
    assert arm.says("halted at rest: the wrench")


def test_a_clock_that_jumps_back_and_stands_still(lab, arm, scenario):
    scenario["contacts"] = []
    lab.node("simulator", scenario=lab.file("free.json", json.dumps(scenario)), use_sim_time="true")
    path = lab.file("push.json", json.dumps(scenario["controller"]))
    node = lab.node("controller", controller=path, use_sim_time="true")
    clock = arm.node.create_publisher(Clock, "/clock", 10)
    offset_s = [1000.0 - time.monotonic()]

    def publish():
        now_s = time.monotonic() + offset_s[0]
        message = Clock()
        message.clock.sec, message.clock.nanosec = int(now_s), int(1e9 * (now_s % 1))
        clock.publish(message)

    timer = arm.node.create_timer(0.005, publish)
    arm.wait_for_motion()
    until(lambda: arm.says("controls the arm"), "the node controls the arm")
    offset_s[0] -= 500.0
    until(lambda: arm.sessions() >= 2, "a new session after the jump")
    arm.wait_for_motion()
    timer.cancel()
    assert node.stop()[0] == 0
    until(lambda: not arm.commands[-1][1].any(), "zero: a clock that stands still has no time for a ramp")


def test_with_simulated_time_the_node_ends_with_a_ramp(lab, arm, scenario):
    scenario["contacts"] = []
    lab.node("simulator", scenario=lab.file("free.json", json.dumps(scenario)), use_sim_time="true")
    path = lab.file("push.json", json.dumps(scenario["controller"]))
    node = lab.node("controller", controller=path, use_sim_time="true")
    clock = arm.node.create_publisher(Clock, "/clock", 10)

    def publish():
        now_s = time.monotonic()
        message = Clock()
        message.clock.sec, message.clock.nanosec = int(now_s), int(1e9 * (now_s % 1))
        clock.publish(message)

    arm.node.create_timer(0.005, publish)
    arm.wait_for_motion()
    until(lambda: arm.says("controls the arm"), "the node controls the arm")
    time.sleep(1.0)
    count, speed = len(arm.commands), float(np.abs(arm.commands[-1][1]).max())
    assert node.stop()[0] == 0
    until(lambda: not arm.commands[-1][1].any(), "a command of rest")
    last = np.array([command for _, command in arm.commands[count - 1 :]])
    assert np.abs(np.diff(last, axis=0)).max() < 0.7 * speed, f"a ramp, not a jump from {speed} rad/s"
