"""What `characteristic_length_m` trades: the error of the position against that of the orientation.

A simulated UR5e with a lag of 30 ms and a dead time of two periods follows a figure faster than its limits allow, and
keeps its orientation. One task has all six rows, so they share what the joints can give.

    python position_and_tilt.py --figure position-and-tilt.png
"""

import argparse
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import revprio

Vector = NDArray[np.float64]

PERIOD_S, LAG_S, DELAY_PERIODS = 0.008, 0.03, 2
START = np.array([0.3, -1.2, 1.6, -1.9, -1.57, 0.2])
AMPLITUDE = np.array([0.12, 0.18, 0.12])
LENGTHS = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0)


def fastest(times: Vector) -> float:
    """Returns the largest speed of the figure for ω = 1 rad/s, m/s."""
    phases = np.multiply.outer([1, 2, 3], times)
    return float(np.linalg.norm(AMPLITUDE[:, None] * np.array([1, 2, 3])[:, None] * np.cos(phases), axis=0).max())


def follow(length_m: float, speed_m_s: float, seconds: float = 12.0) -> tuple[float, float]:
    """Returns the RMS errors of position (mm) and orientation (rad) while the tool follows the figure."""
    start = revprio.kinematics(robot="ur5e", joint_position=START).pose
    centre, omega = np.asarray(start.position), speed_m_s / fastest(np.linspace(0, 2 * math.pi, 4000))

    def target(time_s: float) -> Vector:
        share = min(time_s / 2, 1.0)
        blend = share * share * (3 - 2 * share)
        point: Vector = centre + blend * AMPLITUDE * np.sin(omega * np.array([1, 2, 3]) * time_s)
        return point

    axes: list[revprio.Axis] = ["x", "y", "z", "rx", "ry", "rz"]
    task = revprio.ControllerTask(name="hand", axes=axes, law=revprio.PoseLaw(gain=5))
    q, velocity, pending = START.copy(), np.zeros(6), [np.zeros(6)] * DELAY_PERIODS
    remaining = math.exp(-PERIOD_S / LAG_S)
    distances, tilts = [], []
    with revprio.Controller(robot="ur5e", period_s=PERIOD_S, tasks=[task], characteristic_length_m=length_m) as arm:
        for number in range(int(seconds / PERIOD_S)):
            now = number * PERIOD_S
            pose = revprio.StreamedPose(position=target(now), orientation=start.orientation)
            targets = {"hand": revprio.StreamedTarget(pose=pose)} if number % 3 == 0 else None
            pending.append(arm.step(q, targets=targets).joint_velocity)
            command = pending.pop(0)
            q = q + PERIOD_S * command + LAG_S * (velocity - command) * (1 - remaining)
            velocity = command + (velocity - command) * remaining
            if now > 3.0:
                tool = revprio.kinematics(robot="ur5e", joint_position=q).pose
                distances.append(np.linalg.norm(np.asarray(tool.position) - target(now + PERIOD_S)))
                parts = [getattr(tool.orientation, part) * getattr(start.orientation, part) for part in "wxyz"]
                tilts.append(2 * math.acos(min(1.0, abs(sum(parts)))))
    return 1e3 * float(np.sqrt(np.mean(np.square(distances)))), float(np.sqrt(np.mean(np.square(tilts))))


def draw(rows: list[tuple[float, float, float]], speed_m_s: float, path: Path) -> None:
    """Draws both errors over the length."""
    from matplotlib.figure import Figure  # noqa: PLC0415

    lengths, distances, tilts = zip(*rows, strict=True)
    figure = Figure(figsize=(7, 3.2), layout="constrained")
    left = figure.subplots()
    right = left.twinx()
    left.semilogx(lengths, distances, "o-", color="tab:blue")
    right.semilogx(lengths, tilts, "s--", color="tab:orange")
    left.set_xlabel("characteristic_length_m (m)")
    left.set_ylabel("error of the position, RMS (mm)", color="tab:blue")
    right.set_ylabel("error of the orientation, RMS (rad)", color="tab:orange")
    left.set_title(f"UR5e, a figure at up to {speed_m_s} m/s, faster than its limits allow")
    left.set_ylim(bottom=0)
    right.set_ylim(bottom=0)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Prints the table and draws the figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--figure", type=Path, help="file of the figure (png or svg); needs matplotlib")
    parser.add_argument("--speed", type=float, default=0.95, help="largest speed of the figure, m/s")
    arguments = parser.parse_args()
    rows = []
    print("length (m)  position (mm)  tilt (rad)")
    for length_m in LENGTHS:
        distance, tilt = follow(length_m, arguments.speed)
        rows.append((length_m, distance, tilt))
        print(f"{length_m:10.2f}  {distance:13.1f}  {tilt:10.3f}", flush=True)
    if arguments.figure:
        draw(rows, arguments.speed, arguments.figure)


if __name__ == "__main__":
    main()
