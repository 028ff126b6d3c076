"""Checks that an answer of `POST /v1/resolve` is right: check.py REQUEST ANSWER, or check.py LINES.

The request has `"certificate": true`. LINES has an object {"request": ..., "answer": ...} on each line; - is standard input.
Exit status: 0 the certificate holds, 1 it does not, 2 the input cannot be read. docs/certificate.md explains it.
This program shares no code with revprio. All sums and products are exact; only the sizes of errors are rounded."""
import json, multiprocessing, os, sys
from collections import namedtuple
from fractions import Fraction
from math import hypot, inf
from operator import mul, sub

TOLERANCE = 1e-9  # of a relative error, as the status `optimal` claims
FINE = 1e-4  # Rounding: errors below TOLERANCE * FINE, or below `kkt_residual`, of the size of all that was added up.
NOT_ZERO = 1e-14  # A multiplier above this part of its terms is not zero.
CHECKS = {  # name: (what is compared, tolerance)
    "certificate": ("the answer has a certificate, for which the request needs `\"certificate\": true`", 0.0),
    "status": ("`kkt_residual` is small enough for the status", 0.0),
    "plan": ("problems and levels are those of the method, in its order", 0.0),
    "rows": ("rows, bounds and references are those of the request, or what the stage before achieved", 1e-12),
    "residuals": ("solutions are inside their box; multipliers of a level's own rows are their residuals", TOLERANCE),
    "sums": ("multipliers of unknowns are the sums of rows times multipliers", 1e-12),
    "signs": ("multipliers are zero inside the bounds and have the right sign at a bound", TOLERANCE),
    "velocity": ("`joint_velocity` is the sum of the solutions, moved into the box, and inside the limits", 1e-12),
    "achieved": ("`achieved` and `residual_norm` belong to `joint_velocity`", 1e-12),
    "active": ("active limits and rows are reached and have their multipliers; none is left out", TOLERANCE)}
NUMBER, WHOLE, TEXT, NULL, LIST, OBJECT = "a finite number", "a whole number", "a text", "null", "a list", "an object"
KINDS = {NUMBER: (int, float), WHOLE: int, TEXT: str, NULL: type(None), LIST: list, OBJECT: dict}
SIDES, STATUS, NAME = ("lower", "upper"), {"optimal", "not_certified", "failed"}, (NULL, TEXT)
ENDS = {side + "?": (NULL, [(NULL, NUMBER)]) for side in SIDES}
REQUEST = {  # {}: an object with these fields, `name?` may be missing; []: a list; (): one of these; set: one of these words
    "robot?": NAME, "method?": NAME, "solver?": NAME, "damping?": (NULL, OBJECT), "null_space_velocity?": (NULL, OBJECT, [NUMBER]),
    "limits?": (NULL, TEXT, {"lower": [NUMBER], "upper": [NUMBER]}),
    "tasks": [{"name?": NAME, "jacobian?": (NULL, [[NUMBER]]), "velocity?": (NULL, [NUMBER]), **ENDS}],
    "inequalities?": [{"name?": NAME, "coefficients?": [NUMBER], "upper?": NUMBER}]}
ANSWER = {
    "joint_velocity": [NUMBER], "solver": {"status": STATUS, "kkt_residual": (NULL, NUMBER)},
    "tasks": [{"name?": TEXT, "requested?": [NUMBER], "achieved": [NUMBER], "residual_norm": NUMBER,
               "active_rows?": [{"row": WHOLE, "side": {*SIDES}, "multiplier": NUMBER}]}],
    "active_limits": [{"joint": TEXT, "side": {*SIDES}, "value?": NUMBER, "multiplier": NUMBER}],
    "active_inequalities?": [{"name": TEXT, "bound?": NUMBER, "multiplier": NUMBER}],
    "certificate?": (NULL, {"answer": [{"problem": WHOLE, "weight": NUMBER}], "problems": [{
        "solution": [NUMBER], "reference": [NUMBER], **ENDS,
        "levels": [{"rows": [[NUMBER]], **ENDS, "names": [{"task?": TEXT, "row?": WHOLE, "inequality?": TEXT}]}],
        "multipliers": [(NULL, {"rows": [NUMBER], "unknowns": [NUMBER]})]}]})}
