"""The service is killed in the middle of a run into the limits, and the watchdog keeps the arm inside its ranges."""

import numpy as np
import pytest
from numpy.typing import NDArray

from revprio import Client, Watchdog
from revprio.models import ControllerConfig
from revprio.remote import Session

PERIOD_S = 0.004
LATENCY_S = 0.7 * PERIOD_S


@pytest.mark.parametrize("limits", ["position_velocity", "position_velocity_acceleration"])
def test_an_arm_whose_service_is_killed_at_any_period_stops_inside_its_ranges(client: Client, limits: str) -> None:
    robot = client.robot("panda")
    lower, upper = np.array([joint.position_limit for joint in robot.joints], dtype=float).T
    law = {"kind": "posture", "gain": 100, "target_position": {"kind": "constant", "value": list(upper + 1)}}
    tasks = [{"name": "run", "law": law}]
    config = ControllerConfig.model_validate({"robot": "panda", "period_s": PERIOD_S, "limits": limits, "tasks": tasks})
    q, velocity = 0.5 * (lower + upper), np.zeros(7)
    watchdog = Watchdog.of(robot)
    nearest, shortest = np.inf, 100
    with Session(client, config) as session:
        for period in range(500):
            measured_s = period * PERIOD_S
            answer = session.step(q, time_s=measured_s)
            q = q + LATENCY_S * velocity
            assert watchdog.obey(answer, measured_s, measured_s + LATENCY_S)
            if period % 20 == 0:
                outside = furthest(watchdog, q, measured_s + LATENCY_S, lower, upper)
                assert outside <= 1e-6, (period, outside)
                nearest, shortest = min(nearest, -outside), min(shortest, answer.valid_for_ms)
            velocity = watchdog.command(measured_s + LATENCY_S + PERIOD_S)
            q = q + (PERIOD_S - LATENCY_S) * velocity
    assert nearest < 1e-3
    assert shortest < 20


Joints = NDArray[np.float64]


def furthest(watchdog: Watchdog, q: Joints, now_s: float, lower: Joints, upper: Joints) -> float:
    """Returns the largest distance outside the range if no answer comes any more; at rest it must end."""
    outside = -np.inf
    for tick in range(1000):
        velocity = watchdog.command(now_s + (tick + 1) * PERIOD_S)
        q = q + PERIOD_S * velocity
        outside = max(outside, float(np.max(np.maximum(q - upper, lower - q))))
    assert not velocity.any()
    return outside
