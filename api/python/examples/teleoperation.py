"""A simulated hand leads a simulated arm: streamed targets with jitter, noise and drop-outs.

    python teleoperation.py

The controller runs in this process, or in the service of `--url` or `REVPRIO_URL`. The hand sends its position at 30,
60 and 90 Hz. The control loop runs at 250 Hz, in simulated time. The program prints how well the arm follows, how much
the commands change, and when the tool is at rest after a drop-out.
"""

import argparse
import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import revprio
from revprio import (
    Client,
    ConstantProfile,
    Controller,
    ControllerTask,
    Local,
    PoseLaw,
    PostureLaw,
    StepAnswer,
    StreamedPose,
    StreamedTarget,
    Streaming,
)

PERIOD_S = 0.004
"""Control period T, s."""
LAG_S = 0.01
"""Lag from commanded to actual joint velocity, s; commands also arrive one period late."""
POSTURE = [0.3, -0.6, 0.2, 1.4, 0.1, 0.9, 0.0]
"""Start of the arm, rad."""
SIZE_M = 0.06
"""Size of the motion of the hand, m."""
NOISE_M = 3e-4
"""Standard deviation of the measured hand position, m."""
LATENCY_S = 0.01
"""Mean time from the measurement of the hand to the control loop, s."""
DROP_OUT_S = (3.0, 3.8)
"""Interval in which no target arrives, s."""

Array = NDArray[np.float64]
Target = tuple[float, StreamedTarget]
"""Time of arrival, s, and target."""


def hand(time_s: float) -> Array:
    """Returns the displacement of the hand from its start, m: at rest at first, then a figure of eight."""
    phase = 2.0 * max(time_s - 0.5, 0.0)
    grow = 1 - np.exp(-phase)
    eight = np.array([0.5 * np.sin(phase), np.sin(phase), np.sin(2 * phase)])
    return np.asarray(SIZE_M * grow * eight)


def targets(start: Array, rate_hz: float, duration_s: float) -> list[Target]:
    """Returns the targets that the hand sends, by time of arrival."""
    random = np.random.default_rng(int(rate_hz))
    sent: list[Target] = []
    time_s = 0.0
    while time_s < duration_s:
        time_s += (1 + random.uniform(-0.3, 0.3)) / rate_hz
        arrival_s = time_s + random.uniform(0, 2 * LATENCY_S)
        position = start + hand(time_s) + random.normal(scale=NOISE_M, size=3)
        is_lost = random.uniform() < 0.05 or DROP_OUT_S[0] <= time_s < DROP_OUT_S[1]
        if not is_lost:
            sent.append((arrival_s, StreamedTarget(time_s=time_s, pose=StreamedPose(position=position))))
    return sorted(sent, key=lambda target: target[0])


class Arm:
    """An arm whose joints follow their commands with a lag, one period late."""

    def __init__(self) -> None:
        """Starts at rest."""
        self.position = np.array(POSTURE)
        self.velocity = np.zeros(len(POSTURE))
        self.command = np.zeros(len(POSTURE))

    def move(self, command: Array) -> None:
        """Moves over one period; the new command acts from the next one."""
        self.velocity += (1 - np.exp(-PERIOD_S / LAG_S)) * (self.command - self.velocity)
        self.position += PERIOD_S * self.velocity
        self.command = command


@dataclass
class Run:
    """What the arm did."""

    time_s: Array
    error_m: Array
    """Distance between tool and hand, m."""
    command: Array
    """Commanded joint velocities, one row per period, rad/s."""
    tool_speed: Array
    """Commanded speed of the tool, m/s."""
    states: list[str]
    """Where the target of each period came from."""
    last_target_s: float
    """Time of the last target before the drop-out, s."""

    def error_mm(self) -> float:
        """Returns the root mean square of the error without the drop-out and the second after it, mm."""
        counts = (self.time_s > 1.5) & ((self.time_s < DROP_OUT_S[0]) | (self.time_s > DROP_OUT_S[1] + 1))
        return float(1e3 * np.sqrt(np.mean(self.error_m[counts] ** 2)))

    def acceleration(self) -> float:
        """Returns the root mean square of the joint accelerations of the commands, rad/s²."""
        return float(np.sqrt(np.mean((np.diff(self.command, axis=0) / PERIOD_S) ** 2)))

    def rest_s(self) -> float:
        """Returns the time from the last target before the drop-out until the tool is slower than 2 mm/s, s."""
        within = (self.time_s >= self.last_target_s) & (self.time_s < DROP_OUT_S[1])
        moving = self.time_s[within & (self.tool_speed > 2e-3)]
        return float(moving[-1] + PERIOD_S - self.last_target_s)


