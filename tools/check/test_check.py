"""Tests of check.py: right answers pass, changed ones do not. Run `python3 tools/check/test_check.py`."""

import io
import json
import random
import subprocess
import sys
import tempfile
import unittest
from contextlib import redirect_stderr, redirect_stdout
from fractions import Fraction
from math import hypot
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import check
from changes import changes
from reference import certificate, dot, solve

METHODS = ["strict_reverse_priority", "reverse_priority", "task_priority", "singularity_robust", "pseudoinverse"]


def random_request(random):
    """Returns a problem of up to four joints with own Jacobians: dependent and zero rows, pinned joints, infinite bounds."""
    n, method = random.choice([2, 3, 3, 4]), random.choice(METHODS)
    whole = random.random() < 0.3
    entry = (lambda: random.randint(-2, 2)) if whole else (lambda: round(random.uniform(-2, 2), 3))
    tasks, rows = [], 0
    for _ in range(random.randint(1, 3)):
        scale = 1 if whole else random.choice([1, 1, 1e-3, 1e3])
        jacobian = [[entry() * scale for _ in range(n)] for _ in range(random.choice([1, 1, 2]))]
        if random.random() < 0.2 and tasks:
            nearly = random.choice([0, 0, 1e-6])
            jacobian[0] = [a + nearly * entry() for a in random.choice(tasks)["jacobian"][0]]
        target = [entry() * scale * random.choice([1, 1, 1e-6, 1e6] if not whole else [1]) for _ in jacobian]
        task = {"jacobian": jacobian, "velocity": target}
        if random.random() < 0.25 and rows < 1:
            rows += 1
            ends = {"lower": [target[0]], "upper": [target[0] + scale]}
            task = {"jacobian": jacobian[:1], random.choice(["lower", "upper"]): [target[0]], **random.choice([ends, {}, {}])}
        if random.random() < 0.3:
            task["name"] = f"own {len(tasks)}"
        tasks.append(task)
    width = lambda: random.choice([0, 1]) if whole else round(random.uniform(0, 1), 2) * random.choice([1, 1, 1, 0])
    limits = random.choice(["none", *[{"lower": [-width() for _ in range(n)], "upper": [width() for _ in range(n)]}] * 4])
    request = {"certificate": True, "method": method, "tasks": tasks, "limits": limits}
    if random.random() < 0.2 and rows < 1:
        request["inequalities"] = [{"kind": "joints", "coefficients": [entry() for _ in range(n)], "upper": abs(entry())}]
    if random.random() < 0.3:
        request["null_space_velocity"] = [entry() for _ in range(n)]
    return request


def planned(request, stage, before):
    """Returns a problem of the method in fractions and the names of its rows. `stage`: the task, or None for all."""
    tasks, n, levels = request["tasks"], len(request["tasks"][0]["jacobian"][0]), []
    for k, task in enumerate(tasks):
        count, name = len(task["jacobian"]), task.get("name", f"task {k + 1}")
        low, high = (task.get("velocity") or task.get(side) or [None] * count for side in ("lower", "upper"))
        exact = lambda value: None if value is None else Fraction(value)
        levels.append([(list(map(Fraction, a)), exact(b), exact(c), {"task": name, "row": i})
                       for i, (a, b, c) in enumerate(zip(task["jacobian"], low, high))])
    if request["method"] == "pseudoinverse":
        levels = [sum(levels, [])]
    elif stage is not None:
        lower = []
        for a, b, c, name in sum(levels[stage + 1:], []):
            value = Fraction(float(dot(a, before)))
            ends = (value, value) if b == c else (b and min(b, value), c and max(c, value))
            lower.append((a, *ends, name))
        levels = [levels[stage], lower if request["method"] == "reverse_priority" else []]
    box = [(None, None)] * n
    if not stage:
        hard = []
        for given in request.get("inequalities", []):
            norm = hypot(*given["coefficients"]) or 1.0
            row = [Fraction(a / norm) for a in given["coefficients"]]
            hard.append((row, None, Fraction(given["upper"] / norm), {"inequality": "inequality 1"}))
        levels.insert(0, hard)
        if request["limits"] != "none":
            box = list(zip(*(map(Fraction, request["limits"][side]) for side in ("lower", "upper"))))
    levels = [level for level in levels if level]
    problem = {"box": box, "reference": before, "levels": [[row[:3] for row in level] for level in levels]}
    return problem, [[row[3] for row in level] for level in levels]


