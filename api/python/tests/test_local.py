"""The service in this process: answers equal to those over HTTP to the last bit, arguments, errors, threads."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from conftest import example
from numpy.typing import NDArray

import revprio
from revprio import Client, Controller, ControllerConfig, InvalidError, Local, NotFoundError, ResolveTask, StepAnswer

Q = np.array([2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2])
PUSH = revprio.push("x", 15)
METHODS = [
    "reverse_priority", "strict_reverse_priority", "task_priority", "singularity_robust", "damped_least_squares",
    "pseudoinverse",
]  # fmt: skip
AXES = np.array(["x", "y", "z", "rx", "ry", "rz"])
LIMITS = ["none", "velocity", "position_velocity", "position_velocity_acceleration"]


def without_time(answer: revprio.ResolveAnswer | StepAnswer) -> dict[str, Any]:
    fields: dict[str, Any] = answer.model_dump(mode="json", exclude={"elapsed_us"})
    return fields


def random_posture(rng: np.random.Generator, robot: revprio.Robot) -> NDArray[np.float64]:
    lower, upper = np.array(
        [(-3, 3) if joint.position_limit is None else joint.position_limit for joint in robot.joints], dtype=float
    ).T
    posture: NDArray[np.float64] = rng.uniform(0.95 * lower, 0.95 * upper)
    return posture


def random_problem(rng: np.random.Generator, robots: list[revprio.Robot]) -> dict[str, Any]:
    robot = robots[rng.integers(len(robots))]
    axes = rng.permutation(AXES)[: rng.integers(1, 7)]
    split = rng.integers(1, len(axes) + 1)
    speed = 10 ** rng.uniform(-3, 1)
    tasks = [
        {"axes": part.tolist(), "velocity": (speed * rng.standard_normal(len(part))).tolist()}
        for part in (axes[:split], axes[split:])
        if len(part)
    ]
    return {
        "robot": robot.name,
        "joint_position": random_posture(rng, robot).tolist(),
        "joint_velocity": (0.1 * rng.standard_normal(len(robot.joints))).tolist(),
        "period_s": float(rng.choice([0.001, 0.004, 0.01])),
        "tasks": tasks,
        "method": str(rng.choice(METHODS)),
        "solver": str(rng.choice(["auto", "auto", "qp", "closed_form"])),
        "limits": str(rng.choice(LIMITS)),
        "damping": {"threshold": 0.05, "max_factor": 0.1} if rng.random() < 0.5 else None,
    }


def test_random_problems_are_resolved_as_over_http_to_the_last_bit(client: Client) -> None:
    rng = np.random.default_rng(1)
    robots = client.robots()
    limited = 0
    for _ in range(300):
        problem = random_problem(rng, robots)
        here = revprio.resolve(**problem)
        assert without_time(here) == without_time(client.resolve(**problem)), problem
        limited += bool(here.active_limits)
    assert limited > 50, "too few problems reach a limit"


def test_a_batch_equals_single_problems_and_the_batch_over_http(client: Client) -> None:
    rng = np.random.default_rng(2)
    # Other tests register robots in this process.
    robots = client.robots()
    problems = [revprio.ResolveRequest.model_validate(random_problem(rng, robots)) for _ in range(100)]
    problems.append(revprio.ResolveRequest(tasks=[ResolveTask(axes="x", velocity=1)]))
    here, there = revprio.resolve_batch(problems), client.resolve_batch(problems)
    assert isinstance(here[-1], revprio.Problem)
    for ours, other in zip(here, there, strict=True):
        assert ours.model_dump(mode="json", exclude={"elapsed_us"}) == other.model_dump(
            mode="json", exclude={"elapsed_us"}
        )


def random_controller(rng: np.random.Generator) -> dict[str, Any]:
    laws: list[dict[str, Any]] = [
        {"kind": "force", "inertia": 15, "damping": 150, "target_force": {"kind": "constant", "value": 30}},
        {
            "kind": "velocity",
            "target_velocity": {"kind": "sine", "amplitude": 0.5, "offset": 0, "angular_frequency_rad_s": 20},
        },
        {"kind": "pose", "gain": 5, "target_displacement": {"kind": "constant", "value": 0.3}},
    ]
    return {
        "robot": str(rng.choice(["sawyer_dh", "panda", "ur5e"])),
        "period_s": 0.004,
        "method": str(rng.choice(METHODS)),
        "solver": str(rng.choice(["auto", "auto", "qp"])),
        "limits": str(rng.choice(LIMITS)),
        "tasks": [
            {"name": "first", "axes": ["x"], "law": laws[rng.integers(3)]},
            {"name": "hold", "axes": ["y", "z", "rx", "ry", "rz"], "law": {"kind": "pose", "gain": 5}},
        ],
    }


def wall(depth: float) -> NDArray[np.float64]:
    """Returns the wrench on a wall of 10⁴ N/m."""
    return np.array([1e4 * max(depth, 0.0), 0, 0, 0, 0, 0])


@pytest.mark.parametrize("seed", range(6))
def test_closed_loops_equal_those_of_sessions_and_stateless_steps_to_the_last_bit(client: Client, seed: int) -> None:
    rng = np.random.default_rng(seed)
    config = ControllerConfig.model_validate(random_controller(rng))
    fields = {name: getattr(config, name) for name in config.model_fields_set}
    q = random_posture(rng, client.robot(config.robot))
    start = revprio.kinematics(robot=config.robot, joint_position=q).pose.position
    with Controller(**fields) as here, client.session(**fields) as session:
        stateless = [client.stateless(**fields), revprio.stateless(**fields)]
        for period in range(60):
            tool = revprio.kinematics(robot=config.robot, joint_position=q).pose.position
            wrench = wall(float(np.asarray(tool)[0] - np.asarray(start)[0] - 0.002))
            measured: dict[str, Any] = {} if period % 3 else {"joint_velocity": np.zeros_like(q)}
            answers = [loop.step(q, wrench=wrench, **measured) for loop in (here, session, *stateless)]
            bits = {answer.joint_velocity.tobytes() for answer in answers}
            assert len(bits) == 1, period
            assert without_time(answers[0]) == without_time(answers[1])
            q = q + config.period_s * answers[0].joint_velocity
    assert np.isfinite(q).all()


def moving(name: str, velocity: float) -> revprio.ControllerTask:
    law = revprio.VelocityLaw(target_velocity=revprio.ConstantProfile(value=velocity))
    return revprio.ControllerTask(name=name, axes="x", law=law)


def test_a_changed_controller_moves_over_at_the_acceleration_limits_here_and_in_sessions(client: Client) -> None:
    joints = client.robot("sawyer").joints
    largest_change = 0.001 * np.array([joint.acceleration_limit for joint in joints], dtype=float)
    fields: dict[str, Any] = {"robot": "sawyer", "period_s": 0.001, "limits": "velocity"}
    forth, back = ([moving(name, velocity)] for name, velocity in [("a", 0.2), ("b", -0.2)])
    with Controller(tasks=forth, **fields) as here, client.session(tasks=forth, **fields) as session:
        stream = session.stream()
        last = here.step(Q).joint_velocity
        assert (last == session.step(Q).joint_velocity).all()
        for loop in (here, stream):
            loop.change(tasks=back)
        for _ in range(100):
            velocity = here.step(Q).joint_velocity
            assert (velocity == stream.step(Q).joint_velocity).all()
            assert (np.abs(velocity - last) <= largest_change * (1 + 1e-9)).all()
            last = velocity
        assert here.config.tasks[0].name == session.config.tasks[0].name == "b"
        assert session.status().controller.tasks[0].name == "b"
        assert last @ here.step(Q).joint_velocity > 0
        for loop in (here, session):
            with pytest.raises(InvalidError, match="drive"):
                loop.change(drive=revprio.JointDrive(lag_s=0, delay_periods=0))
            with pytest.raises(InvalidError, match="no_such_field"):
                loop.change(no_such_field=1)
            loop.step(Q)
    with pytest.raises(revprio.RevprioError, match="session"):
        client.stateless(tasks=forth, **fields).change(tasks=back)


@pytest.mark.parametrize("service", ["here", "there"])
def test_the_same_program_runs_here_and_with_a_service(service: str, url: str) -> None:
    rp = revprio.connect() if service == "here" else revprio.connect(url)
    task = ResolveTask(axes="x", velocity=0.05)
    answer = rp.resolve(robot="sawyer_dh", joint_position=Q, tasks=[task])
    assert answer.tasks[0].achieved == pytest.approx([0.05])
    with rp.session(robot="sawyer_dh", period_s=0.001, tasks=PUSH) as arm:
        assert arm.joints == [f"j{i}" for i in range(1, 8)]
        assert arm.warnings == []
        assert arm.step(Q, wrench=np.zeros(6)).sequence == 0
        assert arm.step(Q, wrench=np.zeros(6)).sequence == 1
    rp.close()


def test_an_answer_reads_its_explanation_when_it_is_used() -> None:
    with Controller(robot="sawyer_dh", period_s=0.001, tasks=PUSH) as arm:
        answer = arm.step(Q, wrench=np.zeros(6))
        velocity = answer.joint_velocity
        assert type(answer) is not StepAnswer
        assert isinstance(answer, StepAnswer)
        assert answer.solver.status == "optimal"
        assert type(answer) is StepAnswer
        assert answer.joint_velocity is velocity
        for copied in (pickle.loads(pickle.dumps(arm.step(Q, wrench=np.zeros(6)))), arm.step(Q, wrench=np.zeros(6))):
            assert [task.name for task in copied.tasks] == ["push", "hold"]
        # The tool approaches, so an answer may be valid for less than the 100 ms of the controller.
        assert "valid_for_ms=" in repr(arm.step(Q, wrench=np.zeros(6)))
        dumped = arm.step(Q, wrench=np.zeros(6)).model_dump()
        assert set(dumped) == set(StepAnswer.model_fields)
        changed = arm.step(Q, wrench=np.zeros(6)).model_copy(update={"valid_for_ms": 5})
        assert changed.valid_for_ms == 5
        assert len(changed.tasks) == 2


def test_arrays_of_answers_belong_to_the_caller() -> None:
    with Controller(robot="sawyer_dh", period_s=0.001, tasks=PUSH) as arm:
        first = arm.step(Q, wrench=np.zeros(6))
        kept = first.joint_velocity.copy()
        first.joint_velocity[:] = 9
        second = arm.step(Q, wrench=np.zeros(6))
        assert not (second.joint_velocity == 9).any()
        assert not (kept == 9).any()
        with pytest.raises(ValueError, match="read-only"):
            second.braking_deceleration[0] = 1


def test_states_are_arrays_lists_mappings_or_views() -> None:
    names = [f"j{i}" for i in range(1, 8)]
    wide = np.zeros((7, 3))
    wide[:, 1] = Q
    wrench = revprio.Wrench(force=[1, 2, 3], torque=[0, 0, 0])
    velocities = set()
    forms: list[Any] = [Q, list(Q), tuple(Q), dict(zip(names, Q, strict=True)), wide[:, 1], Q.astype(">f8")]
    for form in forms:
        for force in (wrench, [1, 2, 3, 0, 0, 0], np.array([1.0, 2, 3, 0, 0, 0]), np.array([1, 2, 3, 0, 0, 0])):
            with Controller(robot="sawyer_dh", period_s=0.001, tasks=PUSH) as arm:
                velocities.add(arm.step(form, joint_velocity=np.zeros(7), wrench=force).joint_velocity.tobytes())
    assert len(velocities) == 1


@pytest.mark.parametrize(
    ("arguments", "pointer"),
    [
        ({"joint_position": Q[:3]}, "/joint_position"),
        ({"joint_position": "a"}, "/joint_position"),
        ({"joint_position": np.zeros((7, 1))}, "/joint_position"),
        ({"joint_position": {"j1": 1.0}}, "/joint_position"),
        ({"joint_position": {"j1": "a"}}, "/joint_position"),
        ({"joint_position": Q * np.nan}, "/joint_position/0"),
        ({"joint_velocity": [1]}, "/joint_velocity"),
        ({"wrench": None}, "/wrench"),
        ({"wrench": [1, 2]}, "/wrench"),
        ({"wrench": np.full(6, np.inf)}, "/wrench/force/0"),
        ({"time_s": float("nan")}, "/time_s"),
    ],
)
def test_a_wrong_state_is_refused_by_its_field_and_the_controller_goes_on(
    arguments: dict[str, Any], pointer: str
) -> None:
    with Controller(robot="sawyer_dh", period_s=0.001, tasks=PUSH) as arm:
        with pytest.raises(InvalidError) as refused:
            arm.step(**{"joint_position": Q, "wrench": np.zeros(6), **arguments})
        assert refused.value.pointer == pointer
        assert arm.step(Q, wrench=np.zeros(6)).solver.status == "optimal"


def test_a_state_with_its_own_sequence_number_is_stepped_once() -> None:
    state = revprio.State(sequence=5, time_s=0, joint_position=Q, wrench=revprio.Wrench(force=[0] * 3, torque=[0] * 3))
    with Controller(robot="sawyer_dh", period_s=0.001, tasks=PUSH) as arm:
        assert arm.step_state(state).sequence == 5
        assert arm.step(Q, wrench=np.zeros(6)).sequence == 6
        with pytest.raises(revprio.ConflictError):
            arm.step_state(state)


def test_errors_are_those_of_the_service(client: Client) -> None:
    for service in (revprio.connect(), client):
        with pytest.raises(NotFoundError, match="there is no robot"):
            service.robot("nobody")
        with pytest.raises(InvalidError) as refused:
            service.resolve(tasks=[ResolveTask(axes="x", velocity=1)])
        assert refused.value.pointer == "/tasks/0/axes"
        with pytest.raises(InvalidError) as unknown:
            service.session(robot="nobody", period_s=0.001, tasks=PUSH)
        assert unknown.value.pointer == "/robot"


def test_a_call_that_needs_a_server_says_so() -> None:
    with pytest.raises(NotFoundError, match="revprio serve"):
        Local().call(revprio.routes.SCENARIOS())


def test_registered_robots_are_known_to_the_process() -> None:
    robot = revprio.register_robot(**example("robot"))
    try:
        assert robot.name in [known.name for known in revprio.robots()]
        assert len(revprio.robot(robot.name).joints) == len(robot.joints)
    finally:
        revprio.delete_robot(robot.name)


def test_other_calls_equal_those_over_http(client: Client) -> None:
    for body, method in (("kinematics", "kinematics"), ("stability", "stability")):
        here, there = (getattr(service, method)(**example(body)) for service in (Local(), client))
        assert here.model_dump_json() == there.model_dump_json()
    state = revprio.StepRequest.model_validate({**example("step"), "memory": None})
    fields = {name: getattr(state, name) for name in state.model_fields_set}
    assert without_time(revprio.step(**fields)) == without_time(client.step(**fields))


def test_controllers_in_eight_threads_compute_as_alone() -> None:
    def run(start: float) -> bytes:
        q, path = Q + start, []
        with Controller(robot="sawyer_dh", period_s=0.001, tasks=PUSH) as arm:
            for _ in range(200):
                q = q + 0.001 * arm.step(q, wrench=np.zeros(6)).joint_velocity
                path.append(q)
        return np.array(path).tobytes()

    starts = [0.01 * i for i in range(8)]
    alone = [run(start) for start in starts]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(run, starts)) == alone