Row = namedtuple("Row", "key a ends level is_kept", defaults=(None, False))  # key: (task, row), an inequality or None

def read(text, place):
    """Reads JSON. Refuses NaN, and names that stand twice in an object, because readers differ in which value counts."""
    def refuse(what):
        raise ValueError(f"{what}: not a finite number, or not each name once")
    once = lambda pairs: dict(pairs) if len(dict(pairs)) == len(pairs) else refuse([name for name, _ in pairs])
    try:
        return json.loads(text, object_pairs_hook=once, parse_constant=refuse)
    except ValueError as error:
        raise ValueError(f"the {place} is not valid JSON: {error}") from None

def misfit(value, form, place):
    """Returns what is wrong with the form of a field, or an empty text."""
    if isinstance(form, tuple):
        wrong = [misfit(value, each, place) for each in form]
        return wrong[-1] if all(wrong) else ""
    kind = {list: LIST, dict: OBJECT, set: TEXT}.get(type(form), form)
    is_right = isinstance(value, KINDS[kind]) and not isinstance(value, bool)
    is_right = is_right and (kind != NUMBER or abs(value) <= sys.float_info.max)
    if not is_right or isinstance(form, set) and value not in form:
        wanted = " or ".join(sorted(form)) if isinstance(form, set) else kind
        return f"`{place}` must be {wanted}, not {json.dumps(value)[:40]}"
    parts = [(entry, form[0], f"{place}[{i}]") for i, entry in enumerate(value)] if kind == LIST else []
    for name, part in form.items() if isinstance(form, dict) else ():
        if (key := name.rstrip("?")) in value:
            parts.append((value[key], part, f"{place}.{key}"))
        elif key == name:
            return f"`{place}.{key}` is missing"
    return next(filter(None, (misfit(*part) for part in parts)), "")

def lengths(request, answer):
    """Yields lists that must have the same length: place and list of both."""
    yield "answer.tasks", answer["tasks"], "request.tasks", request["tasks"]
    for k, (task, found) in enumerate(zip(request["tasks"], answer["tasks"])):
        names = [name for name in ("velocity", *SIDES) if task.get(name)] or ["velocity"]
        names += ["jacobian"] if task.get("jacobian") else []
        achieved = f"answer.tasks[{k}].achieved", found["achieved"]
        yield from ((f"request.tasks[{k}].{name}", task.get(name) or [], *achieved) for name in names)
    joints = "answer.joint_velocity", answer["joint_velocity"]
    if isinstance(request.get("joint_position"), list):
        yield "request.joint_position", request["joint_position"], *joints
    for k, task in enumerate(request["tasks"]):
        yield from ((f"request.tasks[{k}].jacobian[{i}]", row, *joints) for i, row in enumerate(task.get("jacobian") or []))
    if isinstance(request.get("limits"), dict):
        yield from ((f"request.limits.{side}", request["limits"][side], *joints) for side in SIDES)
    for k, problem in enumerate((answer.get("certificate") or {}).get("problems", [])):
        here = f"answer.certificate.problems[{k}]"
        unknowns = f"{here}.solution", problem["solution"]
        yield from ((f"{here}.{name}", problem[name], *unknowns) for name in ("reference", *SIDES)
                    if problem.get(name) or name == "reference")
        yield f"{here}.multipliers", problem["multipliers"], f"{here}.levels and the last objective", [*problem["levels"], None]
        for i, level in enumerate(problem["levels"]):
            rows = f"{here}.levels[{i}].rows", level["rows"]
            yield from ((f"{here}.levels[{i}].{name}", level[name], *rows) for name in ("names", *SIDES)
                        if level.get(name) or name == "names")
            yield from ((f"{rows[0]}[{j}]", row, *unknowns) for j, row in enumerate(level["rows"]))
        count = 0
        for i, (pair, level) in enumerate(zip(problem["multipliers"], [*problem["levels"], {"rows": []}])):
            count += len(level["rows"])
            if pair:
                yield f"{here}.multipliers[{i}].rows", pair["rows"], "the rows of this level and all higher ones", [None] * count
                yield f"{here}.multipliers[{i}].unknowns", pair["unknowns"], *unknowns

