"""The program in the package, and a server in the process."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import revprio
from revprio import Client, NoAnswerError

PROGRAM = Path(sys.executable).with_name("revprio")


def test_a_server_in_the_process_ends_with_its_block() -> None:
    with revprio.serve() as client:
        assert client.is_ready()
        assert "sawyer_dh" in [robot.name for robot in client.robots()]
        url = client.url
    with Client(url, retries=0) as late, pytest.raises(NoAnswerError):
        late.robots()


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_ends_the_service_in_an_orderly_way(name: str) -> None:
    command = [str(PROGRAM), "serve", "--listen", "127.0.0.1:0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            url = process.stdout.readline().split()[-1]
            with revprio.connect(url) as client:
                assert client.is_ready()
            process.send_signal(getattr(signal, name))
            assert process.wait(20) == 0
        finally:
            process.kill()


def test_the_program_interrupts_long_work_at_once(tmp_path: Path) -> None:
    with subprocess.Popen([PROGRAM, "demo"], cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        try:
            with pytest.raises(subprocess.TimeoutExpired):
                process.wait(2)
            process.send_signal(signal.SIGINT)
            assert process.wait(20) != 0
        finally:
            process.kill()


def test_help_version_and_errors_are_those_of_the_program() -> None:
    for command in ([str(PROGRAM)], [sys.executable, "-m", "revprio"]):
        version = subprocess.run([*command, "--version"], capture_output=True, text=True, check=True)
        assert version.stdout.startswith("revprio ")
        wrong = subprocess.run([*command, "no-command"], capture_output=True, text=True, check=False)
        assert wrong.returncode == 2
        assert "no-command" in wrong.stderr
    missing = subprocess.run([PROGRAM, "resolve", os.devnull], capture_output=True, text=True, check=False)
    assert missing.returncode == 1
    assert missing.stderr.startswith("error: ")
