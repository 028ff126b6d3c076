"""Compares the distances of shapes with those of Coal: `distances.py PROGRAM`; needs NumPy and Coal of PyPI.

    cargo build --release --locked -p revprio-robot --example distances
    python3 -m venv target/distances && target/distances/bin/pip install coal==3.0.3 numpy==2.4.6
    target/distances/bin/python tools/check/distances.py target/release/examples/distances

Both programs find points of both shapes, so of two distances the smaller one is nearer to the truth. Fails if a distance
is larger than Coal's by more than 1e-9 m, or, except for nearly parallel capsules, smaller.
"""
import subprocess
import sys

import coal
import numpy as np

PAIRS = 20_000
TOLERANCE_M = 1e-9
PARALLEL = 'capsule, capsule, nearly parallel'
KINDS = (
    'sphere, sphere', 'capsule, sphere', 'capsule, capsule', PARALLEL, 'sphere, box', 'capsule, box',
    'capsule, half-space',
)


def rotation(random):
    """A random rotation, 3 × 3."""
    w, x, y, z = (quaternion := random.normal(size=4)) / np.linalg.norm(quaternion)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


class Capsule:
    """A capsule or, without length, a sphere, in a random place of a cube of 2 m."""

    def __init__(self, random, is_sphere, along=None):
        self.radius, self.turn = random.uniform(0.01, 0.2), rotation(random)
        self.half = 0.0 if is_sphere else random.uniform(0.01, 0.4)
        self.middle = random.uniform(-1, 1, size=3)
        if along is not None:
            self.turn = along

    def coal(self):
        shape = coal.Capsule(self.radius, 2 * self.half) if self.half else coal.Sphere(self.radius)
        return shape, coal.Transform3s(self.turn, self.middle)

    def numbers(self):
        way = self.half * self.turn[:, 2]
        return [*(self.middle - way), *(self.middle + way), self.radius]


class Box:
    """A box in a random place of a cube of 2 m."""

    def __init__(self, random):
        self.half, self.turn = random.uniform(0.02, 0.5, size=3), rotation(random)
        self.middle = random.uniform(-1, 1, size=3)

    def coal(self):
        return coal.Box(*(2 * self.half)), coal.Transform3s(self.turn, self.middle)

    def numbers(self):
        return [*self.middle, *self.turn.ravel(), *self.half]


class HalfSpace:
    """All points behind a random plane."""

    def __init__(self, random):
        normal = random.normal(size=3)
        self.normal, self.offset = normal / np.linalg.norm(normal), random.uniform(-1, 1)

    def coal(self):
        return coal.Halfspace(self.normal, self.offset), coal.Transform3s.Identity()

    def numbers(self):
        return [*self.normal, self.offset]


def pair(random, kind):
    """Two shapes. A fifth of those that are nearly parallel are exactly parallel."""
    one, other = kind.split(', ')[:2]
    first = Capsule(random, one == 'sphere')
    if other == 'box':
        return first, Box(random)
    if other == 'half-space':
        return first, HalfSpace(random)
    along = None
    if kind == PARALLEL:
        small = 10 ** random.uniform(-14, -1) * (random.uniform() < 0.8)
        along = first.turn @ np.array([[np.cos(small), 0, np.sin(small)], [0, 1, 0], [-np.sin(small), 0, np.cos(small)]])
    return first, Capsule(random, other == 'sphere', along)


def line(first, second):
    kind = {Capsule: 'capsule', Box: 'box', HalfSpace: 'half_space'}[type(second)]
    return ' '.join([kind, *(repr(float(number)) for number in [*first.numbers(), *second.numbers()])])


def coals(first, second, request):
    result = coal.DistanceResult()
    return coal.distance(*first.coal(), *second.coal(), request, result)


def main():
    random = np.random.default_rng(0)
    # Coal's search ends at these tolerances; its formulas for spheres and capsules need none.
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-14
    request.gjk_max_iterations = request.epa_max_iterations = 1000
    is_right = True
    print(f'{PAIRS} pairs of each kind. Largest part by which a distance is larger or smaller than that of Coal'
          f' {coal.__version__}, m')
    head = [f'{which}: {what}' for which in ('apart', 'overlap', 'cores overlap') for what in ('pairs', 'larger', 'smaller')]
    print(f'| shapes | {" | ".join(head)} |\n| --- | {" | ".join(["---:"] * len(head))} |')
    for kind in KINDS:
        pairs = [pair(random, kind) for _ in range(PAIRS)]
        text = '\n'.join(line(*each) for each in pairs)
        output = subprocess.run([sys.argv[1]], input=text, check=True, capture_output=True, text=True).stdout
        ours, theirs = np.array([float(word) for word in output.split()]), np.array([coals(*p, request) for p in pairs])
        radii = np.array([first.radius + getattr(second, 'radius', 0.0) for first, second in pairs])
        apart, cores = ours > 0, ours > -radii
        cells = [kind]
        for chosen in (apart, ~apart & cores, ~cores):
            larger = np.where(chosen, ours - theirs, 0)
            cells += [str(chosen.sum()), *(f'{max(part.max(), 0) + 0.0:.1e}' for part in (larger, 0 - larger))]
        print(f'| {" | ".join(cells)} |')
        wrong = np.where(cores, ours - theirs if kind == PARALLEL else np.abs(ours - theirs), 0) > TOLERANCE_M
        is_right &= not wrong.any()
        for number in np.flatnonzero(wrong)[:3]:
            print(f'  {line(*pairs[number])}: {ours[number]}, Coal {theirs[number]}', file=sys.stderr)
    sys.exit(0 if is_right else 1)


if __name__ == '__main__':
    main()
