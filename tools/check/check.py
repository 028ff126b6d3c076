"""Checks that an answer of `POST /v1/resolve` is right: check.py REQUEST ANSWER [REQUEST ANSWER ...], or check.py LINES.

The request has `"certificate": true`. LINES is a file with one {"request": ..., "answer": ...} on each line. Prints the largest
relative error of each check. Exit status: 0 the certificate holds, 1 it does not, 2 the input cannot be read.

docs/certificate.md explains the conditions. This program shares no code with revprio. It computes with fractions, so all sums
and products are exact. Only the sizes that errors are compared with are rounded.
"""

import json
import multiprocessing
import sys
import time
from collections import namedtuple
from fractions import Fraction
from math import hypot, inf, isfinite
from operator import mul, sub
from pathlib import Path

TOLERANCE = 1e-9  # of a relative error, as the status `optimal` claims
FINE = 1e-4  # An error is rounding, too, below TOLERANCE * FINE of the coarse size, which contains all that was rounded.
ONE_LEVEL, LEVELS = ("pseudoinverse", "damped_least_squares"), ("strict_reverse_priority", "task_priority")  # methods
NOT_ZERO = 1e-14  # A multiplier above this part of its terms is not zero.
CHECKS = {  # name: (what is compared, tolerance)
    "status": ("the status belongs to `kkt_residual`", 0.0),
    "plan": ("problems and levels are those of the method, in its order", 0.0),
    "rows": ("rows, velocities, bounds and limits are those of the request", 1e-12),
    "stages": ("each problem starts where the one before ended, and keeps its lower tasks", TOLERANCE),
    "box": ("solutions are inside their box", TOLERANCE),
    "residuals": ("multipliers of a level are its residuals; without any, it is met", TOLERANCE),
    "sums": ("multipliers of unknowns are the sums of rows times multipliers", 1e-12),
    "unknowns": ("they are zero inside the box and have the right sign at a bound", TOLERANCE),
    "row signs": ("multipliers of higher inequality rows: the same", TOLERANCE),
    "velocity": ("`joint_velocity` is the sum of the solutions, moved into the box", 1e-12),
    "inside": ("`joint_velocity` is inside the limits, or these are listed as violated", 0.0),
    "achieved": ("`achieved` and `residual_norm` belong to `joint_velocity`", 1e-12),
    "active": ("active limits, rows and inequalities are reached and have their multipliers", TOLERANCE),
    "complete": ("no limit or row with a multiplier is left out of them", TOLERANCE)}
# key: (task, row), the name of an inequality, or None. A row of a request has None for what the request does not state.
Row = namedtuple("Row", "key a ends level is_kept", defaults=(None, False))


def numbers(value, count=None, what="a list", none=None):
    """Returns a list of finite numbers as fractions, with `none` in the place of null."""
    is_finite = [type(entry) in (int, float) and isfinite(entry) or none and entry is None for entry in value]
    if not all(is_finite) or count not in (None, len(value)):
        raise ValueError(f"{what}: not a list of {'' if count is None else count} finite numbers")
    return [none if entry is None else Fraction(entry) for entry in value]


def bounds_of(stated, what):
    """Returns the bounds (lower, upper) that a task, the limits or a problem states; infinite where it does not."""
    lower, upper = (stated.get("velocity") or stated.get(side) or [] for side in ("lower", "upper"))
    count = max(len(lower), len(upper))
    bounds = zip(numbers(lower or [None] * count, count, what, -inf), numbers(upper or [None] * count, count, what, inf))
    return [ends if ends[0] <= ends[1] else numbers(ends, what=f"{what}, a lower bound above its upper bound") for ends in bounds]


def relative(error, size):
    """Returns |error| / size."""
    return 0.0 if not error else abs(float(error)) / size if 0.0 < size < inf else inf


def difference(a, b, size):
    """Returns |a - b| / size, where bounds may be infinite."""
    return 0.0 if a == b else relative(a - b, size)


def excess(value, low, high):
    """Returns by how much a value is above its bounds (positive) or below them (negative)."""
    return value - low if value < low else value - high if value > high else 0


def dot(a, x):
    """Returns a·x."""
    return sum(map(mul, a, x))


def are_independent(rows):
    """Returns whether rows are linearly independent, by elimination."""
    for row in rows[-1:]:
        j = next((j for j, entry in enumerate(row) if entry), None)
        rest = [] if j is None else [[b - a * (other[j] / row[j]) for a, b in zip(row, other)] for other in rows[:-1]]
        return j is not None and are_independent(rest)
    return True


