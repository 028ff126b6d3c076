"""Compares how revprio and five other programs keep an arm clear of an obstacle; `run` starts it."""
