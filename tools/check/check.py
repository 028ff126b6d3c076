"""Checks that an answer of `POST /v1/resolve` is right: check.py REQUEST ANSWER [REQUEST ANSWER ...], or check.py LINES.

The request has `"certificate": true`. LINES is a file with one {"request": ..., "answer": ...} on each line. Prints what was
checked and the largest relative error of each check. Exit status: 0 the certificate holds, 1 it does not, 2 unreadable input.

docs/certificate.md explains the conditions. This program shares no code with revprio. It computes with fractions, so that all
sums and products are exact. Only the sizes that errors are compared with are rounded.
"""

import json
import multiprocessing
import os
import sys
from collections import Counter, namedtuple
from fractions import Fraction
from math import hypot, inf, isfinite
from operator import mul
from time import perf_counter

TOLERANCE = 1e-9  # of a relative error, as the status `optimal` claims
FINE = 1e-4  # An error is rounding, too, below TOLERANCE * FINE of the coarse size, which contains all that was rounded.
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
    "complete": ("no limit or row with a multiplier is left out of them", TOLERANCE),
}
Row = namedtuple("Row", "level key a low high")
Planned = namedtuple("Planned", "key a low high is_kept")  # a row as the request states it; a is None where it does not


class Unreadable(ValueError):
    """The input is not a request and its answer."""


def numbers(value, count, what, optional=False):
    """Returns a list of finite numbers as fractions. None, where it is allowed, is no bound."""
    if not isinstance(value, list) or len(value) != (len(value) if count is None else count):
        raise Unreadable(f"{what}: expected a list of {'' if count is None else count} numbers")
    if not all(type(entry) in (int, float) and isfinite(entry) or optional and entry is None for entry in value):
        raise Unreadable(f"{what}: an entry is not a finite number")
    return [None if entry is None else Fraction(entry) for entry in value]


def bounds_of(stated, what):
    """Returns the (lower, upper) pairs that a task, the limits or a problem states."""
    sides = [stated.get("velocity") or stated.get(side) for side in ("lower", "upper")]
    count = max(len(side or []) for side in sides)
    return list(zip(*(numbers(side or [None] * count, count, what, True) for side in sides)))


def relative(error, size):
    """Returns |error| / size."""
    return 0.0 if not error else abs(float(error)) / size if 0.0 < size < inf else inf


def difference(a, b, size):
    """Returns |a - b| / size, where None equals only None."""
    return relative(a - b, size) if None not in (a, b) else 0.0 if a is b else inf


def excess(value, low, high):
    """Returns by how much a value is above its bounds (positive) or below them (negative)."""
    return value - low if low is not None and value < low else value - high if high is not None and value > high else 0


def dot(a, x):
    """Returns a·x."""
    return sum(map(mul, a, x))


def are_independent(rows):
    """Returns whether rows are linearly independent: elimination."""
    while rows:
        pivot = rows[-1]
        column = next((j for j, a in enumerate(pivot) if a), None)
        if column is None:
            return False
        rows = [[b - a * (row[column] / pivot[column]) for a, b in zip(pivot, row)] for row in rows[:-1]]
    return True


