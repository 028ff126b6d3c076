"""The first periods of `stiff_wall`, simulated here and by the service, for comparison."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from revprio import Client, Scenario

DURATION_S = 0.45
"""Duration of the run, s: long enough to touch the wall and bounce off it."""


def scenario(client: Client) -> Scenario:
    return client.scenario("stiff_wall").model_copy(update={"duration_s": DURATION_S})


class Plant:
    """An arm that follows its commands exactly, and a wall along x."""

    def __init__(self, client: Client, scenario: Scenario) -> None:
        self.period_s = scenario.controller.period_s
        self.q = np.array(scenario.start_joint_position, dtype=float)
        self.qdot = np.zeros_like(self.q)
        self._joints = client.robot(scenario.controller.robot).joints
        (self._wall,) = scenario.contacts or []
        self._start_m = self._tool_x()

    def _tool_x(self) -> float:
        """Returns the x coordinate of the tool, m: the product of the Denavit-Hartenberg transforms."""
        pose = np.eye(4)
        for joint, q in zip(self._joints, self.q, strict=True):
            assert joint.denavit_hartenberg is not None
            d, a = joint.denavit_hartenberg.d_m, joint.denavit_hartenberg.a_m
            alpha, theta = joint.denavit_hartenberg.alpha_rad, joint.denavit_hartenberg.theta_rad + q
            (ca, sa), (ct, st) = (np.cos(alpha), np.sin(alpha)), (np.cos(theta), np.sin(theta))
            link = [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]]
            pose = pose @ np.array(link)
        return float(pose[0, 3])

    def wrench(self) -> NDArray[np.float64]:
        depth = self._tool_x() - self._start_m - (self._wall.offset_m or 0.0)
        return np.array([max(self._wall.stiffness * depth, 0.0), 0, 0, 0, 0, 0])

    def periods(self) -> Iterator[dict[str, Any]]:
        """Yields the measured state of each period."""
        for _ in range(round(DURATION_S / self.period_s)):
            yield {"joint_position": self.q, "joint_velocity": self.qdot, "wrench": self.wrench()}

    def advance(self, command: NDArray[np.float64]) -> None:
        self.qdot = command
        self.q = self.q + self.period_s * command


def simulated(client: Client) -> dict[str, NDArray[Any]]:
    """Returns the trace of the built-in simulator."""
    run = client.simulate(scenario=scenario(client))
    run.result()
    return run.trace()


def assert_same_run(states: list[dict[str, Any]], trace: dict[str, NDArray[Any]]) -> None:
    forces = np.array([state["wrench"][0] for state in states])
    positions = np.array([state["joint_position"] for state in states])
    assert (forces > 10).any()
    np.testing.assert_allclose(forces, trace["force_x_n"], atol=1e-6)
    for joint in range(positions.shape[1]):
        np.testing.assert_allclose(positions[:, joint], trace[f"position_j{joint + 1}_rad"], atol=1e-9)
