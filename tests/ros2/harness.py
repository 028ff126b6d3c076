"""Processes of real nodes, and a node that records what they publish."""

from __future__ import annotations

import atexit
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from threading import Thread
from types import SimpleNamespace

import numpy as np
import rclpy
import revprio
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

REPOSITORY = Path(__file__).resolve().parents[2]
PACKAGE = REPOSITORY / "api/ros2"
PATIENCE_S = 30.0
"""Time after which a test gives up, s. It does not depend on how fast the machine is."""


def until(condition: Callable[[], object], what: str, patience_s: float = PATIENCE_S) -> object:
    """Waits until a condition holds and returns its value."""
    end_s = time.monotonic() + patience_s
    while not (value := condition()):
        assert time.monotonic() < end_s, f"after {patience_s} s still not: {what}"
        time.sleep(0.02)
    return value


class Process:
    """A process with its children; the end of the test ends it."""

    def __init__(self, arguments: list[str], environment: dict[str, str] | None = None) -> None:
        self.log = tempfile.TemporaryFile("w+")  # noqa: SIM115 - `end` closes it
        variables = os.environ | (environment or {})
        self._popen = subprocess.Popen(
            arguments, env=variables, stdout=self.log, stderr=subprocess.STDOUT, start_new_session=True, text=True
        )

    def signal(self, number: int) -> None:
        """Sends a signal to the process and its children."""
        os.killpg(self._popen.pid, number)

    def wait(self) -> int:
        """Waits for the end and returns the exit status."""
        return self._popen.wait(PATIENCE_S)

    def stop(self) -> tuple[int, str]:
        """Stops the process as Ctrl-C does; returns exit status and output."""
        os.kill(self._popen.pid, signal.SIGINT)
        return self.wait(), self.output()

    def output(self) -> str:
        """Returns what the process has printed."""
        self.log.seek(0)
        return self.log.read()

    def ask_to_end(self) -> None:
        """Asks the process to end."""
        with suppress(ProcessLookupError):
            self.signal(signal.SIGINT)

    def end(self) -> None:
        """Ends the process and its children, at once if it does not do so itself."""
        with suppress(subprocess.TimeoutExpired):
            self._popen.wait(1.0)
        with suppress(ProcessLookupError):
            self.signal(signal.SIGKILL)
        self._popen.wait()
        self.log.close()


def ros_arguments(namespace: str, parameters: dict[str, object], remap: dict[str, str]) -> list[str]:
    """Returns the arguments of a node."""
    empty = "''"
    given = [part for name, value in parameters.items() for part in ("-p", f"{name}:={value or empty}")]
    renamed = [part for old, new in remap.items() for part in ("-r", f"{old}:={new}")]
    return ["--ros-args", "-r", f"__ns:=/{namespace}", *given, *renamed]


def free_port() -> int:
    """Returns a free port of this machine."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Lab:
    """Starts nodes and services for one test and ends them."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.processes: list[Process] = []

    def start(self, arguments: list[str]) -> Process:
        """Starts a program."""
        process = Process(arguments)
        self.processes.append(process)
        return process

    def node(self, executable: str, namespace: str = "", remap: dict[str, str] | None = None, **parameters) -> Process:
        """Starts a node of the package."""
        arguments = ros_arguments(namespace, parameters, remap or {})
        return self.start([sys.executable, "-m", f"revprio_ros.{executable}", *arguments])

    def service(self, port: int, *options: str) -> tuple[Process, str]:
        """Starts a service and waits until it is ready."""
        url = f"http://127.0.0.1:{port}"
        process = self.start([sys.executable, "-m", "revprio", "serve", "--listen", f"127.0.0.1:{port}", *options])
        with revprio.Client(url) as client:
            until(client.is_ready, f"the service at {url} is ready")
        return process, url

    def file(self, name: str, text: str) -> Path:
        """Writes a file for the test."""
        path = self.directory / name
        path.write_text(text)
        return path

    def end(self) -> None:
        """Ends all processes. The middleware of one that ends itself says so to the others."""
        for process in self.processes:
            process.ask_to_end()
        for process in self.processes:
            process.end()


