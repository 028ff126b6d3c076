"""Starts and ends the process of a node."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from threading import Event

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions


class ClosableNode(Node):
    """A node that ends cleanly."""

    def close(self, spin: Callable[[float], None]) -> None:
        """Ends what the node has started. `spin` handles messages for a time, s."""
        raise NotImplementedError


def spin(executor: SingleThreadedExecutor, time_s: float) -> None:
    """Handles messages for a time, s."""
    end_s = time.monotonic() + time_s
    while (left_s := end_s - time.monotonic()) > 0:
        executor.spin_once(timeout_sec=left_s)


def run_node(create: Callable[[], ClosableNode]) -> None:
    """Runs a node until SIGINT or SIGTERM, or until it raises an exception; then calls its `close`.

    ROS stays usable in `close`, so that the node can still publish. Signals do not interrupt it.
    """
    stopping = Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node, executor = None, SingleThreadedExecutor()
    try:
        node = create()
        executor.add_node(node)
        while not stopping.is_set():
            executor.spin_once(timeout_sec=0.1)
    finally:
        if node is not None:
            node.close(lambda time_s: spin(executor, time_s))
            executor.shutdown()
            node.destroy_node()
        rclpy.try_shutdown()
