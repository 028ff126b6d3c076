"""Short forms, presets, error texts and help."""

import inspect
import itertools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import revprio
from revprio import AddressError, AsyncClient, Client, EnvironmentAxis, InvalidError, ResolveTask, models, presets
from revprio.states import StateNumbering

Q = np.array([0.3, -0.6, 0.2, 1.4, 0.1, 0.9, 0.0])


def test_one_axis_and_one_number_are_lists_of_one() -> None:
    task = ResolveTask(axes="x", velocity=0.05)
    assert task.json_bytes() == b'{"axes":["x"],"velocity":[0.05]}'
    assert ResolveTask(jacobian=[1, 2], velocity=1).json_bytes() == b'{"jacobian":[[1.0,2.0]],"velocity":[1.0]}'
    assert ResolveTask(axes="x", lower=0.1).json_bytes() == b'{"axes":["x"],"lower":[0.1]}'
    # One gain for all axes stays one number.
    law = models.PoseLaw(gain=5)
    assert b'"gain":5.0' in models.ControllerTask(name="t", axes="x", law=law).json_bytes()


@pytest.mark.parametrize(
    ("fields", "pointer", "text"),
    [
        ({"velocitie": 1}, "/velocitie", "did you mean `velocity`"),
        ({"axes": "q"}, "/axes/0", "'q' is unknown; give 'x', 'y'"),
        ({"axes": 3}, "/axes", ""),
        ({"velocity": "a"}, "/velocity", "give a number, a list or an array"),
        ({"velocity": [1, float("nan")]}, "/velocity", "finite"),
        ({"jacobian": [[1, 2], [3]]}, "/jacobian", "rows of equal length"),
        ({"scale": "perhaps"}, "/scale", "is not True or False"),
    ],
)
def test_a_wrong_field_is_named_without_words_of_other_programs(
    fields: dict[str, Any], pointer: str, text: str
) -> None:
    makers: list[Callable[[], ResolveTask]] = [
        lambda: ResolveTask(**fields),
        lambda: ResolveTask.model_validate(fields),
    ]
    for make in makers:
        with pytest.raises(InvalidError) as refused:
            make()
        assert refused.value.pointer == pointer
        assert text in refused.value.detail
        assert "pydantic" not in f"{refused.value} {refused.value.__cause__}"
        assert isinstance(refused.value, ValueError)


def test_the_place_of_a_wrong_field_is_that_of_the_service() -> None:
    law = {"kind": "force", "inertia": 15, "target_force": {"kind": "constant", "value": "a"}}
    task = {"name": "t", "axes": ["x"], "law": law}
    with pytest.raises(InvalidError) as refused:
        models.ControllerConfig.model_validate({"robot": "r", "period_s": 1, "tasks": [task]})
    assert refused.value.pointer in ("/tasks/0/law/damping", "/tasks/0/law/target_force/value")
    with pytest.raises(InvalidError) as unknown:
        models.ControllerTask.model_validate({**task, "law": {"kind": "forc"}})
    assert unknown.value.pointer == "/law"
    assert "'force'" in unknown.value.detail


def test_a_name_in_a_pointer_is_escaped() -> None:
    sensors = {"a/b~": {"bias": "heavy"}}
    with pytest.raises(InvalidError) as refused:
        models.ControllerConfig.model_validate({"robot": "r", "period_s": 1, "tasks": [], "wrench_sensors": sensors})
    assert refused.value.pointer == "/wrench_sensors/a~1b~0/bias"


def test_positional_fields_are_refused_by_name() -> None:
    with pytest.raises(TypeError, match=r"ResolveTask\(field=value"):
        ResolveTask("x")  # type: ignore[call-arg]


def test_a_forgotten_scheme_is_added_and_another_one_is_named(url: str) -> None:
    with Client(url.removeprefix("http://")) as client:
        assert client.url == url
        assert client.is_ready()
    assert AsyncClient("127.0.0.1:8080/").url == "http://127.0.0.1:8080"
    for wrong in ("ftp://arm", "http://", "", "ws://127.0.0.1:8080", "http://a:b"):
        with pytest.raises(AddressError, match=r"http://127\.0\.0\.1:8080"):
            Client(wrong)


def contact(damping: float, lag_s: float) -> models.StabilityAnswer:
    return revprio.stability(
        inertia=15, damping=damping, environment=models.EnvironmentAxis(stiffness=1e5), period_s=0.001, lag_s=lag_s
    )


