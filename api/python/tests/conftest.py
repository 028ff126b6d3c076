"""A running service, and a line to it that can be cut."""

import json
import os
import socket
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from revprio import Client

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = os.environ.get("REVPRIO", str(ROOT / "target/debug/revprio"))


@contextmanager
def serve(*flags: str) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A service on a free port: its address and its process."""
    command = [PROGRAM, "serve", "--listen", "127.0.0.1:0", *flags]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        try:
            assert process.stdout is not None
            yield process.stdout.readline().split()[-1], process
        finally:
            process.kill()


@pytest.fixture(scope="session")
def url() -> Iterator[str]:
    with serve() as (address, _):
        yield address


@pytest.fixture
def client(url: str) -> Iterator[Client]:
    with Client(url, timeout_s=60, step_timeout_s=60) as client:
        yield client


@pytest.fixture(scope="session")
def document() -> dict[str, Any]:
    return read_json(ROOT / "api/openapi.json")


def example(name: str) -> dict[str, Any]:
    """A body of `api/examples`."""
    return read_json(ROOT / "api/examples" / f"{name}.json")


def read_json(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content


class Line:
    """A TCP line to a service that can stall, and lose an answer together with its connection."""

    def __init__(self, url: str) -> None:
        self._target = url.removeprefix("http://").split(":")
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._loses = False
        self._passing = threading.Event()
        self._passing.set()
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def stall(self) -> None:
        self._passing.clear()

    def resume(self) -> None:
        self._passing.set()

    def lose_next_answer(self) -> None:
        self._loses = True

    def close(self) -> None:
        self._listener.close()
        self.resume()

    def _accept(self) -> None:
        while True:
            try:
                near, _ = self._listener.accept()
            except OSError:
                return
            far = socket.create_connection((self._target[0], int(self._target[1])))
            for source, sink, is_back in ((near, far, False), (far, near, True)):
                threading.Thread(target=self._carry, args=(source, sink, is_back), daemon=True).start()

    def _carry(self, source: socket.socket, sink: socket.socket, is_back: bool) -> None:
        with suppress(OSError):
            while data := source.recv(65536):
                if is_back:
                    self._passing.wait()
                    if self._loses:
                        self._loses = False
                        break
                sink.sendall(data)
        for end in (source, sink):
            with suppress(OSError):  # the other direction may have ended it
                end.shutdown(socket.SHUT_RDWR)
            end.close()


@pytest.fixture
def line(url: str) -> Iterator[Line]:
    line = Line(url)
    yield line
    line.close()