def answer_to(request):
    """Returns the answer to a request, with its certificate."""
    n = len(request["tasks"][0]["jacobian"][0])
    x, problems = list(map(Fraction, request.get("null_space_velocity", [0] * n))), []
    staged = request["method"] in ("reverse_priority", "singularity_robust")
    for stage in reversed(range(len(request["tasks"]))) if staged else [None]:
        problem, names = planned(request, stage, x)
        x, multipliers = solve(problem)
        x = list(map(Fraction, map(float, x)))
        problems.append(certificate(problem, names, x, multipliers))
    given = [pair for pair in multipliers if pair]
    first = lambda values: next((value for value in values if value), 0)
    tasks = []
    for k, task in enumerate(request["tasks"]):
        values = [dot(map(Fraction, a), x) for a in task["jacobian"]]
        low, high = (task.get("velocity") or task.get(side) or [None] * len(values) for side in ("lower", "upper"))
        missing = [max(0, 0 if b is None else b - v, 0 if c is None else v - c) for v, b, c in zip(values, low, high)]
        tasks.append({"name": task.get("name", f"task {k + 1}"), "achieved": list(map(float, values)),
                      "residual_norm": hypot(*missing), "active_rows": []})
    active, inequalities = [], []
    for j, (low, high) in enumerate(problem["box"]):
        multiplier = first(h[j] for _, h in given)
        if multiplier or low == high is not None:
            side = "lower" if multiplier < 0 else "upper"
            value = float(low if multiplier < 0 else high)
            active.append({"joint": f"j{j + 1}", "side": side, "value": value, "multiplier": abs(float(multiplier))})
    rows = [(row, name) for level, own in zip(problem["levels"], names) for row, name in zip(level, own)]
    for i, ((_, low, high), name) in enumerate(rows):
        multiplier = -first(w.get(i, 0) for w, _ in given)
        if low != high and multiplier:
            entry = {"side": "lower" if multiplier < 0 else "upper", "multiplier": abs(float(multiplier))}
            if "inequality" in name:
                stated = request["inequalities"][0]
                entry["multiplier"] /= hypot(*stated["coefficients"])
                inequalities.append({"name": name["inequality"], "bound": stated["upper"], "multiplier": entry["multiplier"]})
            else:
                next(task for task in tasks if task["name"] == name["task"])["active_rows"].append({"row": name["row"], **entry})
    return {"joint_velocity": list(map(float, x)), "tasks": tasks, "active_limits": active, "active_inequalities": inequalities,
            "violated_limits": [], "solver": {"status": "optimal", "kkt_residual": 1e-16},
            "certificate": {"problems": problems, "answer": [{"problem": len(problems) - 1, "weight": 1.0}]}}


def verdict(request, answer):
    """Returns the failed checks."""
    message, found, failed = check.examine([json.dumps(request), json.dumps(answer)])
    return [message] if message else [f"{name} {found[name]:.1e}" for name in failed]


class Answers(unittest.TestCase):
    """Answers of the reference."""

    def test_right_answers_pass_and_changed_ones_do_not(self):
        missed, made = {}, {}
        for seed in range(COUNT):
            source = random.Random(seed)
            request = random_request(source)
            answer = answer_to(request)
            if COUNT <= 1000: self.assertEqual(verdict(request, answer), [], f"seed {seed}")
            elif verdict(request, answer): print(seed, verdict(request, answer))
            for what, asked, given in changes(source, request, answer):
                made[what] = made.get(what, 0) + 1
                if not verdict(asked, given):
                    missed.setdefault(what, []).append(seed)
        print({what: (count, missed.get(what, [])[:12]) for what, count in made.items()})


def solved():
    """Returns a request with an active limit and its answer."""
    request = {"certificate": True, "method": "task_priority", "limits": {"lower": [-1, -1], "upper": [1, 1]},
               "tasks": [{"name": "a\u2028b", "jacobian": [[1, 0]], "velocity": [2]}]}
    return request, answer_to(request)


