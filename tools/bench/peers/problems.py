"""Writes 200 resolution problems with exact answers, and the arm: python problems.py PROBLEMS ARM.

The columns of a row are q (7), xdot (6: x, y, z, rx, ry, rz at the tool, base axes), limit (7: -limit <= qdot <= limit),
the closed-form solution (7) and the solution within the limits (7). The arm is fixtures/robots/sawyer.urdf. Task 1 is
x, task 2 has the other five rows. Limits are active in half of the problems. The exact solutions come from an
enumeration of all 3^7 active sets (fixtures/golden/make/oracle.py).
"""
import sys
from pathlib import Path

import numpy as np
import pinocchio

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / 'fixtures/golden/make'))
import oracle  # noqa: E402

rng = np.random.default_rng(11)
model = pinocchio.buildModelFromUrdf(str(ROOT / 'fixtures/robots/sawyer.urdf'))
data, frame = model.createData(), model.getFrameId('tool')
rows = []
while len(rows) < 200:
    q = rng.uniform(0.9 * model.lowerPositionLimit, 0.9 * model.upperPositionLimit)
    pinocchio.framesForwardKinematics(model, data, q)
    J = pinocchio.computeFrameJacobian(model, data, q, frame, pinocchio.LOCAL_WORLD_ALIGNED)
    if np.linalg.svd(J, compute_uv=False)[-1] < 0.05:
        continue
    xdot = 0.2 * rng.normal(size=6)
    tasks, velocities = [J[:1], J[1:]], [xdot[:1], xdot[1:]]
    closed = oracle.rp_closed(tasks, velocities)
    factor = rng.uniform(0.4, 0.8) if len(rows) % 2 else 1.7
    limit = abs(closed).max() * factor * rng.uniform(0.8, 1.2, 7)
    exact, _ = oracle.rp_box(tasks, velocities, -limit, limit)
    rows.append(','.join(repr(float(value)) for value in (*q, *xdot, *limit, *closed, *exact)))
Path(sys.argv[1]).write_text('\n'.join(rows) + '\n')

# The arm for programs without a URDF reader. Each joint has one row and rotates about z; the last row is the tool. A row
# is the rotation matrix, row by row, then the position, both in the frame of the row before.
placements = [model.jointPlacements[joint] for joint in range(1, model.njoints)] + [model.frames[frame].placement]
numbers = [[*placement.rotation.ravel(), *placement.translation] for placement in placements]
Path(sys.argv[2]).write_text('\n'.join(','.join(repr(float(value)) for value in row) for row in numbers) + '\n')
print(f'{len(rows)} problems')