class Problem:
    """One hierarchical problem of a certificate."""

    def __init__(self, raw, what):
        self.x, self.rows, self.starts = numbers(raw["solution"], None, what), [], [0]
        self.reference, self.box = numbers(raw["reference"], len(self.x), what), bounds_of(raw, what)
        for k, level in enumerate(raw["levels"]):
            for a, ends, name in zip(level["rows"], bounds_of(level, what), level["names"], strict=True):
                key = (name["task"], name["row"]) if "task" in name else name.get("inequality")
                self.rows.append(Row(k, key, numbers(a, len(self.x), what), *ends))
            self.starts.append(len(self.rows))
        self.multipliers = [  # per level, and of the last objective: w of the rows, h of the unknowns
            given and (numbers(given["rows"], end, what), numbers(given["unknowns"], len(self.x), what))
            for given, end in zip(raw["multipliers"], self.starts[1:] + [len(self.rows)], strict=True)]
        if len(self.box) != len(self.x) or any(None not in ends and ends[0] > ends[1] for ends in self.box):
            raise Unreadable(f"{what}: not a box of {len(self.x)} unknowns")

    def levels(self, unless):
        """Returns the named rows level by level, without those of some tasks."""
        rows = [row for row in self.rows if row.key is not None and row.key[0] not in unless]
        return [level for k in range(len(self.starts)) if (level := [row for row in rows if row.level == k])]

    def check(self, note):
        """Checks the optimality of each level given those above it."""
        speed, norms, starts, last = hypot(*self.x), [hypot(*row.a) for row in self.rows], self.starts, len(self.starts) - 1
        values, zeta, reach = [dot(row.a, self.x) for row in self.rows], [b - a for a, b in zip(self.x, self.reference)], speed
        level_norms, sizes, self.sizes, proven = [], [], [], set()
        self.forces = [[] for _ in self.x + self.rows]  # of unknowns, then of rows: per level, with their sizes

        def check_force(check, place, force, value, ends, sizes, zero):
            """Checks one multiplier: zero (relative to the first size) or at the bound that it points to (the second)."""
            side = 1 if force > 0 else -1
            away = inf if ends[side > 0] is None else relative(max(0, side * (ends[side > 0] - value)), sizes[1])
            if check and (place, -side) not in proven:  # Otherwise all optima of a higher level are at the other bound.
                note(check, min(relative(force, sizes[0]), away))
            if away <= TOLERANCE and abs(force) > zero:
                proven.add((place, side))

        for value, ends in zip(self.x, self.box):
            note("box", relative(excess(value, *ends), speed))
        for k, pair in enumerate(self.multipliers[:-1]):
            own = range(starts[k], starts[k + 1])
            missing = [-excess(values[i], *self.rows[i][3:]) for i in own]
            aims = [values[i] + r for i, r in zip(own, missing) if r or self.rows[i].low == self.rows[i].high]
            level_norms.append(hypot(*norms[own.start:own.stop]))
            reach = max(reach, hypot(*aims) / level_norms[k] if pair and level_norms[k] else 0.0)
            sizes.append(hypot(*aims) + level_norms[k] * reach)
            self.sizes += [norms[i] * speed + FINE * sizes[k] for i in own]
            for i, r in zip(own, missing):
                note("residuals", relative((pair[0][i] if pair else 0) - r, self.sizes[i]))
        if self.multipliers[last] is None:
            note("residuals", relative(hypot(*zeta), speed + hypot(*self.reference)))
        for k, (w, h) in ((k, pair) for k, pair in enumerate(self.multipliers) if pair):
            length, norm = (hypot(*zeta), 1.0) if k == last else (hypot(*w[starts[k]:]), level_norms[k])
            amount = length * norm + sum(abs(w[i]) * level_norms[self.rows[i].level] for i in range(starts[k]))
            coarse = reach + hypot(*self.reference) if k == last else sizes[k]
            size = amount * (1.0 + FINE * coarse / length) if length else amount
            for j, ends in enumerate(self.box):
                terms = [entry * row.a[j] for entry, row in zip(w, self.rows)] + ([zeta[j]] if k == last else [])
                note("sums", difference(h[j], total := sum(terms), hypot(*terms, *([self.x[j]] if k == last else []))))
                check_force("unknowns", j, total, self.x[j], ends, (size, speed), NOT_ZERO * amount)
                self.forces[j].append((float(h[j]), size))
            for i, (entry, row) in enumerate(zip(w, self.rows)):
                if row.low != row.high:
                    zero, check = (NOT_ZERO * amount, "row signs") if row.level < k else (NOT_ZERO * sizes[k] * norms[i], None)
                    check_force(check, ~i, -entry * norms[i], values[i], row[3:], (size, self.sizes[i]), zero)
                    self.forces[len(self.x) + i].append((-float(entry), size / norms[i] if norms[i] else 0.0))