class Problem:
    """One hierarchical problem of a certificate."""

    def __init__(self, raw, what):
        self.x, self.rows, self.starts = numbers(raw["solution"]), [], [0]
        self.reference, self.box = numbers(raw["reference"], len(self.x), what), bounds_of(raw, what)
        for k, level in enumerate(raw["levels"]):
            for a, ends, name in zip(level["rows"], bounds_of(level, what), level["names"], strict=True):
                key = (name["task"], name["row"]) if "task" in name else name.get("inequality")
                self.rows.append(Row(key, numbers(a, len(self.x), what), ends, k))
            self.starts.append(len(self.rows))
        given = zip(raw["multipliers"], [*self.starts[1:], len(self.rows)], strict=True)
        self.multipliers = [pair and (numbers(pair["rows"], end), numbers(pair["unknowns"], len(self.x))) for pair, end in given]

    def levels(self, unless=()):
        """Returns the named rows level by level, without those of some tasks."""
        rows = [row for row in self.rows if row.key is not None and row.key[0] not in unless]
        return [level for k in range(len(self.starts)) if (level := [row for row in rows if row.level == k])]

    def check(self, note):
        """Checks the optimality of each level given those above it."""
        n, starts, last, norms = len(self.x), self.starts, len(self.starts) - 1, [hypot(*row.a) for row in self.rows]
        speed, values, zeta = hypot(*self.x), [dot(row.a, self.x) for row in self.rows], list(map(sub, self.reference, self.x))
        reach, level_norms, sizes, self.sizes = speed + hypot(*self.reference), [], [], [speed] * n
        for value, ends in zip(self.x, self.box, strict=True):
            note("box", relative(excess(value, *ends), speed))
        for k, pair in enumerate(self.multipliers[:-1]):
            own = range(starts[k], starts[k + 1])
            missing = [-excess(values[i], *self.rows[i].ends) for i in own]
            aim = hypot(*(values[i] + r for i, r in zip(own, missing) if r or self.rows[i].ends[0] == self.rows[i].ends[1]))
            level_norms.append(hypot(*(norms[i] for i in own)))
            reach = max(reach, aim / level_norms[k] if pair and level_norms[k] else 0.0)
            sizes.append(aim + level_norms[k] * reach)
            self.sizes += [norms[i] * speed + FINE * sizes[k] for i in own]
            for i, r in zip(own, missing):
                note("residuals", relative((pair[0][i] if pair else 0) - r, self.sizes[n + i]))
        note("residuals", 0.0 if self.multipliers[last] else relative(hypot(*zeta), reach))
        self.forces, proven = [[] for _ in self.x + self.rows], set()  # the multipliers of each unknown and row, level by level
        for k, (w, h) in ((k, pair) for k, pair in enumerate(self.multipliers) if pair):
            length, norm, coarse = (hypot(*zeta), 1.0, reach) if k == last else (hypot(*w[starts[k]:]), level_norms[k], sizes[k])
            amount = length * norm + sum(abs(w[i]) * level_norms[self.rows[i].level] for i in range(starts[k]))
            size = amount * (1.0 + FINE * coarse / length) if length else amount + coarse * norm
            bounds, proofs, wrong = [], set(), 0.0
            for j in range(n):
                terms = [entry * row.a[j] for entry, row in zip(w, self.rows)] + [zeta[j]] * (k == last)
                total, rounded = sum(terms), hypot(*terms, *[self.x[j]] * (k == last))
                note("sums", relative(h[j] - total, rounded))
                bounds.append(("unknowns", j, total, self.x[j], self.box[j]))
                self.forces[j].append((float(h[j]), size, rounded))
            for i, (entry, row) in enumerate(zip(w, self.rows)):
                if row.ends[0] != row.ends[1]:
                    bounds.append(("row signs" if row.level < k else None, n + i, -entry * norms[i], values[i], row.ends))
                    self.forces[n + i].append((-float(entry), size / (norms[i] or inf), amount / (norms[i] or inf)))
            for check, place, force, value, ends in bounds:
                side = 1 if force > 0 else -1
                away = relative(max(0, side * (ends[force > 0] - value)), self.sizes[place])
                if check and (place, -side) not in proven:  # Otherwise every optimum of a higher level is at the other bound.
                    note(check, min(relative(force, size), away))
                    wrong = max(wrong, abs(force) if away > TOLERANCE else 0.0)
                if away <= TOLERANCE and (check or abs(force) > NOT_ZERO * sizes[k] * norms[place - n]):
                    proofs.add((place, side, abs(force)))
            if wrong <= TOLERANCE * amount:  # Otherwise the multipliers are rounding, which proves nothing.
                proven |= {(place, side) for place, side, force in proofs if force > max(wrong, NOT_ZERO * amount)}


