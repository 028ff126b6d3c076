"""revprio through a service at `REVPRIO_URL`, for the time of a step."""

from __future__ import annotations

import os

import revprio

from barrier.controllers.base import Task
from barrier.controllers.revprio import Revprio


def make(task: Task) -> Revprio:
    """Starts a session of the service."""
    return Revprio(task, revprio.Client(os.environ["REVPRIO_URL"], timeout_s=60, step_timeout_s=60))
