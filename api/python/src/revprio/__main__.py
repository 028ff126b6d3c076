"""The program: `revprio serve`, `revprio demo`, …; also as `python -m revprio`."""

from __future__ import annotations

import signal
import sys

from revprio import _native


def main() -> int:
    """Runs the program with the arguments of this process; returns its exit status."""
    # The program installs its own handlers, or none. Python's handler would wait for Python code to run.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