class Check:
    """The checks of one answer: `largest` relative error of each, `failed` ones, and `notes` on what is not checked."""

    def __init__(self, request, answer):
        self.request, self.answer, self.notes, self.largest = request, answer, {}, {}
        self.tasks = {task.get("name") or f"task {k + 1}": task for k, task in enumerate(request["tasks"])}
        self.hard = {row.get("name") or f"inequality {i + 1}": row for i, row in enumerate(request.get("inequalities") or [])}
        self.method, self.is_closed = request.get("method", "reverse_priority"), request.get("solver") == "closed_form"
        # A scaled task has rows without names; where all tasks are one level, all equations have.
        scales, is_one_level = any(task.get("scale") for task in self.tasks.values()), self.method in ONE_LEVEL
        self.scaled = [name for name, task in self.tasks.items()
                       if task.get("scale") or scales and is_one_level and task.get("velocity")]
        self.velocity, solver = numbers(answer["joint_velocity"]), answer["solver"]
        is_optimal = ["optimal", "not_certified", "failed"].index(solver["status"]) == 0
        certificate = answer.get("certificate") or {} if solver["status"] == "failed" else answer["certificate"]
        problems = [Problem(raw, f"problem {i}") for i, raw in enumerate(certificate.get("problems", []))]
        self.parts = [(problems[part["problem"]], Fraction(part["weight"])) for part in certificate.get("answer", [])]
        for problem in problems:
            problem.check(self.note)
        if self.parts:
            self.check_plan(problems)
            self.check_active()
        self.check_velocity()
        if is_optimal:
            self.note("status", solver["kkt_residual"] is None or solver["kkt_residual"] > TOLERANCE)
        else:
            self.notes[f"status `{solver['status']}`: only a finite velocity inside the limits is claimed"] = True
        self.failed = [check for check in (CHECKS if is_optimal else ["inside"]) if self.largest.get(check, 0.0) > CHECKS[check][1]]

    def note(self, check, error):
        """Keeps the largest error of a check."""
        self.largest[check] = max(self.largest.get(check, 0.0), float(error))

    def planned(self):
        """Returns the problems of the method as levels of rows, where the request states these."""
        rows, hard = [], []
        for name, task in self.tasks.items():
            ends, own = bounds_of(task, name), task.get("jacobian")
            if not self.is_closed or all(low == high for low, high in ends):
                given = [] if name in self.scaled else zip(map(numbers, own) if own else [None] * len(ends), ends, strict=True)
                rows.append([Row((name, i), a, b) for i, (a, b) in enumerate(given)])
        for name, given in {} if self.is_closed else self.hard.items():
            a, norm = given.get("coefficients"), hypot(*given.get("coefficients", [])) or 1.0
            hard.append(Row(name, [Fraction(c / norm) for c in a], (-inf, Fraction(given["upper"] / norm))) if a else Row(name, None, None))
        lower = [[row._replace(is_kept=True) for row in sum(rows[k + 1:], [])] for k in range(len(rows))]
        stages = [[rows[k], lower[k] if self.method == "reverse_priority" else []] for k in reversed(range(len(rows)))] or [[]]
        stages = [rows] if self.method in LEVELS else [[sum(rows, [])]] if self.method in ONE_LEVEL else stages
        stages[-1] = [hard, *stages[-1]]
        return [[level for level in levels if level] for levels in stages]

    def check_plan(self, problems):
        """Checks that the problems are those of the request, where it states them."""
        plan, keys = self.planned(), lambda levels: [[row.key for row in level] for level in levels]
        is_exact, self.main = not (self.request.get("damping") or self.scaled), self.parts[0][0]
        if not is_exact:
            self.notes["damping or scaling: velocities, references and rows without names are taken from the certificate"] = True
            plan, problems = plan[-1:], [part for part, _ in self.parts if keys(part.levels(self.scaled)) == keys(plan[-1])][:1]
        elif len(problems) < len(plan):  # Lower stages may be left out if all rows are independent, so that they can be met.
            plan = [[[row._replace(is_kept=False) for row in level] for level in plan[-1]]]
            rows = [row for row in self.main.rows if isinstance(row.key, tuple)]
            is_right = all(row.ends[0] == row.ends[1] for row in rows) and are_independent([row.a for row in rows])
            self.note("plan", not is_right or self.method != "reverse_priority")
        self.main = problems[-1] if problems else self.main
        self.note("plan", [keys(problem.levels(self.scaled)) for problem in problems] != list(map(keys, plan)))
        self.note("plan", is_exact and self.parts != [(self.main, 1)])
        self.note("plan", is_exact and any(row.key is None for problem in problems for row in problem.rows))
        before = self.request.get("null_space_velocity") or [0] * len(self.velocity)
        before = numbers(before, len(self.velocity)) if isinstance(before, list) else None
        if not before and is_exact:
            self.notes["the null-space velocity is taken from the certificate"] = True
        for problem, levels in zip(problems, plan):
            if is_exact and before:
                self.note("stages", relative(hypot(*map(sub, before, problem.reference)), hypot(*before, *problem.reference)))
            for row, wanted in zip(sum(problem.levels(self.scaled), []), sum(levels, [])):
                a, ends = wanted.a or row.a, wanted.ends if wanted.ends and is_exact else row.ends
                errors = map(sub, row.a, a + [0] * (len(row.a) - len(a)))
                self.note("rows", relative(hypot(*errors), hypot(*a)))
                value, check, sizes = None, "rows", [abs(float(end)) for end in ends]
                if wanted.is_kept and is_exact:
                    value, check, sizes = dot(row.a, before), "stages", [hypot(*row.a) * hypot(*before)] * 2
                    ends = (value, value) if ends[0] == ends[1] else (min(ends[0], value), max(ends[1], value))
                self.note(check, max(map(difference, row.ends, ends, sizes)))
            before = problem.x

    def check_velocity(self):
        """Checks the joint velocity and what follows from it alone."""
        n, answer, stated, free = len(self.velocity), self.answer, self.request.get("limits"), (-inf, inf)
        box = [free] * n if stated == "none" or not (stated or self.request.get("robot")) else None
        box = bounds_of(stated, "limits") if isinstance(stated, dict) else box
        if self.parts:
            solved = [free] * n if self.is_closed else box or self.parts[0][0].box[:n]
            self.note("rows", any(problem.box[:n] != solved for problem, _ in self.parts))
            for j, value in enumerate(self.velocity):
                total = sum(weight * problem.x[j] for problem, weight in self.parts)
                size = max(abs(float(problem.x[j])) for problem, _ in self.parts)
                self.note("velocity", relative(value - total + excess(total, *solved[j]), size))
            self.note("velocity", difference(sum(weight for _, weight in self.parts), 1, 1.0))
            self.note("velocity", any(weight < 0 for _, weight in self.parts))
            if not box and not self.is_closed:
                self.notes["the limits of the robot are taken from the certificate"] = True
                box = solved
        if box is None:
            self.notes["the limits of the robot are not in the input: they are not checked"] = True
        listed = [(found["side"], found["limit"], found["value"]) for found in answer["violated_limits"]] if self.is_closed else []
        for value, ends in zip(self.velocity, box or []):
            beyond = excess(value, *ends)
            is_listed = ("lower" if beyond < 0 else "upper", ends[beyond > 0], value) in listed
            self.note("inside", 0.0 if is_listed else relative(beyond, abs(float(value))))
        rows = {row.key: row.a for row in self.main.rows} if self.parts else {}
        for (name, task), found in zip(self.tasks.items(), answer["tasks"], strict=True):
            ends, own, missing = bounds_of(task, name), task.get("jacobian"), []
            achieved = numbers(found["achieved"], len(ends), name)
            for i, value in enumerate(achieved):
                missing.append(excess(value, *ends[i]))
                a = numbers(own[i], n, name) if own else rows.get((name, i))
                if not own:
                    self.notes[f"task `{name}`: its rows are {'taken from' if a else 'not in'} the certificate"] = True
                if a:
                    self.note("achieved", difference(value, dot(a, self.velocity), hypot(*map(mul, a, self.velocity))))
            size = hypot(*achieved, *(end for pair in ends for end in pair if isfinite(end)))
            self.note("achieved", difference(found["residual_norm"], hypot(*missing), size))

    def check_active(self):
        """Checks that active limits, rows and inequalities are reached and have the multipliers of the certificate."""
        n, main, seen = len(self.velocity), self.main, 0
        unlisted = {place: forces for place, forces in enumerate(main.forces) if not n <= place < len(main.x)}
        for given in self.answer["active_limits"]:  # The names of a robot's joints are not in the input, but their order is.
            joints = [j for j in range(seen, n) if self.request.get("robot") or given["joint"] == f"j{j + 1}"]
            error, j = min(((max(self.mismatch(j, given, self.velocity[j], main.box[j]), difference(
                given["value"], main.box[j][given["side"] == "upper"], 1.0)), j) for j in joints), default=(inf, n))
            self.note("active", error)
            unlisted.pop(j, None)
            seen = j + 1
        places = {row.key: i for i, row in enumerate(main.rows)}
        listed = [((task["name"], given["row"]), given) for task in self.answer["tasks"] for given in task.get("active_rows", [])]
        listed += [(given["name"], {**given, "side": "upper"}) for given in self.answer.get("active_inequalities", [])]
        for key, given in listed:
            row, i, norm = main.rows[places[key]], places[key] + len(main.x), 1.0
            if key in self.hard:  # Its row has length one in the certificate.
                norm = hypot(*self.hard[key].get("coefficients", [])) or float(given["bound"] / row.ends[1])
            self.note("active", self.mismatch(i, given, dot(row.a, self.velocity), row.ends, norm))
            unlisted.pop(i, None)
        for forces in unlisted.values() if len(self.parts) == 1 else ():
            self.note("complete", max((relative(force, size) for force, size, _ in forces), default=0.0))

    def mismatch(self, place, given, value, ends, norm=1.0):
        """Returns how far an active bound is from being reached and from its multiplier, the first one that is not zero."""
        side, multiplier, best = (1 if given["side"] == "upper" else -1), given["multiplier"] * norm, inf
        is_pinned = ends[0] == ends[1] and multiplier == 0.0  # It may have a multiplier at the last objective.
        for problem in [problem for problem, _ in self.parts] if place < len(self.velocity) else [self.main]:
            forces = problem.forces[place][:-1 if is_pinned and problem.multipliers[-1] else None]
            for force, size, rounded in forces:
                best = min(best, difference(multiplier, abs(force), abs(force) + FINE * rounded) if force * side >= 0.0 else inf)
                if abs(force) > TOLERANCE * size:
                    break
            else:
                best = 0.0 if multiplier == 0.0 else best
        return max(best, relative(max(0, side * (ends[side > 0] - value)), self.main.sizes[place]))


