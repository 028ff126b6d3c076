"""What controllers and simulations need of a client."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Protocol, TypeVar

from websockets.sync.client import ClientConnection

from revprio import routes

A = TypeVar("A")


class Caller(Protocol):
    """Makes the calls of a service, wherever it runs."""

    step_timeout_s: float
    """Time limit of a control period, s."""

    def call(self, call: routes.Call[A], timeout_s: float | None = None) -> A:
        """Makes a call of `revprio.routes` and returns its answer."""


class Connector(Caller, Protocol):
    """Calls a service over HTTP, and connects WebSockets to it."""

    url: str
    """Base address of the service."""

    def connect(self, path: str) -> AbstractContextManager[ClientConnection]:
        """Returns a context manager that opens a WebSocket to a path of the service."""