def check_form(request, answer):
    """Refuses a request or an answer with a field of another form."""
    wrong = misfit(request, REQUEST, "request") or misfit(answer, ANSWER, "answer")
    if wrong := wrong or next((f"`{one}` has {len(a)} entries, and `{other}` has {len(b)}"
                               for one, a, other, b in lengths(request, answer) if len(a) != len(b)), ""):
        raise ValueError(wrong)
    certificate = answer.get("certificate") or {"answer": [], "problems": []}
    n, scales = len(answer["joint_velocity"]), sum(bool(task.get("scale")) for task in request["tasks"])
    for k, problem in enumerate(certificate["problems"]):
        if not n <= len(problem["solution"]) <= n + scales:
            raise ValueError(f"`answer.certificate.problems[{k}].solution` has {len(problem['solution'])} entries for {n} joints "
                             f"in `answer.joint_velocity`" + f" and {scales} scaled tasks" * bool(scales))
    for i, part in enumerate(certificate["answer"]):
        if not 0 <= part["problem"] < len(certificate["problems"]):
            raise ValueError(f"`answer.certificate.answer[{i}].problem` is {part['problem']}, which is the index of no problem")

def numbers(values, none=None):
    """Returns finite numbers as fractions, with `none` in the place of null. Texts are no numbers: adding 0 fails."""
    return [none if value is None and none else Fraction(value + 0) for value in values]

def bounds_of(stated):
    """Returns the bounds (lower, upper) that a task, the limits or a problem states; infinite where it does not."""
    lower, upper = (stated.get("velocity") or stated.get(side) or [] for side in ("lower", "upper"))
    none = [None] * max(len(lower), len(upper))
    return list(zip(numbers(lower or none, -inf), numbers(upper or none, inf), strict=True))

def relative(a, size, b=0):
    """Returns |a - b| / size. Bounds may be infinite."""
    return 0.0 if a == b else abs(float(a - b)) / size if 0.0 < size < inf else inf

def excess(value, low, high):
    """Returns by how much a value is above its bounds (positive) or below them (negative)."""
    return value - low if value < low else value - high if value > high else 0

def are_independent(rows):
    """Returns whether rows are linearly independent, by elimination."""
    pivot = next((j for j, entry in enumerate(rows[-1]) if entry), None) if rows else None
    return not rows or pivot is not None and are_independent(
        [[b - a * (row[pivot] / rows[-1][pivot]) for a, b in zip(rows[-1], row)] for row in rows[:-1]])

