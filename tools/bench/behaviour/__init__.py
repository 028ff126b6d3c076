"""Compares the behaviour of revprio with that of pink, mink and placo; `run` starts it."""