@pytest.mark.parametrize("lag_s", [0.0, 0.005, 0.02])
def test_the_gains_of_a_push_keep_a_factor_of_two_of_the_stability_margin(lag_s: float) -> None:
    loop = {"environment_stiffness": 1e5, "lag_s": lag_s, "delay_periods": 0}
    push, hold = revprio.push_with_damping(axis="z", newtons=15, hold="rest", **loop)  # type: ignore[arg-type]
    assert push.axes == ["z"]
    assert hold.axes == ["x", "y", "rx", "ry", "rz"]
    damping = float(np.asarray(push.law.damping))  # type: ignore[union-attr]
    margin = contact(damping, lag_s)
    assert margin.stable
    assert damping >= 2 * (margin.smallest_damping or 0) * (1 - 1e-6)
    assert 15 / damping <= 0.1 + 1e-12


def pushes() -> Iterator[tuple[dict[str, float], dict[str, float]]]:
    """Returns arguments of `push`, and those of them that `stability` takes."""
    for period_s, lag_s, delay_periods, velocity_measured in itertools.product(
        (0.001, 0.005, 0.02), (0.0, 0.01, 0.03), (0, 2, 3), (True, False)
    ):
        loop = {
            "period_s": period_s,
            "lag_s": lag_s,
            "delay_periods": delay_periods,
            "velocity_measured": velocity_measured,
        }
        for environment_stiffness, newtons in itertools.product((1e2, 1e3, 1e4, 1e5), (5, 100)):
            yield {**loop, "environment_stiffness": environment_stiffness, "newtons": newtons}, loop


def test_every_push_is_stable_in_its_contact_in_softer_ones_and_in_free_space() -> None:
    pushed, refused = 0, set()
    for arguments, loop in pushes():
        try:
            law = revprio.push_with_damping("z", hold=None, **arguments)[0].law  # type: ignore[arg-type]
        except InvalidError as error:
            refused.add(error.pointer)
            continue
        pushed += 1
        damping = float(np.asarray(law.damping))  # type: ignore[union-attr]
        assert arguments["newtons"] / damping <= 0.1 + 1e-12
        for share in (0.0, 0.001, 0.03, 0.3, 1.0):
            environment = EnvironmentAxis(stiffness=share * arguments["environment_stiffness"])
            margin = revprio.stability(inertia=15, damping=damping, environment=environment, **loop)  # type: ignore[arg-type]
            assert margin.stable, (arguments, damping, share, margin)
    assert pushed > 150
    assert refused == {"/environment_stiffness", "/approach_speed"}


def test_a_push_between_two_close_ends_is_in_their_middle() -> None:
    loop = {"period_s": 0.02, "lag_s": 0.01, "delay_periods": 0, "velocity_measured": False}
    damping = revprio.push_with_damping("z", 15, environment_stiffness=5e4, **loop)[0].law.damping  # type: ignore[arg-type, union-attr]
    environment = EnvironmentAxis(stiffness=5e4)
    margin = revprio.stability(inertia=15, damping=float(np.asarray(damping)), environment=environment, **loop)  # type: ignore[arg-type]
    low, high = margin.smallest_damping or 0, margin.largest_damping or 0
    assert 1 < high / low < 4
    assert float(np.asarray(damping)) == pytest.approx(np.sqrt(low * high))


@pytest.mark.parametrize(
    ("arguments", "pointer"),
    [
        ({"newtons": 100, "approach_speed": 0.001, "period_s": 0.02, "delay_periods": 0}, "/approach_speed"),
        ({"newtons": 15, "approach_speed": 0}, "/approach_speed"),
        ({"newtons": float("nan")}, "/newtons"),
        ({"newtons": 0, "lag_s": 0, "delay_periods": 0}, "/newtons"),
        ({"newtons": 15, "inertia": 0.01, "lag_s": 0.1, "delay_periods": 5}, "/environment_stiffness"),
    ],
)
def test_a_push_that_no_damping_permits_is_refused(arguments: dict[str, float], pointer: str) -> None:
    with pytest.raises(InvalidError) as refusal:
        revprio.push_with_damping("z", **arguments)  # type: ignore[arg-type]
    assert refusal.value.pointer == pointer


@pytest.mark.parametrize(
    ("arguments", "pointer"),
    [
        ({"newtons": 0}, "/newtons"),
        ({"newtons": float("nan")}, "/newtons"),
        ({"newtons": 15, "approach_speed": 0}, "/approach_speed"),
        ({"newtons": 15, "stiffest": -1}, "/stiffest"),
        ({"newtons": 15, "max_force": float("inf")}, "/max_force"),
    ],
)
def test_a_push_with_impossible_numbers_is_refused(arguments: dict[str, float], pointer: str) -> None:
    with pytest.raises(InvalidError) as refusal:
        revprio.push("z", **arguments)  # type: ignore[arg-type]
    assert refusal.value.pointer == pointer