class Problem:
    """A problem of a certificate. Checks the optimality of each level given those above it."""
    def __init__(self, raw, note, fine):
        self.x, self.reference, self.box = numbers(raw["solution"]), numbers(raw["reference"]), bounds_of(raw)
        key = lambda name: (name["task"], name.get("row")) if "task" in name else name.get("inequality")
        self.rows = [Row(key(name), numbers(a), ends, k) for k, level in enumerate(raw["levels"])
                     for a, ends, name in zip(level["rows"], bounds_of(level), level["names"], strict=True)]
        self.bounds, n = self.box + [row.ends for row in self.rows], len(self.x)
        values = self.x + [sum(a * x for a, x in zip(row.a, self.x, strict=True)) for row in self.rows]
        missing = [-excess(value, *ends) for value, ends in zip(values, self.bounds, strict=True)]
        self.forces = [[] for _ in values]  # (multiplier, size of its error, of its terms), to the first not zero
        self.norms, self.widest = [1.0] * n + [hypot(*row.a) for row in self.rows], hypot(*sum(self.box, ()))
        speed, zeta = hypot(*self.x), list(map(sub, self.reference, self.x))
        start, reach, self.sizes, level_norms, proven = n, speed + hypot(*self.reference), [speed] * n, [], set()
        note("residuals", *(relative(r, speed) for r in missing[:n]))
        for level, pair in zip([*raw["levels"], None], raw["multipliers"], strict=True):
            own = range(start, start + len(level["rows"]) if level else start)
            rows, start, is_last = self.rows[:own.stop - n], own.stop, level is None
            w, h = (numbers(pair[part]) for part in ("rows", "unknowns")) if pair else ([0] * len(rows), [0] * n)
            norm = hypot(*(self.norms[i] for i in own)) or 1.0
            coarse = hypot(*(values[i] + missing[i] for i in own)) + norm * reach  # the size of all that was rounded
            self.sizes += [self.norms[i] * speed + fine * coarse for i in own]
            self.sizes[:n] = [max(self.sizes[0], speed + fine * min(coarse / norm, reach + self.widest))] * n
            level_norms.append(norm)
            note("residuals", 0.0, *(relative(w[i - n], self.sizes[i], missing[i]) for i in own))
            length = hypot(*zeta) if is_last else hypot(*w[own.start - n:])
            amount = length * norm + sum(abs(a) * level_norms[row.level] for a, row in zip(w[:own.start - n], rows))
            size = amount * (1.0 + fine * coarse / length) if length else coarse * norm
            terms = [[a * row.a[j] for a, row in zip(w, rows, strict=True)] + [zeta[j]] * is_last for j in range(n)]
            forces = [(sum(parts), hypot(*parts, x)) for parts, x in zip(terms, self.x)]
            note("sums", *(relative(a, rounded + 0.001 * size, b) for a, (b, rounded) in zip(h, forces, strict=True)))
            forces += [(-a * norm, amount) for a, norm in zip(w, self.norms[n:])]
            for i, (force, rounded) in enumerate(forces):
                side, (low, high), is_own = 1 if force > 0 else -1, self.bounds[i], i >= own.start
                if i < n or low < high:  # An equation has any multiplier.
                    if all(abs(a) <= TOLERANCE * b for a, b, _ in self.forces[i]):
                        self.forces[i].append((force, size, rounded))
                    away = relative(max(0, side * ((high if force > 0 else low) - values[i])), self.sizes[i])
                    if not is_own and (i, -side) not in proven:  # Otherwise higher optima are at the other bound.
                        note("signs", min(relative(force, size), away))
                    if away <= TOLERANCE and abs(force) > NOT_ZERO * max(amount, NOT_ZERO * coarse * norm):
                        proven.add((i, side))  # No optimum of this level leaves the bound.

