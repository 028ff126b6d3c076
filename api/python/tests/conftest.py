"""A running service, and a TCP proxy that simulates a faulty network."""

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
    """Starts a service on a free port; yields its address and its process."""
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
    """Returns a body of `api/examples`."""
    return read_json(ROOT / "api/examples" / f"{name}.json")


def read_json(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content


class FaultyProxy:
    """A TCP proxy that can hold back answers, and drop a connection instead of forwarding an answer."""

    def __init__(self, url: str) -> None:
        self._target = url.removeprefix("http://").split(":")
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._drops_answer = False
        self._forwarding = threading.Event()
        self._forwarding.set()
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def stall(self) -> None:
        self._forwarding.clear()

    def resume(self) -> None:
        self._forwarding.set()

    def drop_next_answer(self) -> None:
        self._drops_answer = True

    def close(self) -> None:
        self._listener.close()
        self.resume()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            service = socket.create_connection((self._target[0], int(self._target[1])))
            for source, sink, is_answer in ((client, service, False), (service, client, True)):
                threading.Thread(target=self._forward, args=(source, sink, is_answer), daemon=True).start()

    def _forward(self, source: socket.socket, sink: socket.socket, is_answer: bool) -> None:
        with suppress(OSError):
            while data := source.recv(65536):
                if is_answer:
                    self._forwarding.wait()
                    if self._drops_answer:
                        self._drops_answer = False
                        break
                sink.sendall(data)
        for end in (source, sink):
            with suppress(OSError):  # the other direction may have closed it
                end.shutdown(socket.SHUT_RDWR)
            end.close()


@pytest.fixture
def proxy(url: str) -> Iterator[FaultyProxy]:
    proxy = FaultyProxy(url)
    yield proxy
    proxy.close()