def planned_problems(request, is_closed):
    """Returns the problems of the method as levels of rows, and the names of scaled tasks."""
    rows, scaled, hard, method = [], [], [], request.get("method", "reverse_priority")
    for k, task in enumerate(request["tasks"]):
        name = task.get("name") or f"task {k + 1}"
        ends = bounds_of(task, name)
        if not is_closed or all(low == high for low, high in ends):
            scaled += [name] if task.get("scale") else []
            stated = [] if task.get("scale") else zip(task.get("jacobian") or [None] * len(ends), ends, strict=True)
            rows.append([Planned((name, i), a and numbers(a, None, name), *b, False) for i, (a, b) in enumerate(stated)])
    for i, stated in enumerate([] if is_closed else request.get("inequalities", [])):
        name, a = stated.get("name") or f"inequality {i + 1}", stated.get("coefficients")
        norm = hypot(*a or [0.0]) or 1.0
        hard.append(Planned(name, a and [Fraction(entry / norm) for entry in a], None, a and Fraction(stated["upper"] / norm), False))
    if method in ("pseudoinverse", "damped_least_squares"):
        problems = [[sum(rows, [])]]
    elif method in ("task_priority", "strict_reverse_priority"):
        problems = [rows]
    else:
        lower = [[row._replace(is_kept=True) for row in sum(rows[k + 1:], [])] for k in range(len(rows))]
        problems = [[rows[k], lower[k] if method == "reverse_priority" else []] for k in reversed(range(len(rows)))] or [[]]
    problems[-1] = [hard, *problems[-1]]
    return [[level for level in levels if level] for levels in problems], scaled


