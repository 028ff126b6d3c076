"""A node in place of an arm and its driver: the simulator of revprio, in real time.

It starts `revprio simulate` with the address of a small HTTP server in this process. The simulator sends the state of
each control period there. The node publishes it, and answers with the newest command from ROS. Like most drivers, the
node repeats the last command until `command_timeout_s`, then it commands rest.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

import revprio
from geometry_msgs.msg import WrenchStamped
from rcl_interfaces.msg import SetParametersResult
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

from revprio_ros.process import ClosableNode, run_node

FAULTS = ("none", "no joint_states", "no wrench", "stale joint_states", "stale wrench", "NaN in joint_states")
"""Values of the parameter `fault`: what is wrong with the messages."""
TRACKING_GAIN = 5.0
"""Gain with which a trajectory is followed, 1/s."""


class Simulator(ClosableNode):
    """Publishes the states of the simulated arm and receives its commands."""

    def __init__(self) -> None:
        """Declares the parameters and starts the simulator."""
        super().__init__("simulator")
        self.declare_parameter("fault", "none")
        self.add_on_set_parameters_callback(self.check_fault)
        self.joint_prefix = self.declare_parameter("joint_prefix", "").value
        self.timeout_s = self.declare_parameter("command_timeout_s", 0.1).value
        scenario = self.declare_parameter("scenario", "stiff_wall").value
        self.joints: list[str] = []
        self.period_s = 0.0
        self.next_s = 0.0
        self.state: dict = {}
        self.command: list[float] = []
        self.commanded_s = -math.inf
        self.joint_states = self.create_publisher(JointState, "joint_states", qos_profile_sensor_data)
        self.wrenches = self.create_publisher(WrenchStamped, "wrench", qos_profile_sensor_data)
        self.create_subscription(Float64MultiArray, "forward_velocity_controller/commands", self.on_velocity, 1)
        self.create_subscription(JointTrajectory, "joint_trajectory_controller/joint_trajectory", self.on_trajectory, 1)
        self.server = ThreadingHTTPServer(("127.0.0.1", 0), handler(self))
        Thread(target=self.server.serve_forever, daemon=True).start()
        self.out = tempfile.TemporaryDirectory(prefix="revprio-")
        url = f"http://127.0.0.1:{self.server.server_port}"
        arguments = ["simulate", scenario, "--server", url, "--out", self.out.name]
        self.program = subprocess.Popen([sys.executable, "-m", "revprio", *arguments], stdout=subprocess.DEVNULL)
        self.create_timer(0.1, self.end_with_the_simulator)

    def check_fault(self, parameters: list) -> SetParametersResult:
        """Refuses an unknown fault."""
        is_known = all(parameter.name != "fault" or parameter.value in FAULTS for parameter in parameters)
        return SetParametersResult(successful=is_known, reason=f"`fault` must be one of: {', '.join(FAULTS)}")

    def open(self, config: dict) -> dict:
        """Answers the request for a session."""
        self.joints = [joint.name for joint in revprio.robot(config["robot"]).joints]
        self.tasks = [(task.get("name", ""), len(task.get("axes") or self.joints)) for task in config["tasks"]]
        self.period_s = config["period_s"]
        self.next_s = time.monotonic() + self.period_s
        return {"id": "ros", "idle_timeout_s": 900, "joints": self.joints}

    def step(self, state: dict) -> dict:
        """Publishes a state, waits for the end of its period, and answers with the command."""
        self.state = state
        self.publish_state(state, self.get_parameter("fault").value)
        time.sleep(max(self.next_s - time.monotonic(), 0.0))
        self.next_s = max(self.next_s, time.monotonic() - self.period_s) + self.period_s
        is_recent = time.monotonic() - self.commanded_s <= self.timeout_s
        return self.answer(state["sequence"], self.command if is_recent else [0.0] * len(self.joints))

    def publish_state(self, state: dict, fault: str) -> None:
        """Publishes joint state and wrench."""
        now = self.get_clock().now()
        joints = JointState(name=[self.joint_prefix + joint for joint in self.joints])
        joints.position, joints.velocity = list(state["joint_position"]), list(state["joint_velocity"])
        wrench = WrenchStamped()
        for name in ("force", "torque"):
            vector = getattr(wrench.wrench, name)
            vector.x, vector.y, vector.z = state["wrench"][name]
        if fault == "NaN in joint_states":
            joints.position[0] = math.nan
        for topic, publisher, message in (
            ("joint_states", self.joint_states, joints),
            ("wrench", self.wrenches, wrench),
        ):
            message.header.stamp = now.to_msg()
            if fault == f"stale {topic}":
                message.header.stamp.sec -= 10
            if fault != f"no {topic}":
                publisher.publish(message)

    def answer(self, sequence: int, velocity: list[float]) -> dict:
        """Returns an answer as a service gives it. The simulator uses the command; it records the rest."""
        tasks = [
            {
                "name": name,
                "requested": [0.0] * rows,
                "achieved": [0.0] * rows,
                "residual_norm": 0.0,
                "rank": 0,
                "algorithmic": False,
                "target_force": [None] * rows,
            }
            for name, rows in self.tasks
        ]
        return {
            "sequence": sequence,
            "joint_velocity": velocity,
            "valid_for_ms": 100,
            "elapsed_us": 0.0,
            "braking_deceleration": [None] * len(velocity),
            "joint_limit_index": 0.0,
            "tasks": tasks,
            "active_limits": [],
            "violated_limits": [],
            "limit_conflict": [],
            "singularity": {"algorithmic": False, "manipulability": 0.0, "smallest_singular_value": 0.0},
            "solver": {
                "path": "closed_form",
                "status": "optimal",
                "iterations": 0,
                "failures": 0,
                "working_sets": 0,
                "kkt_residual": None,
            },
        }

    def on_velocity(self, message: Float64MultiArray) -> None:
        """Stores a command of joint velocities."""
        self.receive(list(message.data))

    def on_trajectory(self, message: JointTrajectory) -> None:
        """Stores the velocities of a trajectory point, corrected by the distance to its positions."""
        point, position = message.points[-1], self.state["joint_position"]
        self.receive([v + TRACKING_GAIN * (p - q) for v, p, q in zip(point.velocities, point.positions, position)])

    def receive(self, velocity: list[float]) -> None:
        """Stores a command."""
        if len(velocity) == len(self.joints) and all(map(math.isfinite, velocity)):
            self.command, self.commanded_s = velocity, time.monotonic()

    def end_with_the_simulator(self) -> None:
        """Ends the node when the scenario is over."""
        status = self.program.poll()
        if status is not None:
            raise SystemExit(0 if status == 0 else f"`revprio simulate` ended with status {status}")

    def close(self, _spin: Callable[[float], None]) -> None:
        """Ends the simulator."""
        self.program.terminate()
        self.program.wait()
        self.server.shutdown()
        self.out.cleanup()


def handler(simulator: Simulator) -> type[BaseHTTPRequestHandler]:
    """Returns the class that answers the simulator's requests."""

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"
        wbufsize = -1  # One packet for each answer.
        disable_nagle_algorithm = True

        def do_POST(self) -> None:
            body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            is_step = self.path.endswith("/step")
            self.reply(200 if is_step else 201, simulator.step(body) if is_step else simulator.open(body))

        def do_DELETE(self) -> None:
            self.reply(204, None)

        def reply(self, status: int, answer: dict | None) -> None:
            body = b"" if answer is None else json.dumps(answer).encode()
            self.send_response(status)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *values: object) -> None:
            """Writes no log."""

    return Handler


def main() -> None:
    """Runs the node."""
    run_node(Simulator)


if __name__ == "__main__":
    main()
