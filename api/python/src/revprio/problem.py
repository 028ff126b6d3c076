"""A refused request. Generated from the OpenAPI document by `generate.py`; do not edit."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from revprio.answers import Answer


class Problem(Answer):
    """Why a request was refused, and the remedy.

    Fields:

    - detail: Description of this problem, with the remedy.
    - status: HTTP status code.
    - title: Kind of problem in words.
    - type: Identifier of the kind of problem, a relative reference that never changes.
    - candidates: Possible values of the wrong field, best first, if they can be listed: links for `base` and `tip`
      of a robot.
    - pointer: JSON pointer to the wrong field of the request, if there is one.
    - request_id: Identifier of the request, as in the header `x-request-id` and in the log.
    """

    detail: str
    """Description of this problem, with the remedy."""
    status: int
    """HTTP status code."""
    title: str
    """Kind of problem in words."""
    type: Literal[
        "/problems/malformed",
        "/problems/bad-host",
        "/problems/unauthorized",
        "/problems/permanent",
        "/problems/foreign-host",
        "/problems/foreign-origin",
        "/problems/owner",
        "/problems/not-found",
        "/problems/unknown-controller",
        "/problems/method-not-allowed",
        "/problems/not-acceptable",
        "/problems/timeout",
        "/problems/sequence",
        "/problems/name-taken",
        "/problems/no-trace",
        "/problems/not-live",
        "/problems/too-large",
        "/problems/media-type",
        "/problems/content-encoding",
        "/problems/invalid",
        "/problems/implausible",
        "/problems/key-reused",
        "/problems/upgrade-required",
        "/problems/too-many-failures",
        "/problems/internal",
        "/problems/transfer-encoding",
        "/problems/too-many-controllers",
        "/problems/too-many-robots",
        "/problems/busy",
        "/problems/deadline",
        "/problems/stuck",
        "/problems/overloaded",
        "/problems/draining",
    ]
    """Identifier of the kind of problem, a relative reference that never changes."""
    candidates: list[str] = Field(default_factory=list)
    """Possible values of the wrong field, best first, if they can be listed: links for `base` and `tip` of a robot."""
    pointer: str | None = None
    """JSON pointer to the wrong field of the request, if there is one."""
    request_id: str | None = None
    """Identifier of the request, as in the header `x-request-id` and in the log."""


REMEDIES: dict[str, str] = {
    "/problems/malformed": "Correct the syntax of the body at the place that `detail` names.",
    "/problems/bad-host": "Send exactly one `Host`.",
    "/problems/unauthorized": "Send `Authorization: Bearer` with the service's token.",
    "/problems/permanent": "Delete only registered robots.",
    "/problems/foreign-host": "Use the address of the service, or start it with `--allow-host` and the name.",
    "/problems/foreign-origin": "Start the service with `--allow-origin` and the origin of that page.",
    "/problems/owner": "Step, replace and end only your own sessions. Send the same `Revprio-Owner` with which the session was opened.",
    "/problems/not-found": "Use a name from a list or from the answer that created the resource.",
    "/problems/unknown-controller": "Open a new session.",
    "/problems/method-not-allowed": "Use a method that the header `Allow` lists.",
    "/problems/not-acceptable": "Accept one of the media types that `detail` lists.",
    "/problems/timeout": "Send the whole body without pauses.",
    "/problems/sequence": "Increase the number with every new state. Repeat a number only to send the same state again.",
    "/problems/name-taken": "Choose another name.",
    "/problems/no-trace": "Read the state of the simulation; wait until it is `finished`.",
    "/problems/not-live": "Start a simulation with `interactive`.",
    "/problems/too-large": "Send a smaller body; `detail` states the limit.",
    "/problems/media-type": "Send the media type of the body as `Content-Type`.",
    "/problems/content-encoding": "Send the body without compression.",
    "/problems/invalid": "Change the field at `pointer` as `detail` says.",
    "/problems/implausible": "Check units and sensors. If the state is right, set a larger bound in `state_checks`.",
    "/problems/key-reused": "Send a new key with every new request. Repeat a key only to send the same request again.",
    "/problems/upgrade-required": "Use a WebSocket client.",
    "/problems/too-many-failures": "Send the service's token, or wait for the time in `Retry-After`.",
    "/problems/internal": "Read the service's log.",
    "/problems/transfer-encoding": "Send the body with `Content-Length` or `Transfer-Encoding: chunked`.",
    "/problems/too-many-controllers": "Delete a session, or wait until an idle one ends.",
    "/problems/too-many-robots": "Delete a robot, or wait until an unused one ends.",
    "/problems/busy": "Try again after the time in `Retry-After`.",
    "/problems/deadline": "Send a smaller problem, or try again when the service is less busy.",
    "/problems/stuck": "Send the request to another instance, or again after the restart.",
    "/problems/overloaded": "Send fewer requests, or start another server.",
    "/problems/draining": "Send the request to another instance.",
}
"""What to do about each type of problem."""