class Recorder:
    """A node that records the commands, states and diagnostics of one arm."""

    def __init__(self, namespace: str = "") -> None:
        self.prefix = f"/{namespace}" if namespace else ""
        self.forget()
        if not rclpy.ok():
            rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self.node = rclpy.create_node("recorder", namespace=namespace or None)
        each = QoSProfile(depth=1000)
        sensors = qos_profile_sensor_data
        self.node.create_subscription(Float64MultiArray, "forward_velocity_controller/commands", self._command, each)
        self.node.create_subscription(
            JointTrajectory, "joint_trajectory_controller/joint_trajectory", self._point, each
        )
        self.node.create_subscription(JointState, "joint_states", self._state, sensors)
        self.node.create_subscription(WrenchStamped, "wrench", self._wrench, sensors)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._diagnostics, each)
        self.simulator = self.node.create_client(SetParameters, "simulator/set_parameters")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.is_closing = False
        self.thread = Thread(target=self._spin, daemon=True)
        self.thread.start()
        atexit.register(self.close)

    def forget(self) -> None:
        """Forgets what was recorded."""
        self.heard_s = time.monotonic()
        self.commands: list[tuple[float, np.ndarray]] = []
        self.points: list[SimpleNamespace] = []
        self.states: list[tuple[float, JointState]] = []
        self.force = np.zeros(3)
        self.statuses: dict[str, SimpleNamespace] = {}

    def restart(self) -> None:
        """Forgets the nodes of earlier tests, when the last message of them has arrived."""
        until(lambda: time.monotonic() > self.heard_s + 0.5, "silence of the nodes of earlier tests")
        self.forget()

    def _spin(self) -> None:
        while not self.is_closing:
            self.executor.spin_once(timeout_sec=0.05)

    def _command(self, message: Float64MultiArray) -> None:
        self.heard_s = time.monotonic()
        self.commands.append((time.monotonic(), np.array(message.data)))

    def _point(self, message: JointTrajectory) -> None:
        point = message.points[-1]
        self.points.append(
            SimpleNamespace(
                joints=list(message.joint_names),
                position=np.array(point.positions),
                velocity=np.array(point.velocities),
                ns=point.time_from_start.nanosec,
            )
        )

    def _state(self, message: JointState) -> None:
        self.heard_s = time.monotonic()
        self.states.append((time.monotonic(), message))

    def _wrench(self, message: WrenchStamped) -> None:
        force = message.wrench.force
        self.force = np.array([force.x, force.y, force.z])

    def _diagnostics(self, message: DiagnosticArray) -> None:
        self.heard_s = time.monotonic()
        for status in message.status:
            if status.name.startswith(f"{self.prefix}/revprio: "):
                values = {pair.key: pair.value for pair in status.values}
                level = int.from_bytes(status.level, "little")
                name = status.name.rsplit(": ", 1)[1]
                self.statuses[name] = SimpleNamespace(level=level, message=status.message, values=values)

    def says(self, text: str, status: str = "control") -> SimpleNamespace | None:
        """Returns the newest diagnostics if their message contains a text."""
        newest = self.statuses.get(status)
        return newest if newest is not None and text in newest.message else None

    def wait_for(self, text: str, status: str = "control", level: int | None = None) -> SimpleNamespace:
        """Waits for diagnostics of a level whose message contains a text."""
        until(lambda: self.statuses.get(status), f"diagnostics of {self.prefix}/revprio")
        found = lambda: (said := self.says(text, status)) and (level is None or said.level == level) and said
        return until(found, f"diagnostics say `{text}` with level {level}; {self.statuses[status]}")

    def wait_for_motion(self) -> None:
        """Waits until the node commands a motion."""
        count = len(self.commands)
        until(lambda: self.is_moving(count), f"a command that moves the arm; diagnostics: {self.statuses}")

    def sessions(self) -> int:
        """Returns how many sessions the node has opened."""
        return int(self.statuses["control"].values["sessions"]) if "control" in self.statuses else 0

    def is_moving(self, since: int = 0) -> bool:
        """Returns whether the newest command moves a joint."""
        return len(self.commands) > since and bool(np.abs(self.commands[-1][1]).max() > 1e-3)

    def wait_for_rest(self) -> None:
        """Waits until the node commands rest."""
        count = len(self.commands)
        until(lambda: len(self.commands) > count and not self.commands[-1][1].any(), "a command of rest")

    def wait_for_an_arm_at_rest(self) -> None:
        """Waits until the simulated arm is at rest."""
        until(lambda: self.states and np.abs(self.velocity()).max() < 1e-4, "an arm at rest")

    def velocity(self) -> np.ndarray:
        """Returns the newest joint velocities."""
        return np.array(self.states[-1][1].velocity)

    def tool(self, robot: str = "sawyer") -> np.ndarray:
        """Returns the position of the tool at the newest joint state."""
        return np.array(revprio.kinematics(robot=robot, joint_position=list(self.states[-1][1].position)).pose.position)

    def set_fault(self, fault: str) -> None:
        """Sets the fault of the simulator."""
        value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=fault)
        request = SetParameters.Request(parameters=[Parameter(name="fault", value=value)])

        def answer() -> SetParameters.Response | None:
            call = self.simulator.call_async(request)
            # The killed simulator of an earlier test seems ready for a while, and the new one may miss the first call.
            with suppress(AssertionError):
                until(call.done, "an answer", 1.0)
            return call.result()

        result = until(answer, "the simulator sets its fault").results[0]
        assert result.successful, result.reason

    def close(self) -> None:
        """Ends the recording."""
        self.is_closing = True
        self.thread.join()


@cache
def _recorder(namespace: str) -> Recorder:
    return Recorder(namespace)


def recorder(namespace: str = "") -> Recorder:
    """Returns the recorder of an arm, which remembers nothing of earlier tests.

    A recorder lives as long as the process: the middleware can crash while it destroys a node or a context.
    """
    recorder = _recorder(namespace)
    recorder.restart()
    return recorder
