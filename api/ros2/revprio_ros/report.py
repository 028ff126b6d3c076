"""Diagnostics of the node, and the periods that it achieves."""

from __future__ import annotations

import re
from collections import deque

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from revprio_ros.control import Control, Phase

LEVELS = {
    Phase.RUNNING: DiagnosticStatus.OK,
    Phase.WAITING: DiagnosticStatus.WARN,
    Phase.BRAKING: DiagnosticStatus.ERROR,
    Phase.HALTED: DiagnosticStatus.ERROR,
}


class Periods:
    """The last intervals between two periods."""

    def __init__(self) -> None:
        """Starts without periods."""
        self._last_s: float | None = None
        self._intervals: deque[float] = deque(maxlen=500)

    def add(self, now_s: float) -> None:
        """Adds the start of a period."""
        if self._last_s is not None:
            self._intervals.append(now_s - self._last_s)
        self._last_s = now_s

    def summary(self) -> dict[str, str]:
        """Returns median, 99th percentile and maximum, ms."""
        if not self._intervals:
            return {}
        ordered = sorted(self._intervals)
        at = {"period p50 (ms)": 0.5, "period p99 (ms)": 0.99, "period max (ms)": 1.0}
        return {name: f"{1e3 * ordered[round(share * (len(ordered) - 1))]:.3f}" for name, share in at.items()}


class Report:
    """Publishes the state of the node on /diagnostics, and logs each change."""

    def __init__(self, node: Node) -> None:
        """Creates the publisher."""
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._logged = ""

    def publish(self, control: Control, now_s: float, periods: Periods, refused_targets: dict[str, str]) -> None:
        """Publishes one status for the control and one for the targets."""
        phase = control.state(now_s)
        message = f"{phase.value}: {control.problem}" if control.problem else phase.value
        has_failed = phase is Phase.WAITING and control.problem and control.sessions > 0
        level = DiagnosticStatus.ERROR if has_failed else LEVELS[phase]
        warnings = control.warnings + (list(control.answer.warnings or []) if control.answer is not None else [])
        if level == DiagnosticStatus.OK and (control.problem or warnings):
            level = DiagnosticStatus.WARN
        values = {
            "sessions": str(control.sessions),
            "answers": str(control.answered),
            **periods.summary(),
            **{f"warning {number}": text for number, text in enumerate(warnings, 1)},
        }
        refused = "; ".join(f"target of `{task}` is not used: {why}" for task, why in sorted(refused_targets.items()))
        target_level = DiagnosticStatus.WARN if refused else DiagnosticStatus.OK
        array = DiagnosticArray(
            status=[
                self._status("control", level, message, values),
                self._status("targets", target_level, refused or "no target was refused", {}),
            ]
        )
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)
        self._log(level, message, refused)

    def _status(self, name: str, level: bytes, message: str, values: dict[str, str]) -> DiagnosticStatus:
        pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
        full_name = f"{self._node.get_fully_qualified_name()}: {name}"
        return DiagnosticStatus(level=level, name=full_name, message=message, values=pairs)

    def _log(self, level: bytes, message: str, refused: str) -> None:
        text = "; ".join(filter(None, (message, refused)))
        kind = re.sub(r"\d+", "", text)  # Another number alone is no change.
        if kind != self._logged:
            log = self._node.get_logger()
            log.error(text) if level == DiagnosticStatus.ERROR else log.info(text)
            self._logged = kind
