"""Where the service runs: in this process, or at an address."""

from __future__ import annotations

import ssl
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, overload

from revprio import _native
from revprio.client import Client
from revprio.local import Local

LOCAL = Local()
"""The service in this process."""


@overload
def connect(url: None = None) -> Local: ...
@overload
def connect(
    url: str,
    *,
    token: str | None = None,
    timeout_s: float = 10.0,
    step_timeout_s: float = 1.0,
    retries: int = 2,
    tls: ssl.SSLContext | None = None,
    owner: str | None = None,
) -> Client: ...
@overload
def connect(
    url: str | None,
    *,
    token: str | None = None,
    timeout_s: float = 10.0,
    step_timeout_s: float = 1.0,
    retries: int = 2,
    tls: ssl.SSLContext | None = None,
    owner: str | None = None,
) -> Local | Client: ...
def connect(url: str | None = None, **options: Any) -> Local | Client:
    """Returns a client of the service at `url`, or the service in this process if there is no address.

    Both have the same methods, and their answers are equal to the last bit. The options are those of `Client`.
    """
    return LOCAL if url is None else Client(url, **options)


@contextmanager
def serve(*, timeout_s: float = 10.0, step_timeout_s: float = 1.0) -> Iterator[Client]:
    """Starts a service on a free loopback port and yields a client of it: `with revprio.serve() as client:`.

    Other programs can call it at `client.url`. The service ends with the block. The program `revprio serve` has more
    settings.
    """
    server = _native.Server()
    try:
        with Client(server.url, timeout_s=timeout_s, step_timeout_s=step_timeout_s) as client:
            yield client
    finally:
        server.close()