class Check:
    """The checks of one answer. `largest`: the relative error of each check that the status claims."""
    def __init__(self, request, answer):
        claimed = {"optimal": CHECKS, "not_certified": ["certificate", "velocity"], "failed": []}[answer["solver"]["status"]]
        self.request, self.answer, self.largest = request, answer, dict.fromkeys(claimed, 0.0)
        self.velocity, residual = numbers(answer["joint_velocity"]), answer["solver"]["kkt_residual"]
        self.method, self.is_closed = request.get("method") or "strict_reverse_priority", request.get("solver") == "closed_form"
        named = lambda what, all: {a["name"] if a.get("name") is not None else f"{what} {k}": a for k, a in enumerate(all, 1)}
        self.tasks, self.hard = named("task", request["tasks"]), named("inequality", request.get("inequalities", []))
        has_scaled = any(task.get("scale") for task in request["tasks"])  # Then equations need not have names.
        self.scaled = {name for name, task in self.tasks.items() if has_scaled and all(a == b for a, b in bounds_of(task))}
        self.fine = min(1.0, max(FINE, (residual or 0.0) / TOLERANCE))
        given = claimed and answer.get("certificate") or {"problems": [], "answer": []}
        problems = dict(enumerate(Problem(raw, self.note, self.fine) for raw in given["problems"]))
        self.problems = list(problems.values())
        self.parts = [(problems[part["problem"]], *numbers([part["weight"]])) for part in given["answer"]]
        self.note("certificate", 0.0 if self.parts else inf)
        self.note("status", residual is None or not 0 <= residual <= TOLERANCE)
        if not self.parts:
            self.largest = {check: error for check, error in self.largest.items() if check == "certificate"}
        else:
            self.check_plan(self.problems)
            self.check_velocity()
            self.check_active()

    def note(self, check, *errors):
        """Keeps the largest error of a check."""
        if check in self.largest:
            self.largest[check] = max(self.largest[check], *(float(error) if error >= 0 else inf for error in errors))

    def planned(self):
        """Returns the rows of the method's problems, with None for what the request does not state."""
        rows_of = lambda name, task: [Row((name, i), task.get("jacobian") and numbers(task["jacobian"][i]), ends)
                                      for i, ends in enumerate(bounds_of(task))]
        is_solved = lambda rows: not self.is_closed or all(row.ends[0] == row.ends[1] for row in rows)
        tasks, hard = list(filter(is_solved, map(rows_of, self.tasks, self.tasks.values()))), []
        for name, given in {} if self.is_closed else self.hard.items():  # Their rows have length one.
            a, norm = given.get("coefficients"), Fraction(hypot(*given.get("coefficients", [])) or 1.0)
            hard.append(Row(name, a and [p / norm for p in numbers(a)], a and (-inf, Fraction(given["upper"]) / norm)))
        lower = [[row._replace(is_kept=True) for row in sum(tasks[k + 1:], [])] for k in range(len(tasks))]
        stages = [[a, b if self.method == "reverse_priority" else []] for a, b in zip(tasks, lower)][::-1] or [[]]
        stages = [tasks] if self.method in ("strict_reverse_priority", "task_priority") else stages
        stages = [[sum(tasks, [])]] if self.method in ("pseudoinverse", "damped_least_squares") else stages
        stages[-1] = [hard, *stages[-1]]
        return [[row._replace(level=k) for k, level in enumerate(filter(None, levels)) for row in level]
                for levels in stages]

    def check_plan(self, problems):
        """Checks that the problems are those of the request, where it states them."""
        plan, before = self.planned(), self.request.get("null_space_velocity") or [0] * len(self.velocity)
        is_exact, is_whole = not (self.request.get("damping") or self.scaled), len(problems) == len(plan)
        named = lambda rows: [row for row in rows if is_exact or row.key and row.key[0] not in self.scaled]
        names = lambda rows: [(row.key, self.scaled or row.level) for row in named(rows)]
        if not is_exact:  # Targets and references are those of the certificate. The other parts are not named.
            plan, problems = plan[-1:], [part for part, _ in self.parts if names(part.rows) == names(plan[-1])][:1]
        elif not is_whole:  # Lower stages may be left out if all rows are independent: they can be met.
            plan, rows = plan[-1:], [row for row in problems[-1].rows if row.key not in self.hard]
            is_met = all(row.ends[0] == row.ends[1] for row in rows) and are_independent([row.a for row in rows])
            self.note("plan", not is_met or self.method != "reverse_priority")
        self.note("rows", any(abs(end) != inf for problem in problems[:-1] for ends in problem.box for end in ends))
        first, self.main = (problems or [self.parts[0][0]])[0], problems[-1] if problems else self.parts[0][0]
        is_right = [names(problem.rows) for problem in problems] == list(map(names, plan))
        self.note("plan", not is_right, is_exact and self.parts != [(self.main, 1)])
        before = numbers(before) if is_exact and isinstance(before, list) else first.reference
        for problem, rows in zip(problems, plan):
            size = hypot(*before, *problem.reference)
            self.note("rows", relative(hypot(*map(sub, before, problem.reference)), size))
            for row, (_, a, ends, _, is_kept) in zip(named(problem.rows), named(rows)):
                errors = map(sub, row.a, a + [0] * (len(row.a) - len(a))) if a else []
                self.note("rows", relative(hypot(*errors), hypot(*row.a)))
                if is_kept and is_whole:  # A stage keeps what the stage before achieved.
                    value = sum(map(mul, row.a, before))
                    ends = (value, value) if ends[0] == ends[1] else (min(ends[0], value), max(ends[1], value))
                scale, ends = hypot(*row.a) * size if is_kept else 0.0, ends if ends and is_exact else row.ends
                self.note("rows", *(relative(a, abs(float(b)) + scale, b) for a, b in zip(row.ends, ends)))
            before = problem.x

    def check_velocity(self):
        """Checks the joint velocity and what follows from it alone."""
        n, limits, (parts, weights) = len(self.velocity), self.request.get("limits"), zip(*self.parts)
        box = self.main.box[:n] if self.request.get("robot") and limits != "none" else [(-inf, inf)] * n
        box = [(-inf, inf)] * n if self.is_closed else bounds_of(limits) if isinstance(limits, dict) else box
        self.note("rows", any(problem.box[:n] != box for problem in parts))
        self.note("velocity", relative(sum(weights), 1.0, 1), inf if min(weights) < 0 else 0.0)
        for j, (value, ends) in enumerate(zip(self.velocity, box, strict=True)):
            total, size = sum(weight * part.x[j] for part, weight in self.parts), hypot(*(part.x[j] for part in parts))
            self.note("velocity", relative(value, size, total - excess(total, *ends)), excess(value, *ends) and inf)
        rows = {row.key: row.a[:n] for problem in [*self.problems, self.main] for row in problem.rows}
        for (name, task), found in zip(self.tasks.items(), self.answer["tasks"], strict=True):
            achieved, ends = numbers(found["achieved"]), bounds_of(task)
            missing = [excess(value, *pair) for value, pair in zip(achieved, ends, strict=True)]
            self.note("achieved", relative(found["residual_norm"], hypot(*achieved, *missing), hypot(*missing)))
            stated = (name, task.get("velocity") or found.get("requested"))
            self.note("achieved", 0.0 if (found.get("name", name), found.get("requested", stated[1])) == stated else inf)
            for i, value in enumerate(achieved):
                a = numbers(task["jacobian"][i]) if task.get("jacobian") else rows.get((name, i))
                terms = list(map(mul, a, self.velocity)) if a else [value]
                self.note("achieved", relative(value, hypot(*terms), sum(terms)))

    def check_active(self):
        """Checks that active limits and rows are reached and have their multipliers, and that none is left out."""
        main, n, answer = self.main, len(self.velocity), self.answer
        places = {row.key: i for i, row in enumerate(main.rows, len(main.x))}
        unlisted, seen = {*range(n), *places.values()} if len(self.parts) == 1 else set(), set()
        listed = [([j for j in range(n) if self.request.get("robot") or given["joint"] == f"j{j + 1}"], given, 1.0)
                  for given in answer["active_limits"]]  # A robot's joints have names that are not in the input.
        listed += [([i := places[task["name"], given["row"]]], given, main.norms[i])
                   for task in answer["tasks"] for given in task.get("active_rows", [])]
        listed += [([places[given["name"]]], given, hypot(*self.hard[given["name"]].get("coefficients", [])))
                   for given in answer.get("active_inequalities", [])]
        for candidates, given, norm in listed:
            found = {inf: -1}
            for i in set(candidates) - seen:
                value = self.velocity[i] if i < n else sum(map(mul, main.rows[i - len(main.x)].a, self.velocity))
                bound = main.bounds[i][(sign := {"lower": -1, "upper": 1}[given.get("side", "upper")]) > 0]
                forces = [entry for part, _ in self.parts if i < n or part is main for entry in part.forces[i]]
                errors = [relative(given["multiplier"] * norm, abs(float(force)) + self.fine * rounded, abs(force))
                          for force, _, rounded in forces if force * sign >= 0]
                if not norm or given["multiplier"] == 0.0 and main.bounds[i][0] == main.bounds[i][1]:
                    errors = [0.0]  # A plane's norm is not in the input. A pinned joint is listed in any case.
                away = relative(max(0, sign * (bound - value)), main.sizes[i])
                found[max(min(errors, default=inf), away, relative(given.get("value", bound), 1.0, bound))] = i
            self.note("active", min(found))
            seen.add(found[min(found)])
            stated = self.hard.get(given.get("name"), {}).get("upper", given.get("bound"))  # of an inequality
            self.note("active", 0.0 if given.get("bound", stated) == stated else inf)
        self.note("active", 0.0, *(relative(*main.forces[i][-1][:2]) for i in unlisted - seen if main.forces[i]))

