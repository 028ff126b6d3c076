"""An exact reference for the tests of check.py: hierarchies of up to four unknowns, with their multipliers and certificates.

A working set holds some unknowns and inequality rows at bounds. On it, each level is a least-squares problem without limits. The
right working set is the one whose optimality conditions hold; it is found by enumeration.
"""

from fractions import Fraction
from itertools import product


def dot(a, x):
    """Returns a·x."""
    return sum(p * q for p, q in zip(a, x))


def combine(vectors, weights, n):
    """Returns the sum of weights times vectors."""
    return [sum((weight * vector[j] for weight, vector in zip(weights, vectors)), Fraction(0)) for j in range(n)]


def eliminate(matrix, right):
    """Solves a consistent system; returns a solution and a basis of the null space."""
    count = len(matrix[0]) if matrix else 0
    rows, pivots = [[*row, value] for row, value in zip(matrix, right)], []
    for j in range(count):
        place = next((i for i in range(len(pivots), len(rows)) if rows[i][j]), None)
        if place is None:
            continue
        top = len(pivots)
        rows[top], rows[place] = rows[place], rows[top]
        rows[top] = [entry / rows[top][j] for entry in rows[top]]
        for i, row in enumerate(rows):
            if i != top and row[j]:
                rows[i] = [a - row[j] * b for a, b in zip(row, rows[top])]
        pivots.append(j)
    solution = [Fraction(0)] * count
    for i, j in enumerate(pivots):
        solution[j] = rows[i][-1]
    basis = []
    for free in (j for j in range(count) if j not in pivots):
        vector = [Fraction(int(j == free)) for j in range(count)]
        for i, j in enumerate(pivots):
            vector[j] = -rows[i][free]
        basis.append(vector)
    return solution, basis


def least_squares(rows, targets, basis):
    """Returns the weights of the basis vectors with the least residual, and the basis that leaves the residual as it is."""
    images = [[dot(row, vector) for row in rows] for vector in basis]
    normal = [[dot(a, b) for b in images] for a in images]
    weights, null = eliminate(normal, [dot(image, targets) for image in images])
    n = len(basis[0]) if basis else 0
    return weights, [combine(basis, vector, n) for vector in null]


def on_working_set(problem, held, active):
    """Returns x, the residuals of the active rows, and the multipliers of each level: {row: w} and h, or None."""
    box, levels, zeta = problem["box"], problem["levels"], problem["reference"]
    n = len(box)
    x = [box[j][side > 0] if side else Fraction(0) for j, side in enumerate(held)]
    basis, bases = [[Fraction(int(i == j)) for i in range(n)] for j in range(n) if not held[j]], []
    rows, place = [], 0
    for level in levels:
        own = []
        for a, low, high in level:
            if low == high or active[place]:
                own.append((place, a, low if low == high or active[place] < 0 else high))
            place += 1
        bases.append(basis)
        if own and basis:
            weights, rest = least_squares([a for _, a, _ in own], [b - dot(a, x) for _, a, b in own], basis)
            x = [p + q for p, q in zip(x, combine(basis, weights, n))]
            basis = rest
        rows.append(own)
    if basis:
        images = [[dot(a, b) for b in basis] for a in basis]
        weights, _ = eliminate(images, [dot(a, [p - q for p, q in zip(zeta, x)]) for a in basis])
        x = [p + q for p, q in zip(x, combine(basis, weights, n))]
    multipliers = []
    for k in range(len(levels) + 1):
        own = {i: b - dot(a, x) for i, a, b in rows[k]} if k < len(levels) else {}
        gradient = [p - q for p, q in zip(zeta, x)] if k == len(levels) else combine([a for _, a, _ in rows[k]], own.values(), n)
        if not any(own.values()) and k < len(levels) or k == len(levels) and not any(gradient):
            multipliers.append(None)
            continue
        w = dict(own)
        for j in reversed(range(k)):  # The shortest multipliers of level j that cancel the gradient on its basis.
            if bases[j] and rows[j]:
                images = [[dot(a, vector) for _, a, _ in rows[j]] for vector in bases[j]]
                normal = [[dot(a, b) for b in images] for a in images]
                weights, _ = eliminate(normal, [-dot(vector, gradient) for vector in bases[j]])
                own = combine(images, weights, len(rows[j]))
                w |= {i: value for (i, _, _), value in zip(rows[j], own)}
                gradient = [p + q for p, q in zip(gradient, combine([a for _, a, _ in rows[j]], own, n))]
        multipliers.append((w, gradient))
    return x, multipliers


def is_right(problem, held, active, x, multipliers):
    """Returns whether the conditions of docs/solver.md, section 2, hold."""
    rows = [row for level in problem["levels"] for row in level]
    inside = lambda value, low, high: (low is None or low <= value) and (high is None or value <= high)
    if not all(inside(value, *ends) for value, ends in zip(x, problem["box"])):
        return False
    if not all(side or low == high or inside(dot(a, x), low, high) for (a, low, high), side in zip(rows, active)):
        return False
    first = lambda values: next((value for value in values if value), 0)
    given = [pair for pair in multipliers if pair]
    for j, side in enumerate(held):
        if side and problem["box"][j][0] != problem["box"][j][1] and side * first(h[j] for _, h in given) < 0:
            return False
    return all(side * first(w.get(i, 0) for w, _ in given) <= 0 for i, side in enumerate(active) if side)


def solve(problem):
    """Returns x and the multipliers of the right working set; the best guesses are tried first."""
    rows = [row for level in problem["levels"] for row in level]
    sides = lambda low, high: [side for side, end in ((0, 0), (-1, low), (1, high)) if end is not None]
    choices = [[1] if low is not None and low == high else sides(low, high) for low, high in problem["box"]]
    choices += [[0] if low == high else sides(low, high) for _, low, high in rows]
    n = len(problem["box"])
    for chosen in sorted(product(*choices), key=lambda chosen: sum(map(abs, chosen))):
        x, multipliers = on_working_set(problem, chosen[:n], chosen[n:])
        if is_right(problem, chosen[:n], chosen[n:], x, multipliers):
            return x, multipliers
    raise AssertionError("no working set is right")


def certificate(problem, names, x, multipliers):
    """Returns a problem of a certificate, rounded to doubles."""
    number = lambda value: None if value is None else float(value)
    ends, count = [], 0
    for level in problem["levels"]:
        count += len(level)
        ends.append(count)
    return {
        "lower": [number(low) for low, _ in problem["box"]],
        "upper": [number(high) for _, high in problem["box"]],
        "reference": list(map(float, problem["reference"])),
        "levels": [{"rows": [list(map(float, a)) for a, _, _ in level], "lower": [number(low) for _, low, _ in level],
                    "upper": [number(high) for _, _, high in level], "names": names[k]}
                   for k, level in enumerate(problem["levels"])],
        "solution": list(map(float, x)),
        "multipliers": [pair and {"rows": [float(pair[0].get(i, 0)) for i in range(end)], "unknowns": list(map(float, pair[1]))}
                        for pair, end in zip(multipliers, ends + [count])],
    }