class Check:
    """The checks of one answer: `largest` relative error of each, `failed` ones, and `notes` on what is not checked."""

    def __init__(self, request, answer):
        self.request, self.answer, self.notes, self.largest = request, answer, [], {}
        self.velocity, status = numbers(answer["joint_velocity"], None, "joint_velocity"), answer["solver"]["status"]
        self.is_closed, certificate, self.parts = request.get("solver") == "closed_form", answer.get("certificate"), []
        if status not in ("optimal", "not_certified", "failed"):
            raise Unreadable(f"unknown status `{status}`")
        if certificate is None and status != "failed":
            raise Unreadable('the answer has no `certificate`: set "certificate": true in the request')
        if certificate:
            problems = [Problem(raw, f"problem {i}") for i, raw in enumerate(certificate["problems"])]
            self.parts = [(problems[part["problem"]], *numbers([part["weight"]], 1, "weight")) for part in certificate["answer"]]
            for problem in problems:
                problem.check(self.note)
            self.check_plan(problems)
            self.check_active()
        self.check_velocity()
        if status == "optimal":
            residual = answer["solver"]["kkt_residual"]
            self.note("status", residual is None or residual > TOLERANCE)
        else:
            self.notes.append(f"status `{status}`: only a finite velocity inside the limits is claimed")
        claimed = CHECKS if status == "optimal" else ["inside"]
        self.failed = [check for check in claimed if not self.largest.get(check, 0.0) <= CHECKS[check][1]]

    def note(self, check, error):
        """Keeps the largest error of a check."""
        self.largest[check] = max(self.largest.get(check, 0.0), float(error))

    def check_plan(self, problems):
        """Checks that the problems are those of the request, where it states them."""
        plan, scaled = planned_problems(self.request, self.is_closed)
        keys = lambda levels: [[row.key for row in level] for level in levels]
        is_exact, self.main = not (self.request.get("damping") or scaled), self.parts[0][0]
        if not is_exact:
            self.notes.append("damping or scaling: targets, references and scaled rows are taken from the certificate")
            plan, problems = plan[-1:], [problem for problem in problems if keys(problem.levels(scaled)) == keys(plan[-1])][:1]
        elif len(problems) < len(plan):  # Lower stages may be left out if all rows are independent: then they can be met.
            plan, rows = [[[row._replace(is_kept=False) for row in level] for level in plan[-1]]], self.main.rows
            is_right = self.request.get("method", "reverse_priority") == "reverse_priority" and are_independent([row.a for row in rows])
            self.note("plan", not (is_right and all(row.low == row.high for row in rows)))
        self.main = problems[-1] if problems else self.main
        self.note("plan", [keys(problem.levels(scaled)) for problem in problems] != [keys(levels) for levels in plan])
        self.note("plan", is_exact and self.parts != [(self.main, 1)])
        before = self.request.get("null_space_velocity") or [0] * len(self.velocity)
        before = numbers(before, len(self.velocity), "null_space_velocity") if isinstance(before, list) else None
        for problem, levels in zip(problems, plan):
            if is_exact and before:
                errors = (a - b for a, b in zip(before, problem.reference))
                self.note("stages", relative(hypot(*errors), hypot(*before, *problem.reference)))
            for row, wanted in zip(sum(problem.levels(scaled), []), sum(levels, [])):
                if wanted.a:
                    self.note("rows", relative(hypot(*(a - b for a, b in zip(row.a, wanted.a))), hypot(*wanted.a)))
                if wanted.is_kept and is_exact:
                    value = dot(row.a, before)
                    low, high = (value, value) if wanted.low == wanted.high else (
                        wanted.low and min(wanted.low, value), wanted.high and max(wanted.high, value))
                    size = hypot(*row.a) * hypot(*before)
                    self.note("stages", max(difference(row.low, low, size), difference(row.high, high, size)))
                elif is_exact and (wanted.a or isinstance(wanted.key, tuple)):
                    for end, bound in zip(row[3:], wanted[2:4]):
                        self.note("rows", difference(end, bound, abs(float(bound or 0))))
            before = problem.x

    def check_velocity(self):
        """Checks the joint velocity and what follows from it alone."""
        n, answer, stated = len(self.velocity), self.answer, self.request.get("limits")
        box = [(None, None)] * n if stated == "none" or not (stated or self.request.get("robot")) else None
        box = bounds_of(stated, "limits") if isinstance(stated, dict) else box
        if self.parts:
            total = [sum(weight * problem.x[j] for problem, weight in self.parts) for j in range(n)]
            moved = [value - excess(value, *ends) for value, ends in zip(total, self.parts[0][0].box)]
            for j, (a, b) in enumerate(zip(self.velocity, moved)):
                self.note("velocity", relative(a - b, max(abs(problem.x[j]) for problem, _ in self.parts)))
            self.note("velocity", relative(sum(weight for _, weight in self.parts) - 1, 1.0))
            self.note("velocity", any(weight < 0 for _, weight in self.parts))
            solved = [problem.box[:n] for problem, _ in self.parts]
            box = box or (solved[0] if not self.is_closed else None)
            self.note("rows", any(other != (box if not self.is_closed else [(None, None)] * n) for other in solved))
        if box is None:
            self.notes.append("the limits of the robot are not in the input: not checked")
        listed = Counter((entry["side"], *numbers([entry["limit"], entry["value"]], 2, "limit")) for entry in answer["violated_limits"])
        for value, ends in zip(self.velocity, box or []):
            beyond = excess(value, *ends)
            entry = ("upper", ends[1], value) if beyond > 0 else ("lower", ends[0], value)
            if beyond and not (self.is_closed and listed[entry] > 0):
                self.note("inside", relative(beyond, abs(float(value))))
            listed[entry] -= 1 if beyond else 0
        rows = {row.key: row.a for row in self.main.rows} if self.parts else {}
        for k, (task, found) in enumerate(zip(self.request["tasks"], answer["tasks"], strict=True)):
            name, ends = task.get("name") or f"task {k + 1}", bounds_of(task, "task")
            achieved, missing, size = numbers(found["achieved"], len(ends), name), [], 0.0
            for i, value in enumerate(achieved):
                a = numbers(task["jacobian"][i], n, name) if task.get("jacobian") else rows.get((name, i))
                if a is None:
                    self.notes.append(f"task `{name}`, row {i}: its Jacobian is not in the input, `achieved` is not checked")
                else:
                    self.note("achieved", difference(value, dot(a, self.velocity), hypot(*map(mul, a, self.velocity))))
                missing.append(excess(value, *ends[i]))
                size = hypot(size, value, *(end for end in ends[i] if end is not None))
            self.note("achieved", difference(Fraction(found["residual_norm"]), Fraction(hypot(*missing)), size))

    def check_active(self):
        """Checks that active limits, rows and inequalities are reached and have the multipliers of the certificate."""
        n, main, seen = len(self.velocity), self.main, 0
        unlisted = {place: forces for place, forces in enumerate(main.forces) if not n <= place < len(main.x)}
        for entry in self.answer["active_limits"]:  # The names of a robot's joints are not in the input, but their order is.
            joints = range(seen, n) if self.request.get("robot") else [int(entry["joint"][1:]) - 1]
            value = [max(self.mismatch(j, entry, self.velocity[j], main.box[j], hypot(*self.velocity)),
                         difference(Fraction(entry["value"]), main.box[j][entry["side"] == "upper"], 1.0)) for j in joints]
            self.note("active", min(value, default=inf))
            joint = joints[value.index(min(value))] if value else n
            unlisted.pop(joint, None)
            seen = joint + 1
        places = {row.key: i for i, row in enumerate(main.rows)}
        listed = [((task["name"], entry["row"]), entry) for task in self.answer["tasks"] for entry in task.get("active_rows", [])]
        listed += [(entry["name"], {**entry, "side": "upper"}) for entry in self.answer.get("active_inequalities", [])]
        for key, entry in listed:
            i = places[key]
            row = main.rows[i]
            if entry.get("bound") and row.high:  # Rows of inequalities have length one in the certificate.
                entry["multiplier"] *= float(Fraction(entry["bound"]) / row.high)
            value = dot(row.a, self.velocity)
            self.note("active", self.mismatch(len(main.x) + i, entry, value, row[3:], main.sizes[i]))
            unlisted.pop(len(main.x) + i, None)
        for forces in unlisted.values() if len(self.parts) == 1 else ():
            self.note("complete", max((relative(force, size) for force, size in forces), default=0.0))

    def mismatch(self, place, entry, value, ends, size):
        """Returns how far an active bound is from being reached and from its multiplier, the first one that is not zero."""
        side, best = (1 if entry["side"] == "upper" else -1), inf
        for problem in [problem for problem, _ in self.parts] if place < len(self.velocity) else [self.main]:
            for force, scale in problem.forces[place]:
                if force * side >= 0.0:
                    best = min(best, relative(entry["multiplier"] - abs(force), abs(force) + FINE * scale))
                if abs(force) > TOLERANCE * scale:
                    break
            else:
                best = 0.0 if entry["multiplier"] == 0.0 else best
        end = ends[side > 0]
        return inf if end is None else max(best, relative(max(0, side * (end - value)), size))