@pytest.mark.parametrize("wrong", ["a", [1.0, 2.0], 1j])
def test_a_wrong_time_is_refused(wrong: object) -> None:
    arm = revprio.Controller(robot="sawyer_dh", period_s=0.001, tasks=revprio.push("x", 15))
    with pytest.raises(InvalidError, match="time_s"):
        arm.step(Q, time_s=wrong)  # type: ignore[arg-type]
    with pytest.raises(InvalidError, match="time_s"):
        StateNumbering(0.001).state(Q, None, None, wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["joint_position", "joint_velocity", "wrench"])
def test_complex_numbers_are_refused(name: str) -> None:
    wrong = {"joint_position": Q, "joint_velocity": Q, "wrench": np.zeros(6)}
    wrong[name] = wrong[name] + 1j
    arm = revprio.Controller(robot="sawyer_dh", period_s=0.001, tasks=revprio.push("x", 15))
    with pytest.raises(InvalidError, match=name):
        arm.step(**wrong)  # type: ignore[arg-type]
    with pytest.raises(InvalidError):
        StateNumbering(0.001).state(wrong["joint_position"], wrong["joint_velocity"], wrong["wrench"], None)


def test_presets_and_controllers_expect_the_same_drive() -> None:
    stated = inspect.getdoc(models.JointDrive) or ""
    assert f"default {presets.DELAY_PERIODS}." in stated
    assert f"Default {presets.LAG_S}." in stated
    for preset in (revprio.push, revprio.wipe, revprio.follow):
        defaults = {name: field.default for name, field in inspect.signature(preset).parameters.items()}
        assert (defaults["lag_s"], defaults["delay_periods"]) == (presets.LAG_S, presets.DELAY_PERIODS)


def test_a_length_prefers_the_position_or_the_orientation() -> None:
    """Both rows request more than the joints may give; the length decides which of them loses less."""
    q = np.array([0.3, -1.2, 1.6, -1.9, -1.57, 0.2])
    lost = {}
    for prefer in ("position", "balance", "orientation"):
        law = models.VelocityLaw(target_velocity=[3.0, 0, 0, 0, 3.0, 0])
        task = models.ControllerTask(name="hand", axes=["x", "y", "z", "rx", "ry", "rz"], law=law)
        length = revprio.characteristic_length(prefer)
        arm = revprio.Controller(robot="ur5e", period_s=0.01, tasks=[task], characteristic_length_m=length)
        missed = np.asarray(arm.step(q).tasks[0].achieved) - [3.0, 0, 0, 0, 3.0, 0]
        lost[prefer] = (np.linalg.norm(missed[:3]), np.linalg.norm(missed[3:]))
    assert lost["position"][0] < lost["balance"][0] <= lost["orientation"][0]
    assert lost["position"][1] > lost["balance"][1] >= lost["orientation"][1]
    assert revprio.characteristic_length("balance", reach_m=0.2) == pytest.approx(0.2)
    with pytest.raises(InvalidError, match="give `position`, `balance` or `orientation`"):
        revprio.characteristic_length("tilt")  # type: ignore[arg-type]


def test_warnings_about_a_controller_are_logged(client: Client, caplog: pytest.LogCaptureFixture) -> None:
    fields: dict[str, Any] = {"robot": "panda", "period_s": 0.001, "tasks": revprio.push(axis="z", newtons=-15)}
    for create in (revprio.Controller, client.session):
        caplog.clear()
        with create(**fields) as arm:
            assert not caplog.records
            arm.change(limits="velocity")
            assert len(arm.warnings) == 1
            assert [(record.name, record.message) for record in caplog.records] == [("revprio", arm.warnings[0])]
        with create(**fields, limits="velocity") as arm:
            assert [record.message for record in caplog.records] == 2 * arm.warnings


def test_what_is_no_measurement_and_no_robot_is_named() -> None:
    with pytest.raises(TypeError, match=r"'panda' is no robot; give what `revprio.robot"):
        revprio.Watchdog.of("panda")  # type: ignore[arg-type]
    watchdog = revprio.Watchdog.of(revprio.robot("sawyer_dh"))
    with (
        revprio.Controller(robot="sawyer_dh", period_s=0.01, tasks=revprio.push(axis="z", newtons=-15)) as arm,
        pytest.raises(TypeError, match=r"`read` returned ndarray; return a `revprio.Measurement"),
    ):
        revprio.drive(arm, lambda: Q, lambda _: None, watchdog=watchdog)  # type: ignore[arg-type, return-value]


