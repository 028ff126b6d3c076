"""Messages of a stream; used by the blocking and the asyncio client."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING

from pydantic import ValidationError
from websockets.exceptions import InvalidHandshake, InvalidStatus
from websockets.typing import Subprotocol

from revprio.errors import ForeignAnswerError, RevprioError, problem_error
from revprio.models import Problem, State, StepAnswer

if TYPE_CHECKING:
    from websockets.asyncio.client import ClientConnection as AsyncConnection
    from websockets.sync.client import ClientConnection

SUBPROTOCOL = Subprotocol("revprio.json")


class ReplyMatcher:
    """Finds the reply to the last state.

    The service sends one reply per state, in the same order. Late replies to earlier states therefore come first.
    """

    def __init__(self, url: str) -> None:
        """`url`: address of the service, for error texts."""
        self._url = url
        self._awaited = 0

    def encode(self, state: State) -> str:
        """Returns the message of a state and counts it as awaiting a reply."""
        self._awaited += 1
        return state.json_bytes().decode()

    def decode(self, message: str | bytes) -> StepAnswer | None:
        """Returns the answer to the last state, or `None` for a reply to an earlier one; raises a refusal."""
        self._awaited -= 1
        if self._awaited > 0:
            return None
        try:
            return StepAnswer.model_validate_json(message)
        except ValidationError as error:
            try:
                problem = Problem.model_validate_json(message)
            except ValidationError:
                raise ForeignAnswerError(self._url, 200, error) from error
        raise problem_error(problem)


def receive(socket: ClientConnection, end_s: float) -> str | bytes:
    """Returns the next message; raises a `TimeoutError` if none comes before `end_s` on the monotonic clock."""
    return socket.recv(max(end_s - time.monotonic(), 0.0))


async def receive_async(socket: AsyncConnection, end_s: float) -> str | bytes:
    """As `receive`, without blocking."""
    async with asyncio.timeout(end_s - time.monotonic()):
        return await socket.recv()


def refused_handshake(url: str, error: InvalidHandshake) -> RevprioError:
    """Returns the exception for a refused WebSocket handshake."""
    if isinstance(error, InvalidStatus):
        response = error.response
        try:
            return problem_error(Problem.model_validate_json(response.body or b""))
        except ValidationError:
            return ForeignAnswerError(url, response.status_code, error)
    return ForeignAnswerError(url, 101, error)


def websocket_url(url: str, path: str) -> str:
    """Returns the WebSocket address: `ws://` for `http://`, `wss://` for `https://`."""
    return "ws" + url.removeprefix("http") + path
