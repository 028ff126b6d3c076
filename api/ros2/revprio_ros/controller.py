"""The node that controls an arm: joint states, wrench and targets in; velocities or trajectory points out."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import revprio

from revprio_ros import parameters
from revprio_ros.chunks import Chunks
from revprio_ros.connection import Connection
from revprio_ros.control import Control, Phase
from revprio_ros.inputs import Inputs
from revprio_ros.loop_clock import LoopClock
from revprio_ros.obstacles import Obstacles
from revprio_ros.outputs import Outputs
from revprio_ros.process import ClosableNode, run_node
from revprio_ros.report import Periods, Report
from revprio_ros.sign_check import SignMonitor
from revprio_ros.targets import Targets

REPORT_S = 0.2
"""Time between two diagnostics, s."""
REST_COMMANDS = 3
"""Number of commands of rest before the node ends."""
MAX_STOP_S = 5.0
"""Time after which the node sends zero at once with simulated time, which may be slow, s."""
MAX_STANDSTILL_S = 0.5
"""The same after the last tick of `/clock`, s: nothing tells the time of a ramp then."""


class Controller(ClosableNode):
    """Runs one control period per tick of its timer."""

    def __init__(self) -> None:
        """Reads the parameters and starts to wait. Raises a `ParameterError`."""
        super().__init__("revprio")
        settings = parameters.read(self)
        self.config = config = settings.config
        self.period_s = config.period_s
        self.clock = LoopClock(self)
        self.inputs = Inputs(self, self.clock, settings)
        self.targets = Targets(self, self.clock, settings)
        self.chunks = Chunks(self, self.clock, settings)
        self.obstacles = Obstacles(self, self.clock, settings)
        self.outputs = Outputs(self, settings)
        self.connection = Connection(config, settings.url, settings.token)
        check = (settings.sign_check_force_n, settings.sign_check_periods)
        self.sign = SignMonitor(self.connection.client, config, *check)
        self.control = Control(self.connection, self.period_s)
        self.may_publish = False
        self.periods, self.report, self.ticks = Periods(), Report(self), 0
        self.timer = self.create_timer(self.period_s, self.tick, clock=self.clock.clock)
        place = settings.url or "this process"
        self.get_logger().info(f"{config.robot}, period {self.period_s} s, computed by {place}")

    def tick(self) -> None:
        """Runs one control period."""
        now_s = self.clock.now_s()
        self.periods.add(now_s)
        self.ticks += 1
        self.control.update(self.clock.now_s, self.check_fresh, self.read)
        if self.control.robot is not None:
            self.outputs.check(self.control.joints)
            parameters.check_wrenches(self.config, self.control.robot.tips)
            self.may_publish = True
            self.publish()
        if self.ticks % max(round(REPORT_S / self.period_s), 1) == 0:
            self.report.publish(self.control, now_s, self.periods, self.targets.refusals | self.chunks.refusals)

    def check_fresh(self) -> None:
        """Raises a `NotUsable` that names a topic without a fresh message."""
        self.inputs.check_fresh()
        self.obstacles.check_fresh()

    def read(self, joints: list[str]) -> tuple[dict[str, Any], float]:
        """Returns the arguments of the next step and the time of the measurement."""
        arguments, measured_s = self.inputs.measurement(joints)
        finding = self.sign.update(arguments)
        if finding is not None:
            self.control.halt(finding, self.clock.now_s())
        start_s = measured_s if self.control.start_s is None else self.control.start_s
        targets, obstacles = self.targets.current(start_s), self.obstacles.current()
        if self.control.is_free:  # Otherwise, no state is sent in this period.
            targets |= self.chunks.current(start_s, self.control.settled)
        return {**arguments, "targets": targets or None, "obstacles": obstacles or None}, measured_s

    def publish(self) -> None:
        """Publishes the command of this period."""
        joints = self.control.joints
        velocity = self.control.command(self.clock.now_s())
        moves = self.control.phase in (Phase.RUNNING, Phase.BRAKING)
        if not moves:
            self.outputs.rest()
        position = self.inputs.position(joints) if moves and self.outputs.has_points else None
        self.outputs.publish(joints, velocity, position, self.period_s)

    def close(self, spin: Callable[[float], None]) -> None:
        """Brakes to rest and ends the session. `spin` handles messages for a time, s: `/clock` and joint states."""
        self.timer.cancel()
        try:
            self.come_to_rest(spin)
            self.report.publish(self.control, self.clock.now_s(), self.periods, {})
        finally:
            self.sign.close()
            self.connection.close()

    def come_to_rest(self, spin: Callable[[float], None]) -> None:
        """Brakes, and sends commands of rest."""
        self.control.halt("the node is being stopped", self.clock.now_s())
        left, begin_s = REST_COMMANDS, time.monotonic()
        now_s, ticked_s = self.clock.now_s(), begin_s
        published_s = float("-inf")
        while self.may_publish and left > 0:
            if self.clock.now_s() != now_s:
                now_s, ticked_s = self.clock.now_s(), time.monotonic()
            if time.monotonic() > min(ticked_s + MAX_STANDSTILL_S, begin_s + MAX_STOP_S) and not self.clock.is_steady:
                self.control.rest()
            self.control.update(self.clock.now_s, self.check_fresh, self.read)
            is_halted = self.control.phase is Phase.HALTED
            # A point is one period on: with a slow `/clock`, points of each real period would run ahead.
            if is_halted or self.clock.now_s() > published_s + 0.99 * self.period_s:
                published_s = self.clock.now_s()
                left -= is_halted
                self.publish()
            spin(self.period_s)


def main() -> None:
    """Runs the node; ends with status 1 and a sentence if a parameter is wrong."""
    try:
        run_node(Controller)
    except (parameters.ParameterError, revprio.RevprioError) as error:
        sys.exit(f"revprio_ros: {error}")


if __name__ == "__main__":
    main()