@pytest.mark.parametrize("stiffness", [1e3, 1e4, 1e5])
def test_a_push_presses_on_walls_of_unknown_stiffness(stiffness: float) -> None:
    """The arm follows at once, faster than the default drive: that costs time only."""
    q = np.array([2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2])
    wall = float(np.asarray(revprio.kinematics(robot="sawyer_dh", joint_position=q).pose.position)[0]) + 0.001
    force, peak = 0.0, 0.0
    tasks = revprio.push("x", 15, approach_speed=0.01)
    with revprio.Controller(robot="sawyer_dh", period_s=0.002, tasks=tasks) as arm:
        for _ in range(2000):
            tool = np.asarray(revprio.kinematics(robot="sawyer_dh", joint_position=q).pose.position)
            force = stiffness * max(float(tool[0]) - wall, 0.0)
            peak = max(peak, force)
            answer = arm.step(q, wrench=[force, 0, 0, 0, 0, 0])
            q = q + arm.period_s * answer.joint_velocity
    contact = answer.tasks[0].contact[0]
    assert contact.state == "contact"
    assert contact.unavoidable_peak > 15
    assert force == pytest.approx(15, rel=0.02)
    assert peak < 1.1 * max(18, contact.unavoidable_peak * stiffness / 1e6)


@pytest.mark.parametrize("tilt", [0.0, 0.26])
def test_a_wipe_keeps_its_force_on_a_surface_with_friction(tilt: float) -> None:
    """The surface is tilted about y, and the friction coefficient is 0.3."""
    q, period_s = np.array([2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2]), 0.002
    normal = np.array([np.sin(tilt), 0, np.cos(tilt)])
    orientation = models.Orientation(w=np.cos(tilt / 2), x=0, y=np.sin(tilt / 2), z=0)
    frame = models.Pose(position=[0, 0, 0], orientation=orientation)
    tool = [np.asarray(revprio.kinematics(robot="sawyer_dh", joint_position=q).pose.position)]
    height, pressed = normal @ tool[0] - 0.001, []
    tasks = revprio.wipe("z", -15, "y", frame=frame)
    with revprio.Controller(robot="sawyer_dh", period_s=period_s, tasks=tasks) as arm:
        for _ in range(2000):
            tool.append(np.asarray(revprio.kinematics(robot="sawyer_dh", joint_position=q).pose.position))
            along = (tool[-1] - tool[-2]) / period_s
            along = along - normal * (normal @ along)
            speed = float(np.linalg.norm(along)) + 1e-12
            pressed.append(1e4 * max(float(height - normal @ tool[-1]), 0.0))
            force = -pressed[-1] * normal + 0.3 * pressed[-1] * np.tanh(speed / 0.005) * along / speed
            q = q + period_s * arm.step(q, wrench=[*force, 0, 0, 0]).joint_velocity
    way = np.array(tool)[:, 1] - tool[0][1]
    assert max(pressed) < 1.1 * 15
    assert np.ptp(pressed[-500:]) < 0.5
    assert np.mean(pressed[-500:]) == pytest.approx(15, abs=0.3)
    assert way.min() > -1e-3
    assert way.max() == pytest.approx(0.1, abs=1e-3)


@pytest.mark.parametrize(("first_s", "change_s"), [(0.0, 1.0), (3.14, None), (1.7e9, 1.0)])
def test_a_wipe_is_never_faster_than_stated(first_s: float, change_s: float | None) -> None:
    """Whether it replaces a push, or begins on a clock that is not zero; in free space."""
    q, period_s, speed = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8]), 0.004, 0.05
    begins_s = first_s + (change_s or 0.0)
    start_s = begins_s - first_s if first_s > 1e9 else begins_s
    wipe = revprio.wipe("z", -15, "x", speed=speed, start_time_s=start_s, period_s=period_s)
    tasks = wipe if change_s is None else revprio.push("z", -15, period_s=period_s)
    fastest = 0.0
    with revprio.Controller(robot="panda", period_s=period_s, tasks=tasks) as arm:
        for k in range(750):
            if change_s is not None and k == round(change_s / period_s):
                arm.change(tasks=wipe)
            answer = arm.step(q, wrench=[0, 0, 0, 0, 0, 0], time_s=first_s + k * period_s)
            if answer.tasks[1].name == "wipe":
                fastest = max(fastest, abs(answer.tasks[1].achieved[0]))
            q = q + period_s * answer.joint_velocity
    assert 0.9 * speed < fastest < 1.1 * speed


