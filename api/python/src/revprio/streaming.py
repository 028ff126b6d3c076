"""Messages of a stream, whatever carries them."""

from __future__ import annotations

from pydantic import ValidationError
from websockets.exceptions import InvalidHandshake, InvalidStatus

from revprio.errors import ForeignAnswerError, RevprioError, problem_error
from revprio.models import Problem, State, StepAnswer

SUBPROTOCOL = "revprio.json"


class Replies:
    """Finds the answer to the last state: each state gets one reply, in order, and the late ones come first."""

    def __init__(self, url: str) -> None:
        """`url`: who answers, for messages."""
        self._url = url
        self._awaited = 0

    def ask(self, state: State) -> str:
        """The message of a state."""
        self._awaited += 1
        return state.json_bytes().decode()

    def hear(self, message: str | bytes) -> StepAnswer | None:
        """The answer in a message, `None` if it belongs to a state before; raises what was refused."""
        self._awaited -= 1
        if self._awaited > 0:
            return None
        try:
            return StepAnswer.model_validate_json(message)
        except ValidationError as unlike_an_answer:
            try:
                problem = Problem.model_validate_json(message)
            except ValidationError:
                raise ForeignAnswerError(self._url, 200, unlike_an_answer) from unlike_an_answer
        raise problem_error(problem)


def refused_handshake(url: str, error: InvalidHandshake) -> RevprioError:
    """The exception for a stream that is not opened."""
    if isinstance(error, InvalidStatus):
        response = error.response
        try:
            return problem_error(Problem.model_validate_json(response.body or b""))
        except ValidationError:
            return ForeignAnswerError(url, response.status_code, error)
    return ForeignAnswerError(url, 101, error)


def websocket_url(url: str, path: str) -> str:
    """`ws://` for `http://`, `wss://` for `https://`."""
    return "ws" + url.removeprefix("http") + path
