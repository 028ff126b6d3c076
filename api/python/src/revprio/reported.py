"""Warnings about controllers go to the log of Python, where a user sees them without asking."""

from __future__ import annotations

import logging
from collections.abc import Iterable

LOG = logging.getLogger("revprio")
"""Prints warnings to the standard error, unless the program configures its logging."""


def log_warnings(warnings: Iterable[str]) -> None:
    """Logs the warnings about a new or changed controller."""
    for warning in warnings:
        LOG.warning("%s", warning)