def printed(*texts):
    """Runs the program on files with these texts; returns its exit status and what it prints."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder, str(k)) for k in range(len(texts))]
        for path, text in zip(paths, texts):
            path.write_text(text, encoding="utf-8")
        with redirect_stdout(io.StringIO()) as out:
            return check.main(list(map(str, paths))), out.getvalue()


class Attacks(unittest.TestCase):
    """Answers that are made to deceive, and inputs that are no answers."""

    def test_an_answer_cannot_bring_its_own_request(self):
        request, answer = solved()
        other = json.loads(json.dumps(request)) | {"limits": {"lower": [-3, -3], "upper": [3, 3]}}
        text = json.dumps(answer)[:-1] + ', "request": ' + json.dumps(request) + "}"
        self.assertEqual(printed(json.dumps(request), text)[0], 0)
        self.assertEqual(printed(json.dumps(other), text)[0], 1)
        line = '{"request": %s, "answer": %s, "request": %s}' % tuple(map(json.dumps, (other, answer, request)))
        self.assertEqual(printed(line)[0], 2)

    def test_without_a_method_the_order_is_strict(self):
        """As in the service. The answer of reverse priority, in three stages, is not that of the strict order."""
        rows = [([1, 1], 2), ([1, 0], 0), ([0, 1], 0)]
        request = {"certificate": True, "tasks": [{"jacobian": [a], "velocity": [b]} for a, b in rows]}
        level = lambda k, kept=None: {"rows": [rows[k][0]], "lower": [kept or rows[k][1]], "upper": [kept or rows[k][1]],
                                      "names": [{"task": f"task {k + 1}", "row": 0}]}
        free = {"lower": [None, None], "upper": [None, None]}
        # Both lower tasks cannot be met beside the first one; the strict order meets the second.
        strict = {"solution": [0, 2], "reference": [0, 0], "levels": [level(0), level(1), level(2)], **free,
                  "multipliers": [None, None, {"rows": [-2, 2, 2], "unknowns": [0, 0]}, {"rows": [0, 0, 2], "unknowns": [0, 0]}]}
        certificate = {"problems": [strict], "answer": [{"problem": 0, "weight": 1.0}]}
        tasks = [{"achieved": [value], "residual_norm": abs(value - b)} for value, (_, b) in zip((2, 0, 2), rows)]
        answer = {"joint_velocity": [0, 2], "solver": {"status": "optimal", "kkt_residual": 0}, "tasks": tasks,
                  "active_limits": [], "certificate": certificate}
        named = request | {"method": "strict_reverse_priority"}
        told = printed(json.dumps(named), json.dumps(answer))[1]
        self.assertEqual(printed(json.dumps(request), json.dumps(answer))[1], told)
        other = printed(json.dumps(request | {"method": "reverse_priority"}), json.dumps(answer))[1]
        self.assertNotIn("does not hold: plan", told)
        self.assertIn("plan", other)

    def test_lower_stages_have_no_box_and_their_tasks_have_rows(self):
        free, pinned = [None, None], [0, 0]
        level = lambda k, value: {"rows": [[1 - k, k]], "lower": [value], "upper": [value],
                                  "names": [{"task": f"task {k + 1}", "row": 0}]}
        request = {"certificate": True, "method": "reverse_priority",
                   "tasks": [{"jacobian": [[1, 0]], "velocity": [1]}, {"jacobian": [[0, 1]], "velocity": [1]}]}
        last = {"solution": [1, 0], "reference": [0, 0], "lower": free, "upper": free, "levels": [level(0, 1), level(1, 0)],
                "multipliers": [None, None, {"rows": [1, 0], "unknowns": [0, 0]}]}
        first = {"solution": [0, 0], "reference": [0, 0], "lower": pinned, "upper": pinned, "levels": [level(1, 1)],
                 "multipliers": [{"rows": [1], "unknowns": [0, 1]}, None]}
        answer = {"joint_velocity": [1, 0], "solver": {"status": "optimal", "kkt_residual": 0}, "active_limits": [],
                  "tasks": [{"achieved": [1], "residual_norm": 0}, {"achieved": [0], "residual_norm": 1}],
                  "certificate": {"answer": [{"problem": 1, "weight": 1}], "problems": [first, last]}}
        exit_status, words = printed(json.dumps(request), json.dumps(answer))
        self.assertEqual(exit_status, 1)
        self.assertIn("does not hold: rows", words)

    def test_a_missing_certificate_is_told_and_nothing_else_holds(self):
        request, answer = solved()
        for status in ("optimal", "not_certified"):
            bare = answer | {"certificate": None, "solver": answer["solver"] | {"status": status}}
            exit_status, words = printed(json.dumps(request), json.dumps(bare))
            self.assertEqual(exit_status, 1)
            self.assertIn("does not hold: certificate", words)
            self.assertNotIn("holds", words.replace("does not hold", ""))

    def test_what_is_no_finite_number_is_refused(self):
        request, answer = solved()
        for value in ("NaN", "-Infinity", '"1"', "[1]"):
            for number in ('"kkt_residual": 1e-16', '"multiplier": 1.0', '"weight": 1.0'):
                self.assertIn(number, json.dumps(answer))
                text = json.dumps(answer).replace(number, number.split(":")[0] + ": " + value)
                self.assertEqual(printed(json.dumps(request), text)[0], 2, (number, value))

    def test_what_is_wrong_with_a_field_is_told_in_one_line(self):
        def changed(root, *place, value):
            parts = dict(zip(("request", "answer"), json.loads(json.dumps(solved()))))
            *outer, last = place
            at = parts[root]
            for name in outer:
                at = at[name]
            if value is MISSING:
                del at[last]
            else:
                at[last] = value
            return printed(*map(json.dumps, parts.values()))
        first = ("certificate", "problems", 0)
        for place, value, text in (
                (("request", "tasks"), MISSING, "`request.tasks` is missing"),
                (("request", "tasks"), None, "`request.tasks` must be a list, not null"),
                (("request", "tasks", 0), 7, "`request.tasks[0]` must be an object, not 7"),
                (("request", "tasks", 0, "velocity", 0), "2", '`request.tasks[0].velocity[0]` must be a finite number, not "2"'),
                (("request", "tasks", 0, "velocity"), [],
                 "`request.tasks[0].velocity` has 0 entries, and `answer.tasks[0].achieved` has 1"),
                (("request", "limits", "lower"), [1], "`request.limits.lower` has 1 entries, and `answer.joint_velocity` has 2"),
                (("answer", "solver"), MISSING, "`answer.solver` is missing"),
                (("answer", "solver", "status"), "fine",
                 '`answer.solver.status` must be failed or not_certified or optimal, not "fine"'),
                (("answer", "joint_velocity", 0), True, "`answer.joint_velocity[0]` must be a finite number, not true"),
                (("answer", "joint_velocity", 0), 10**400, "`answer.joint_velocity[0]` must be a finite number, not 1000"),
                (("answer", "joint_velocity"), [0.5], "has 2 entries, and `answer.joint_velocity` has 1"),
                (("answer", "joint_velocity"), [], "has 2 entries, and `answer.joint_velocity` has 0"),
                (("request", "joint_position"), [0.0], "`request.joint_position` has 1 entries, and `answer.joint_velocity` has 2"),
                (("request", "tasks", 0, "jacobian"), [[1.0]], "`request.tasks[0].jacobian[0]` has 1 entries, and `answer.joint"),
                (("answer", "tasks"), [], "`answer.tasks` has 0 entries, and `request.tasks` has 1"),
                (("answer", "active_limits", 0, "side"), "left", '`answer.active_limits[0].side` must be lower or upper, not "left"'),
                (("answer", "certificate", "answer", 0, "problem"), 5,
                 "`answer.certificate.answer[0].problem` is 5, which is the index of no problem"),
                (("answer", *first, "levels", 0, "rows", 0), [1],
                 "levels[0].rows[0]` has 1 entries, and `answer.certificate.problems[0].solution` has 2"),
                (("answer", *first, "levels", 0, "names"), [], "levels[0].names` has 0 entries"),
                (("answer", *first, "multipliers"), [None], "multipliers` has 1 entries"),
                (("answer", *first, "reference"), {}, "reference` must be a list, not {}")):
            status, words = changed(*place, value=value)
            self.assertEqual(status, 2, words)
            self.assertTrue(words.startswith("answer 1: cannot be read: `"), words)
            self.assertIn(text, words.splitlines()[0])

    def test_an_answer_of_a_robot_has_all_its_joints(self):
        request, answer = solved()
        tasks = [{name: task[name] for name in task if name != "jacobian"} for task in request["tasks"]]
        request = {**request, "robot": "mine", "limits": "none", "tasks": tasks}
        for short in ([], answer["joint_velocity"][:1]):
            status, words = printed(json.dumps(request), json.dumps({**answer, "joint_velocity": short}))
            self.assertEqual(status, 2, words)
            self.assertIn(f"`answer.certificate.problems[0].solution` has 2 entries for {len(short)} joints", words)

    def test_an_unreadable_text_is_named(self):
        request, answer = map(json.dumps, solved())
        for texts, place in (((request, "{"), "answer"), (("[", answer), "request"), (("{",), "line")):
            status, words = printed(*texts)
            self.assertEqual(status, 2)
            self.assertTrue(words.startswith(f"answer 1: cannot be read: the {place} is not valid JSON: "), words)
        self.assertIn("`line.answer` is missing", printed('{"request": {}}')[1])
        self.assertIn("too many levels", printed("[" * 100000, answer)[1])

    def test_a_field_that_does_not_matter_may_have_any_form(self):
        request, answer = solved()
        request["tasks"][0].update(name=None, lower=None, upper=None)
        answer["tasks"][0]["name"] = "task 1"
        for level in answer["certificate"]["problems"][0]["levels"]:
            level["names"] = [name | {"task": "task 1"} for name in level["names"]]
        self.assertEqual(verdict(request | {"why": [], "robot": None, "damping": None}, answer | {"why": 3}), [])

    def test_names_sides_and_entries_count(self):
        request, answer = solved()
        limit, task = answer["active_limits"][0], answer["tasks"][0]
        self.assertEqual(verdict(request, answer), [])
        for changed in ({"active_limits": [limit, limit]}, {"active_limits": [limit | {"side": "foo"}]}, {"active_limits": []},
                        {"tasks": [task | {"name": "c"}]}, {"tasks": [task | {"requested": [1]}]},
                        {"solver": {"status": "optimal", "kkt_residual": -1.0}},
                        {"certificate": answer["certificate"] | {"answer": [{"problem": -1, "weight": 1.0}]}}):
            self.assertNotEqual(verdict(request, answer | changed), [], changed)

    def test_lines_end_at_line_feeds_alone(self):
        request, answer = solved()
        line = json.dumps({"request": request, "answer": answer}, ensure_ascii=False)
        self.assertEqual(printed(f"{line}\n\n{line}\n")[1].splitlines()[-1],
                         "answers: 2, certificate does not hold: 0, cannot be read: 0")

    def test_it_ends_where_python_does_not_fork(self):
        request, answer = solved()
        line = json.dumps({"request": request, "answer": answer})
        main = 'if __name__ == "__main__":\n'
        program = Path(check.__file__).read_text()
        self.assertEqual(program.count(main), 1)
        program = program.replace(main, f'{main}    multiprocessing.set_start_method("spawn")\n')
        with tempfile.TemporaryDirectory() as folder:
            lines, file = Path(folder, "lines.jsonl"), Path(folder, "spawned.py")
            lines.write_text(40 * f"{line}\n")
            file.write_text(program)
            for name in (str(file), "-"):
                run = subprocess.run([sys.executable, name, str(lines)], input=program, timeout=60, capture_output=True, text=True)
                self.assertEqual((run.returncode, run.stdout.splitlines()[-1]),
                                 (0, "answers: 40, certificate does not hold: 0, cannot be read: 0"), run.stderr)

    def test_nothing_holds_where_nothing_is_claimed(self):
        request, answer = solved()
        failed = answer | {"solver": {"status": "failed", "kkt_residual": None}}
        self.assertNotIn("holds", printed(json.dumps(request), json.dumps(failed))[1])
        for text in ("", "{}", "7"):
            status, words = printed(text)
            self.assertEqual(status, 2)
            self.assertNotIn("holds", words)


MISSING = object()
COUNT = int(sys.argv.pop()) if sys.argv[-1].isdigit() else 120

if __name__ == "__main__":
    unittest.main(warnings="ignore")