def controller(client: Client | Local, streaming: Streaming) -> Controller:
    """Starts a controller: the tool follows the hand, and the joints stay near their start."""
    follow = PoseLaw(gain=8)
    stay = PostureLaw(gain=1, target_position=ConstantProfile(value=POSTURE))
    return client.session(
        robot="sawyer_dh",
        period_s=PERIOD_S,
        limits="position_velocity_acceleration",
        tasks=[
            ControllerTask(name="hand", axes=["x", "y", "z"], law=follow, streaming=streaming),
            ControllerTask(name="posture", law=stay),
        ],
    )


def run(client: Client | Local, rate_hz: float, streaming: Streaming, duration_s: float) -> Run:
    """Lets the arm follow the hand for `duration_s`."""
    arm = Arm()
    start = position(client, arm)
    waiting = targets(start, rate_hz, duration_s)
    last_s = max(target.time_s or 0.0 for _, target in waiting if (target.time_s or 0.0) < DROP_OUT_S[0])
    recorded: list[tuple[float, Array, StepAnswer]] = []
    with controller(client, streaming) as loop:
        for number in range(round(duration_s / PERIOD_S)):
            time_s = number * PERIOD_S
            arrived = [target for arrival_s, target in waiting if arrival_s <= time_s]
            waiting = waiting[len(arrived) :]
            newest = {"hand": arrived[-1]} if arrived else None
            answer = loop.step(arm.position, joint_velocity=arm.velocity, time_s=time_s, targets=newest)
            recorded.append((time_s, arm.position.copy(), answer))
            arm.move(answer.joint_velocity)
    # The tool position of every fifth period is enough for the error.
    compared = recorded[::5]
    errors = [np.linalg.norm(position(client, q) - start - hand(time_s)) for time_s, q, _ in compared]
    all_times = np.array([time_s for time_s, *_ in recorded])
    answers = [answer for *_, answer in recorded]
    return Run(
        time_s=all_times,
        error_m=np.interp(all_times, [time_s for time_s, *_ in compared], errors),
        command=np.array([answer.joint_velocity for answer in answers]),
        tool_speed=np.array([np.linalg.norm(answer.tasks[0].achieved) for answer in answers]),
        states=[answer.tasks[0].target_state or "none" for answer in answers],
        last_target_s=last_s,
    )


def position(client: Client | Local, arm: Arm | Array) -> Array:
    """Returns the position of the tool, m."""
    posture = arm.position if isinstance(arm, Arm) else arm
    return np.asarray(client.kinematics(robot="sawyer_dh", joint_position=posture).pose.position)


def main() -> dict[tuple[str, float], Run]:
    """Runs all rates, with the default settings and without interpolation, and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--url", default=os.environ.get("REVPRIO_URL"), help="address of a service; default: none")
    parser.add_argument("--duration", type=float, default=8.0, help="simulated time, s")
    parser.add_argument("--rates", type=float, nargs="+", default=[30.0, 60.0, 90.0], help="targets per second")
    arguments = parser.parse_args()
    settings = {
        "default": Streaming(),
        "delay of one interval": None,
        "last target only": Streaming(hold_after_s=0, smoothing_s=0, max_velocity=100, max_acceleration=1e6),
    }
    runs: dict[tuple[str, float], Run] = {}
    print("                        rate  error  acceleration  at rest after")
    print("settings                (Hz)   (mm)       (rad/s²)            (s)")
    with revprio.connect(arguments.url, timeout_s=60, step_timeout_s=60) as client:
        for name, streaming in settings.items():
            for rate_hz in arguments.rates:
                chosen = streaming or Streaming(delay_s=round(1 / rate_hz + LATENCY_S, 3))
                result = run(client, rate_hz, chosen, arguments.duration)
                runs[name, rate_hz] = result
                print(
                    f"{name:<22} {rate_hz:5.0f} {result.error_mm():6.1f} {result.acceleration():14.1f}"
                    f" {result.rest_s():14.2f}"
                )
    return runs


if __name__ == "__main__":
    main()