def examine(texts):
    """Checks a request and its answer, or a line with both. Returns what is wrong with the input, then the parts of a `Check`."""
    start = time.process_time()
    try:
        values = [json.loads(text) for text in texts]
        check = Check(*(values if len(values) == 2 else (values[0]["request"], values[0]["answer"])))
        return None, check.largest, check.failed, check.notes, time.process_time() - start
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
        return f"{error} is missing" if isinstance(error, KeyError) else f"{error}", {}, [], {}, 0.0


def report(results):
    """Prints the results; returns the exit status."""
    is_one, largest, failures = len(results) == 1, {}, {}
    for place, (wrong, found, failed, notes, _) in enumerate(results, 1):
        if wrong or failed and not is_one:
            print(f"answer {place}: " + (f"cannot be read: {wrong}" if wrong else "does not hold: " + ", ".join(failed)))
        largest |= {check: max(error, largest.get(check, 0.0)) for check, error in found.items()}
        failures |= dict.fromkeys(failed)
    for check in filter(largest.__contains__, CHECKS):
        what, allowed = CHECKS[check]
        print(f"{'holds' if largest[check] <= allowed else 'FAILS'} {largest[check]:8.1e} of {allowed:5.0e}  {check}: {what}")
    unread, broken = sum(bool(result[0]) for result in results), sum(bool(result[2]) for result in results)
    cpu = 1e3 * sum(result[4] for result in results) / max(1, len(results))
    print("\n".join(f"note: {note}" for note in results[0][3]) if is_one else
          f"{len(results)} answers: {broken} do not hold, {unread} cannot be read; {cpu:.2f} ms of CPU time for each")
    print("certificate does not hold: " + ", ".join(failures) if broken else "not checked" if unread else "certificate holds")
    return 1 if broken else 2 if unread else 0


def main(paths):
    """Runs the program; returns its exit status."""
    try:
        texts = [Path(path).read_text(encoding="utf-8") for path in paths]
    except (OSError, ValueError) as error:
        print(f"cannot be read: {error}", file=sys.stderr)
        return 2
    items = list(zip(texts[::2], texts[1::2])) or [[line] for text in texts for line in text.splitlines() if line.strip()]
    if not items or len(texts) > 1 and len(texts) % 2:
        print(__doc__, file=sys.stderr)
        return 2
    if len(items) > 1 and "fork" in multiprocessing.get_all_start_methods():
        with multiprocessing.get_context("fork").Pool() as pool:
            return report(pool.map(examine, items, chunksize=16))
    return report(list(map(examine, items)))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
