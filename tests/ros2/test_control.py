"""Real nodes over real middleware control the simulated arm."""

import json
import signal

import numpy as np
import pytest
from harness import free_port, recorder, until

FORCE_N = 20.0


def test_states_and_wrench_in_velocities_out(lab, arm, scenario, place):
    simulator = lab.node("simulator", scenario=lab.file("wall.json", json.dumps(scenario)))
    node = lab.node("controller", controller=lab.file("push.json", json.dumps(scenario["controller"])), url=place)
    arm.wait_for("controls the arm")
    # The sensor measures the wrench on the tool, so its force is the opposite of that on the wall.
    until(lambda: abs(np.linalg.norm(arm.force) - FORCE_N) < 1.0, f"{FORCE_N} N at the wall")
    arm.wait_for("controls the arm", level=0)
    count = len(arm.commands)
    assert node.stop()[0] == 0
    until(lambda: len(arm.commands) > count, "commands while the node stops")
    assert not arm.commands[-1][1].any()
    arm.wait_for_an_arm_at_rest()
    assert simulator.stop()[0] == 0


def test_a_push_in_one_line(lab, arm, scenario):
    lab.node("simulator", scenario=lab.file("wall.json", json.dumps(scenario)))
    line = f"push sawyer x {FORCE_N} approach_speed=0.05 lag_s=0.01 delay_periods=1"
    lab.node("controller", controller=line, wrench_convention="on_tool", wrench_frame="tool")
    arm.wait_for("controls the arm")
    until(lambda: abs(np.linalg.norm(arm.force) - FORCE_N) < 1.0, f"{FORCE_N} N at the wall")


@pytest.fixture(params=["in this process", "at a service"])
def place(request, lab):
    """Returns the address of a service, or none for the node's own process."""
    return lab.service(free_port())[1] if request.param == "at a service" else ""


def test_trajectory_points_out(lab, arm, scenario):
    lab.node("simulator", scenario=lab.file("wall.json", json.dumps(scenario)))
    text = json.dumps(scenario["controller"])
    lab.node("controller", controller=lab.file("push.json", text), output="trajectory")
    until(lambda: abs(np.linalg.norm(arm.force) - FORCE_N) < 1.0, f"{FORCE_N} N at the wall")
    until(lambda: len(arm.points) > 50, "trajectory points")
    assert not arm.commands
    assert arm.points[0].joints == [f"right_j{i}" for i in range(7)]
    period_s = scenario["controller"]["period_s"]
    assert {point.ns for point in arm.points} == {round(1e9 * period_s)}
    # The positions are the integral of the velocities. Some points are lost, or begin a new session.
    steps = [(after.position - before.position, after.velocity) for before, after in zip(arm.points, arm.points[1:])]
    assert sum(np.allclose(step, period_s * velocity, atol=1e-9) for step, velocity in steps) > 0.5 * len(steps)
    assert max(np.abs(step).max() for step, _ in steps) < 0.1


def test_the_order_of_the_velocity_command_is_a_parameter(lab, arm, scenario):
    lab.node("simulator", scenario=lab.file("wall.json", json.dumps(scenario)))
    path = lab.file("push.json", json.dumps(scenario["controller"]))
    backwards = [f"right_j{i}" for i in reversed(range(7))]
    remap = {"forward_velocity_controller/commands": "backwards"}
    lab.node("controller", controller=path, remap=remap, output="both", command_joints=json.dumps(backwards))
    from std_msgs.msg import Float64MultiArray

    received = []
    arm.node.create_subscription(
        Float64MultiArray, "backwards", lambda message: received.append(list(message.data)), 10
    )
    # Only the trajectory reaches the simulator.
    until(lambda: np.linalg.norm(arm.force) > 1.0, "contact")

    def is_reversed():
        points = [list(point.velocity) for point in arm.points[-50:]]
        return any(any(command) and command[::-1] in points for command in received[-50:])

    until(is_reversed, "a command that is the reverse of a trajectory point")


def test_two_arms_in_two_namespaces(lab, scenario):
    left, right = recorder("left"), recorder("right")
    for name, newtons in (("left", 20.0), ("right", 10.0)):
        lab.node("simulator", name, scenario=lab.file("wall.json", json.dumps(scenario)))
        scenario["controller"]["tasks"][0]["law"]["target_force"]["value"] = newtons
        lab.node("controller", name, controller=lab.file(f"{name}.json", json.dumps(scenario["controller"])))
    until(lambda: abs(np.linalg.norm(left.force) - 20) < 1.0, "20 N at the left wall")
    until(lambda: abs(np.linalg.norm(right.force) - 10) < 1.0, "10 N at the right wall")


def test_a_killed_node_leaves_the_arm_to_the_timeout_of_the_driver(lab, arm, scenario):
    scenario["contacts"] = []
    lab.node("simulator", scenario=lab.file("free.json", json.dumps(scenario)))
    node = lab.node("controller", controller=lab.file("push.json", json.dumps(scenario["controller"])))
    arm.wait_for_motion()
    until(lambda: arm.states and np.abs(arm.velocity()).max() > 1e-2, "a moving arm")
    node.signal(signal.SIGKILL)
    arm.wait_for_an_arm_at_rest()
    count = len(arm.commands)
    lab.node("controller", controller=lab.directory / "push.json")
    until(lambda: arm.is_moving(count), "a new node moves the arm")
