"""Changes right answers by 1e-6 and counts which changes check.py notices: changes.py LINES COUNT.

LINES is a file with an object {"request": ..., "answer": ...} on each line. COUNT answers of the status `optimal` are changed.
Prints a table, and the number of each answer with a change that is not noticed. Exit status: 0 enough is noticed; 1 if not, or if there are
fewer such answers.
"""

import copy
import json
import multiprocessing
import random
import sys
from math import hypot
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import check

SIZE = 1e-6
"""By how much a number is changed, relative to its size."""
NOTICED = 0.95
"""Share of the changes of each kind that must be noticed."""


def solved(answer):
    """Returns the problem whose solution is the answer."""
    return answer["certificate"]["problems"][answer["certificate"]["answer"][0]["problem"]]


def dot(a, x):
    """Returns a·x."""
    return sum(p * q for p, q in zip(a, x))


def move(answer, j, step):
    """Moves a joint and computes residuals, the multipliers of unknowns and the achieved velocities again."""
    problem = solved(answer)
    problem["solution"][j] += step
    answer["joint_velocity"] = x = problem["solution"]
    rows = [row for level in problem["levels"] for row in zip(level["rows"], level["lower"], level["upper"])]
    start = 0
    for k, (level, pair) in enumerate(zip(problem["levels"] + [None], problem["multipliers"])):
        end = start + len(level["rows"]) if level else start
        if pair:
            for i in range(start, end):
                a, low, high = rows[i]
                value = dot(a, x)
                pair["rows"][i] = low - value if low is not None and value < low else min(0, high - value) if high is not None else 0
            pair["unknowns"] = [sum(w * row[0][i] for w, row in zip(pair["rows"], rows)) for i in range(len(x))]
            if not level:
                pair["unknowns"] = [h + a - b for h, a, b in zip(pair["unknowns"], problem["reference"], x)]
        start = end
    for task in answer["tasks"]:
        found = {name["row"]: a for level in problem["levels"] for a, name in zip(level["rows"], level["names"]) if name.get("task") == task["name"]}
        task["achieved"] = [dot(found[i], x) if i in found else value for i, value in enumerate(task["achieved"])]


def matters(problem, pair, part, i):
    """Returns whether a multiplier is more than rounding in the sums that it is a part of."""
    rows = [row for level in problem["levels"] for row in level["rows"]]
    terms = [[w * row[j] for w, row in zip(pair["rows"], rows)] + [problem["reference"][j], problem["solution"][j]]
             for j in range(len(problem["solution"]))]
    if part == "unknowns":
        return abs(pair[part][i]) > 1e-5 * hypot(*terms[i])
    return any(abs(own[i]) > 1e-5 * hypot(*own) for own in terms)


def changes(random, request, answer):
    """Yields (what, request, answer) with one change that makes the answer wrong."""
    copies = lambda: (copy.deepcopy(request), copy.deepcopy(answer))
    n, speed = len(answer["joint_velocity"]), hypot(*answer["joint_velocity"])
    step = SIZE * speed * random.choice([-1, 1])
    if speed:
        j = random.randrange(n)
        asked, given = copies()
        given["joint_velocity"][j] += step
        yield "joint velocity", asked, given
        asked, given = copies()
        solved(given)["solution"][j] += step
        given["joint_velocity"][j] += step
        yield "joint velocity and solution", asked, given
        asked, given = copies()
        move(given, j, step)
        yield "joint velocity, and all that follows from it", asked, given
    for k, pair in enumerate(solved(answer)["multipliers"]):
        for part in ("rows", "unknowns") if pair else ():
            i = random.randrange(len(pair[part]) or 1)
            if pair[part] and matters(solved(answer), pair, part, i):
                asked, given = copies()
                solved(given)["multipliers"][k][part][i] *= 1 + SIZE
                yield f"multiplier of {part}", asked, given
    for i, limit in enumerate(answer["active_limits"]):
        if limit["multiplier"] > 0:
            asked, given = copies()
            j = int(limit["joint"][1:]) - 1
            solved(given)[limit["side"]][j] += step or SIZE
            yield "bound in the certificate", asked, given
            asked["limits"][limit["side"]][j] += step or SIZE
            yield "active bound", asked, given
            asked, given = copies()
            given["active_limits"][i]["multiplier"] *= 1 + SIZE
            yield "multiplier of a limit", asked, given
            asked, given = copies()
            del given["active_limits"][i]
            yield "limit not listed", asked, given
    levels = solved(answer)["levels"]
    asked, given = copies()
    problem = solved(given)
    if not levels:
        return
    del problem["levels"][-1], problem["multipliers"][-2]
    problem["multipliers"][-1] = problem["multipliers"][-1] and {
        **problem["multipliers"][-1], "rows": problem["multipliers"][-1]["rows"][:sum(len(level["rows"]) for level in levels[:-1])]}
    # The rows of a scaled task have no names, so that its levels can be left out.
    if not any(task.get("scale") for task in request["tasks"]):
        yield "level left out", asked, given
    if len(levels) > 1 and len(levels[0]["rows"]) == len(levels[1]["rows"]):
        asked, given = copies()
        solved(given)["levels"][:2] = levels[1::-1]
        yield "levels swapped", asked, given
    asked, given = copies()
    given["solver"]["kkt_residual"] = 1e-8
    yield "status", asked, given


def examine(job):
    """Changes the answer of a line; returns its number and [(what, whether it is noticed)]."""
    number, line = job
    pair = json.loads(line)
    made = changes(random.Random(number), pair["request"], pair["answer"])
    return number, [(what, bool(any(check.examine([json.dumps(part) for part in changed])[::2]))) for what, *changed in made]


def main(path, count):
    """Runs the program; returns its exit status."""
    lines = Path(path).read_text(encoding="utf-8").splitlines()
    jobs = [(number, line) for number, line in enumerate(lines, 1) if '"status":"optimal"' in line]
    # An average of several problems has no single multipliers.
    jobs = [(number, line) for number, line in jobs if len(json.loads(line)["answer"]["certificate"]["answer"]) == 1]
    if len(jobs) < int(count):
        print(f"{count} answers were to be changed; only {len(jobs)} are optimal and no average")
        return 1
    jobs = random.Random(0).sample(jobs, int(count))
    with multiprocessing.Pool() as pool:
        results = pool.map(examine, jobs, chunksize=8)
    table = {}
    print(f"{len(jobs)} answers were changed:")
    for number, found in results:
        for what, is_noticed in found:
            made, missed = table.setdefault(what, ([], []))
            made.append(number)
            missed += [] if is_noticed else [number]
    for what, (made, missed) in sorted(table.items()):
        print(f"{len(made):6} {100 * (1 - len(missed) / len(made)):6.2f} % noticed  {what}; not: {sorted(missed)[:12]}")
    return int(any(len(missed) > (1 - NOTICED) * len(made) for made, missed in table.values()))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) == 3 else print(__doc__) or 2)
