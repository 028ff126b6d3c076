"""Writes hierarchies of 35 joints and levels of 12, 6, 6 and 8 equations within limits: python hierarchies.py FILE.

The first 100 problems are independent, the other 1000 follow each other at 1 kHz. A problem is a row of numbers, 64-bit
little-endian: lower (35), upper (35), the rows of all levels (32 x 35), their velocities (32), and the solution (35).
Each row has length one, because DAQP divides rows by their length, and sees about half of the joints, as the limbs of
a humanoid do. Limits are active in most problems.

The solution is exact: a cascade of quadratic programs nearly finds the active limits, lexicographic least squares by
singular values on them gives the digits (fixtures/golden/make, cascade.py and oracle.py), and multipliers prove every
level optimal.
"""
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import lsq_linear

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / 'fixtures/golden/make'))
import oracle  # noqa: E402
from cascade import optimum  # noqa: E402

JOINTS, ROWS = 35, [12, 6, 6, 8]
INDEPENDENT, PERIODS = 100, 1000
ENDS = np.cumsum([0, *ROWS])
rng = np.random.default_rng(77)


def unit(rows):
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def random_rows():
    """Rows of the floating base and of the joints of one side of the body."""
    joints = np.arange(JOINTS)
    side = rng.integers(2, size=(sum(ROWS), 1))
    return unit(np.where((joints < 6) | (joints % 2 == side), rng.normal(size=(sum(ROWS), JOINTS)), 0.0))


def levels(A, b):
    """The levels as (rows, velocities), and last the smallest speed."""
    parts = [(A[start:end], b[start:end]) for start, end in zip(ENDS, ENDS[1:])]
    return [*parts, (np.eye(JOINTS), np.zeros(JOINTS))]


def unlimited(A, b):
    return oracle.lex_ls(levels(A, b), [], {}, JOINTS)


def solution(A, b, limit):
    """The exact solution: the active limits of the cascade change until the point on them is optimal.

    This rule can run in circles; then the solution is `nan`.
    """
    stack = levels(A, b)
    near, _ = optimum(-limit, limit, [(rows, target, target) for rows, target in stack])
    held = {j: np.sign(near[j]) * limit[j] for j in range(JOINTS) if abs(near[j]) > limit[j] - 1e-6}
    for _ in range(50):
        x = oracle.lex_ls(stack, list(held), held, JOINTS)
        outside = np.argmax(abs(x) - limit)
        if abs(x[outside]) > limit[outside] + 1e-12:
            held[outside] = np.sign(x[outside]) * limit[outside]
            continue
        wrong = inward(stack, x, held)
        if wrong is None:
            return np.clip(x, -limit, limit)
        del held[wrong]
    return np.full(JOINTS, np.nan)


def inward(stack, x, held):
    """The held joint that the highest level wants to move inwards most, or None if every level is optimal.

    A level is optimal if its steepest descent is a sum of outward directions of held joints and of rows of higher levels.
    """
    outward = np.eye(JOINTS)[:, list(held)] * np.sign(list(held.values()))
    higher = np.zeros((JOINTS, 0))
    for rows, target in stack:
        descent = rows.T @ (target - rows @ x)
        columns = np.hstack([higher, outward])
        bounds = ([-np.inf] * higher.shape[1] + [0] * len(held), np.inf)
        rest = -lsq_linear(columns, descent, bounds, tol=1e-14, method='bvls').fun if columns.size else descent
        if np.linalg.norm(rest) > 1e-10:
            return list(held)[np.argmin(outward.T @ rest)]
        higher = np.hstack([higher, rows.T])
    return None


def problem(A, b, limit):
    return np.concatenate([-limit, limit, A.ravel(), b, solution(A, b, limit)])


problems, bases = [], []
for i in range(INDEPENDENT):
    A, b = random_rows(), 0.13 * rng.normal(size=sum(ROWS))
    bases.append((A, b))
    speed = abs(unlimited(A, b)).max()
    problems.append(problem(A, b, speed * [1.7, 0.8, 0.6, 0.45][i % 4] * rng.uniform(0.8, 1.2, JOINTS)))
(A, b), (other_A, other_b) = bases[:2]
limit = np.full(JOINTS, 0.6 * abs(unlimited(A, b)).max())
for i in range(PERIODS):
    t = i * 1e-3
    turned = b * np.cos(6 * t) + other_b * np.sin(6 * t)
    problems.append(problem(unit(A + 0.2 * t * other_A), turned, limit))
problems = np.array(problems, dtype='<f8')
problems.tofile(sys.argv[1])
exact = problems[~np.isnan(problems[:, -1])]
held = np.sum(abs(exact[:, -JOINTS:]) == exact[:, JOINTS:2 * JOINTS], axis=1)
print(f'{len(problems)} hierarchies, {len(exact)} with an exact solution; {np.mean(held):.1f} active limits on average, '
      f'none in {np.mean(held == 0):.0%}')