def read(text):
    """Reads JSON."""
    def refuse(name):
        raise Unreadable(f"{name} is not a number of JSON")
    return json.loads(text, parse_constant=refuse)


def examine(texts):
    """Checks one request and its answer, or one line with both; returns a message or the check, and the time."""
    start = perf_counter()
    try:
        values = [read(text) for text in texts]
        request, answer = values if len(values) == 2 else (values[0]["request"], values[0]["answer"])
        check = Check(request, answer)
        result = None, check.largest, check.failed, check.notes
    except KeyError as error:
        result = f"the field {error} is missing", {}, [], []
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
        result = f"not a request and its answer: {error}", {}, [], []
    return *result, perf_counter() - start


def report(results):
    """Prints the results, and returns the exit status."""
    largest = {}
    for place, (message, found, failed, notes, _) in enumerate(results, 1):
        where = f"answer {place}: " if len(results) > 1 else ""
        for note in dict.fromkeys(notes) if len(results) == 1 else ():
            print(f"note: {note}")
        for check, error in found.items():
            largest[check] = max(largest.get(check, 0.0), error)
        if len(results) > 1 and (message or failed):
            print(where + (f"cannot be read: {message}" if message else "certificate does not hold: " + ", ".join(failed)))
    for check, (what, tolerance) in CHECKS.items():
        if check in largest:
            holds = largest[check] <= tolerance
            print(f"{'holds' if holds else 'FAILS'}  {check:9} {largest[check]:7.1e} (at most {tolerance:.0e})  {what}")
    unread = sum(message is not None for message, *_ in results)
    broken = sum(bool(failed) for _, _, failed, *_ in results)
    if len(results) > 1:
        time = 1e3 * sum(seconds for *_, seconds in results) / len(results)
        print(f"{len(results)} answers: {len(results) - unread - broken} hold, {broken} do not, {unread} cannot be read")
        print(f"{time:.2f} ms per answer")
    elif unread:
        print(f"cannot be read: {results[0][0]}", file=sys.stderr)
    if broken:
        print("certificate does not hold: " + ", ".join(dict.fromkeys(check for result in results for check in result[2])))
    elif not unread:
        print("certificate holds")
    return 1 if broken else 2 if unread else 0


def main(paths):
    """Runs the program; returns its exit status."""
    if not paths or len(paths) > 1 and len(paths) % 2 or paths[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    try:
        texts = [open(path, encoding="utf-8").read() for path in paths]
    except (OSError, ValueError) as error:
        print(f"cannot be read: {error}", file=sys.stderr)
        return 2
    items = list(zip(texts[::2], texts[1::2])) if len(paths) > 1 else [[line] for line in texts[0].splitlines() if line.strip()]
    if len(items) > 1 and "fork" in multiprocessing.get_all_start_methods():
        with multiprocessing.get_context("fork").Pool() as pool:
            return report(pool.map(examine, items, chunksize=16))
    return report(list(map(examine, items)))


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except BrokenPipeError:
        os._exit(1)