def examine(texts):
    """Checks a request and its answer, or one text with both. Returns why it cannot be read, errors and failed checks."""
    try:
        parts = list(map(read, texts, ("request", "answer") if len(texts) == 2 else ("line",)))
        if len(parts) == 1:
            if wrong := misfit(parts[0], {"request": OBJECT, "answer": OBJECT}, "line"):
                raise ValueError(wrong)
            parts = [parts[0]["request"], parts[0]["answer"]]
        check_form(*parts)
        largest = Check(*parts).largest
        return "", largest, [check for check, error in largest.items() if not error <= CHECKS[check][1]]
    except KeyError as error:
        return f"cannot be read: the answer names {error.args[0]!r}, which is neither in the request nor in the certificate", {}, []
    except ArithmeticError:
        return "cannot be read: a number is too large", {}, []
    except RecursionError:
        return "cannot be read: the text has too many levels of lists and objects", {}, []
    except (AttributeError, LookupError, TypeError, ValueError) as error:
        return f"cannot be read: {error}", {}, []

def main(paths):
    """Runs the program; returns its exit status."""
    texts = [open(0 if path == "-" else path, encoding="utf-8").read() for path in paths]
    jobs = [[line] for line in texts[0].split("\n") if line.strip()] if len(texts) == 1 else [texts]
    # Processes take longer to start than a few answers need. Without a file they could not start where Python does not fork.
    is_file = os.path.exists(getattr(sys.modules["__main__"], "__file__", None) or "")
    results = multiprocessing.Pool().map(examine, jobs, chunksize=16) if is_file and len(jobs) > 16 else [*map(examine, jobs)]
    print(end="".join(f"answer {place}: {unread or 'the certificate does not hold: ' + ', '.join(failed)}\n"
                      for place, (unread, _, failed) in enumerate(results, 1) if unread or failed))
    for check, (what, allowed) in CHECKS.items():
        if found := [errors[check] for _, errors, _ in results if check in errors]:  # Some answer claims this.
            print(f"{'holds' if max(found) <= allowed else 'FAILS'} {max(found):8.1e} of {allowed:5.0e}  {check}: {what}")
    unread, _, broken = (sum(map(bool, part)) for part in zip(*results)) if results else (0, 0, 0)
    if silent := sum(not (unread or errors) for unread, errors, _ in results):
        print(f"claim nothing that can be checked, such as `failed`: {silent}")
    print(f"answers: {len(results)}, certificate does not hold: {broken}, cannot be read: {unread}")
    return 1 if broken else 2 if unread or not results else 0

if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]) if len(sys.argv) in (2, 3) else print(__doc__) or 2)
    except (OSError, ValueError) as error:
        sys.exit(print(f"cannot be read: {error}", file=sys.stderr) or 2)