def test_a_wipe_that_begins_later_rests_until_then() -> None:
    """The sine of the motion has a start."""
    q, period_s, begins_s = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8]), 0.004, 1.0
    speeds: dict[bool, float] = {False: 0.0, True: 0.0}
    wipe = revprio.wipe("z", -15, "x", speed=0.05, start_time_s=begins_s, period_s=period_s)
    with revprio.Controller(robot="panda", period_s=period_s, tasks=wipe) as arm:
        for k in range(600):
            answer = arm.step(q, wrench=[0, 0, 0, 0, 0, 0], time_s=k * period_s)
            moves = k * period_s > begins_s
            speeds[moves] = max(speeds[moves], abs(answer.tasks[1].achieved[0]))
            q = q + period_s * answer.joint_velocity
    assert speeds[False] < 0.002
    assert 0.045 < speeds[True] < 0.055


@pytest.mark.parametrize(
    ("arguments", "pointer"),
    [
        ({"newtons": 0, "along": "y"}, "/newtons"),
        ({"newtons": 5, "along": "z"}, "/along"),
        ({"newtons": 5, "along": "rx"}, "/along"),
        ({"newtons": 5, "along": "y", "stroke_m": 0}, "/stroke_m"),
        ({"newtons": 5, "along": "y", "stroke_m": np.nan}, "/stroke_m"),
        ({"newtons": 5, "along": "y", "speed": 0}, "/speed"),
        ({"newtons": 5, "along": "y", "start_time_s": np.inf}, "/start_time_s"),
        ({"newtons": 5, "along": "y", "start_time_s": 1.7e9}, "/start_time_s"),
        ({"newtons": 5, "along": "y", "max_tilt_rad": 0}, "/max_tilt_rad"),
        ({"newtons": 5, "along": "y", "hold": ["z"]}, "/hold"),
        ({"newtons": 5, "along": "y", "hold": ["x", "y"]}, "/hold"),
        ({"newtons": 5, "along": "y", "hold": ["x", "x"]}, "/hold"),
    ],
)
def test_a_wipe_without_a_meaning_is_refused(arguments: dict[str, object], pointer: str) -> None:
    with pytest.raises(InvalidError) as refusal:
        revprio.wipe("z", **arguments)  # type: ignore[arg-type]
    assert refusal.value.pointer == pointer


def test_a_tool_follows_a_pose() -> None:
    start = revprio.kinematics(robot="sawyer_dh", joint_position=Q).pose
    w, x, y, z = (getattr(start.orientation, part) for part in "wxyz")
    target = np.eye(4)
    target[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    target[:3, 3] = np.asarray(start.position) + np.array([0.02, -0.03, 0.01])
    q = Q
    with revprio.Controller(robot="sawyer_dh", period_s=0.01, tasks=revprio.follow(target, period_s=0.01)) as arm:
        for _ in range(800):
            q = q + arm.period_s * arm.step(q).joint_velocity
    end = revprio.kinematics(robot="sawyer_dh", joint_position=q).pose
    np.testing.assert_allclose(np.asarray(end.position), target[:3, 3], atol=1e-6)
    assert abs(sum(getattr(end.orientation, part) * getattr(start.orientation, part) for part in "wxyz")) > 1 - 1e-9


def test_a_preset_refuses_what_is_no_pose_and_what_cannot_be_stable() -> None:
    for wrong in (np.eye(3), 2 * np.eye(4), np.diag([1, 1, -1, 1])):
        with pytest.raises(InvalidError, match="pose"):
            revprio.follow(wrong)
    assert len(revprio.push("x", 15, hold=None)) == 1
    assert revprio.push("x", 15, hold=["y"])[1].axes == ["y"]


def test_help_shows_fields_with_units_and_plain_types() -> None:
    text = inspect.getdoc(ResolveTask) or ""
    assert "- velocity: Task velocity ẋ_k, one entry per row, m/s and rad/s" in text
    assert "axes: OneOrMore[Axis] | None = None" in str(inspect.signature(ResolveTask))
    for function in (revprio.resolve, revprio.Controller.__init__, Client.session):
        assert "- tasks: The tasks, highest priority first" in (inspect.getdoc(function) or "")
        assert "PlainValidator" not in str(inspect.signature(function))
