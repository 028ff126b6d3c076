"""Writes 200 problems with exact answers, a trajectory, and the arm: python problems.py PROBLEMS TRAJECTORY ARM.

The columns of a row are q (7), xdot (6: x, y, z, rx, ry, rz at the tool, base axes), limit (7: -limit <= qdot <= limit),
the closed-form solution (7) and the solution within the limits (7). The arm is fixtures/robots/sawyer.urdf. Task 1 is
x, task 2 has the other five rows. Limits are active in half of the problems. The exact solutions come from an
enumeration of all 3^7 active sets (fixtures/golden/make/oracle.py).

The trajectory has the same columns: one second at 1 kHz, limits active most of the time, and solutions for every 25th
row, `nan` for the others.
"""
import sys
from pathlib import Path

import numpy as np
import pinocchio

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / 'fixtures/golden/make'))
import oracle  # noqa: E402

PERIODS = 1000
rng = np.random.default_rng(11)
model = pinocchio.buildModelFromUrdf(str(ROOT / 'fixtures/robots/sawyer.urdf'))
data, frame = model.createData(), model.getFrameId('tool')


def jacobian(q):
    pinocchio.framesForwardKinematics(model, data, q)
    return pinocchio.computeFrameJacobian(model, data, q, frame, pinocchio.LOCAL_WORLD_ALIGNED)


def closed_form(J, xdot):
    return oracle.rp_closed([J[:1], J[1:]], [xdot[:1], xdot[1:]])


def within_limits(J, xdot, limit):
    return oracle.rp_box([J[:1], J[1:]], [xdot[:1], xdot[1:]], -limit, limit)[0]


def write(path, rows):
    Path(path).write_text('\n'.join(','.join(repr(float(value)) for value in row) for row in rows) + '\n')


rows = []
while len(rows) < 200:
    q = rng.uniform(0.9 * model.lowerPositionLimit, 0.9 * model.upperPositionLimit)
    J = jacobian(q)
    if np.linalg.svd(J, compute_uv=False)[-1] < 0.05:
        continue
    xdot = 0.2 * rng.normal(size=6)
    closed = closed_form(J, xdot)
    factor = rng.uniform(0.4, 0.8) if len(rows) % 2 else 1.7
    limit = abs(closed).max() * factor * rng.uniform(0.8, 1.2, 7)
    rows.append((*q, *xdot, *limit, *closed, *within_limits(J, xdot, limit)))
write(sys.argv[1], rows)

# A slow swing around a regular posture, with a tool velocity whose direction turns.
posture = np.array([2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2])
limit = np.full(7, 0.35)
rows = []
for i in range(PERIODS):
    t = i / PERIODS
    q = posture + 0.1 * np.sin(t + np.arange(7))
    xdot = 0.15 * np.sin(2 * np.pi * t + np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0]))
    J = jacobian(q)
    solved = i % 25 == 0
    solutions = [closed_form(J, xdot), within_limits(J, xdot, limit)] if solved else np.full((2, 7), np.nan)
    rows.append((*q, *xdot, *limit, *np.concatenate(solutions)))
write(sys.argv[2], rows)
limited = sum(np.abs(row[27:34]).max() >= 0.35 - 1e-9 for row in rows[::25]) / len(rows[::25])

# The arm for programs without a URDF reader. Each joint has one row and rotates about z; the last row is the tool. A row
# is the rotation matrix, row by row, then the position, both in the frame of the row before.
placements = [model.jointPlacements[joint] for joint in range(1, model.njoints)] + [model.frames[frame].placement]
numbers = [[*placement.rotation.ravel(), *placement.translation] for placement in placements]
write(sys.argv[3], numbers)
print(f'200 problems; limits are active in {limited:.0%} of the trajectory')
