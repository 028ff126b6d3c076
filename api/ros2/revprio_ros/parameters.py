"""The parameters of the node: declared with description and range, checked at the start, and constant from then on."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import revprio
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from revprio_ros.presets import PresetError, is_preset
from revprio_ros.presets import body as body_of

REVPRIO = "as the controller says"
SAME_FRAME = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
OUTPUTS = ("velocity", "trajectory", "both")
WRENCH_LAWS = ("contact", "force", "impedance", "hybrid")

PARAMETERS: dict[str, tuple[Any, str, tuple[float, float] | None]] = {
    "controller": (
        "",
        "`push ROBOT AXIS NEWTONS`, `wipe ROBOT AXIS NEWTONS ALONG`, JSON, or the path of a JSON file",
        None,
    ),
    "url": ("", "address of the service; empty: computes in this process", None),
    "token_file": ("", "file with the token of the service; empty: none", None),
    "period_s": (0.0, f"control period, s; 0: {REVPRIO}", (0.0, 0.1)),
    "wrench_convention": ("", f"on_environment or on_tool; empty: {REVPRIO}", None),
    "wrench_frame": ("", f"base or tool: the axes of the wrench; empty: {REVPRIO}", None),
    "use_wrench": (True, "whether the controller needs the wrench", None),
    "sensor_pose": (SAME_FRAME, "x, y, z, qx, qy, qz, qw of the sensor frame in the wrench_frame", None),
    "max_age_s": (0.05, "maximum age of joint_states, wrench and obstacles, s", (0.002, 0.1)),
    "base_frame": (
        "base",
        "frame_id of the base, in which poses and twists are given for tasks without `relative_to`",
        None,
    ),
    "tool_frame": ("tool0", "frame_id of the tool, for tasks with the frame `tool` and without `link`", None),
    "output": ("velocity", "velocity, trajectory or both", None),
    "command_joints": (
        [""],
        "joints of the velocity command in the order of the driver; ['']: those of the robot",
        None,
    ),
    "chunk_interval_s": (1 / 30, "time between two poses of a chunk, s", (0.001, 1.0)),
    "sign_check_force_n": (
        25.0,
        "force from which the sign of the wrench is checked, N; 0: not checked",
        (0.0, 1000.0),
    ),
    "sign_check_periods": (8, "periods of the check of the sign", (3, 100)),
}
"""Name: default, description, range."""


class ParameterError(ValueError):
    """A parameter has a wrong value; the text says which, and what to do."""


@dataclass(frozen=True)
class Settings:
    """The values of the parameters."""

    url: str
    token: str | None
    config: revprio.ControllerConfig
    max_age_s: float
    use_wrench: bool
    sensor_transform: Any | None
    base_frame: str
    tool_frame: str
    output: str
    command_joints: list[str]
    chunk_interval_s: float
    sign_check_force_n: float
    sign_check_periods: int


def read(node: Node) -> Settings:
    """Declares the parameters of a node and returns their values. Raises a `ParameterError`."""
    values = SimpleNamespace(**{name: declare(node, name) for name in PARAMETERS})
    if values.output not in OUTPUTS:
        raise wrong("output", values.output, f"is not one of {', '.join(OUTPUTS)}")
    if 0 < values.period_s < 0.001:
        raise wrong("period_s", values.period_s, "is shorter than 0.001 s; set it to the period of the driver")
    return Settings(
        url=values.url,
        token=token(values.token_file),
        config=controller(values),
        max_age_s=values.max_age_s,
        use_wrench=values.use_wrench,
        sensor_transform=transform(values.sensor_pose),
        base_frame=values.base_frame,
        tool_frame=values.tool_frame,
        output=values.output,
        command_joints=[joint for joint in values.command_joints if joint],
        chunk_interval_s=values.chunk_interval_s,
        sign_check_force_n=values.sign_check_force_n,
        sign_check_periods=values.sign_check_periods,
    )


def declare(node: Node, name: str) -> Any:
    """Declares a parameter and returns its value."""
    default, description, limits = PARAMETERS[name]
    descriptor = ParameterDescriptor(description=description, read_only=True)
    if limits is not None:
        kind = "integer_range" if isinstance(default, int) else "floating_point_range"
        bounds = IntegerRange if isinstance(default, int) else FloatingPointRange
        setattr(descriptor, kind, [bounds(from_value=limits[0], to_value=limits[1])])
    try:
        return node.declare_parameter(name, default, descriptor).value
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        given = node._parameter_overrides[name].value
        allowed = f" from {limits[0]} to {limits[1]}" if limits else ""
        kind = Parameter.Type.from_parameter_value(default).name.lower().replace("_", " ")
        raise wrong(name, given, f"must be a value of type {kind}{allowed}: {description}") from error


def wrong(name: str, value: object, what: str) -> ParameterError:
    """Returns the error of a parameter."""
    return ParameterError(f"parameter `{name}`: {value!r} {what}")


def controller(values: SimpleNamespace) -> revprio.ControllerConfig:
    """Returns the controller with the values that other parameters replace."""
    text = values.controller.strip()
    if not text:
        raise ParameterError(
            "parameter `controller` is empty; set it to a preset, to the path of a JSON file, or to JSON: "
            "-p controller:='push panda z -15'"
        )
    if is_preset(text):
        try:
            text = json.dumps(body_of(text, values.period_s))
        except PresetError as error:
            raise ParameterError(f"parameter `controller`: {error}") from error
    elif not text.startswith("{"):
        try:
            text = Path(text).read_text()
        except (OSError, UnicodeDecodeError) as error:
            raise ParameterError(f"parameter `controller`: cannot read the file {text}: {error}") from error
    try:
        body = json.loads(text)
    except ValueError as error:
        raise ParameterError(f"parameter `controller` is not valid JSON: {error}") from error
    replaced = {name: getattr(values, name) for name in ("period_s", "wrench_convention", "wrench_frame")}
    if isinstance(body, dict):
        body |= {name: value for name, value in replaced.items() if value}
    try:
        return revprio.ControllerConfig.model_validate(body)
    except revprio.InvalidError as error:
        place, detail = error.problem.pointer or "/", error.problem.detail
        raise ParameterError(
            f"parameter `controller`: {place}: {detail}; the fields are those of POST /v1/controllers"
        ) from error


def check_wrenches(config: revprio.ControllerConfig, tips: Sequence[revprio.RobotTip]) -> None:
    """Refuses a controller that needs the wrench of another tip than the first one, because the node sends no other."""
    tool = {name for tip in tips[:1] for name in (tip.name, tip.link)}
    laws = [task for task in config.tasks if task.link and getattr(task.law, "kind", None) in WRENCH_LAWS]
    needs = [(f"the law of task `{task.name}`", task.link) for task in laws]
    needs += [("`wrench_sensors`", tip) for tip in config.wrench_sensors or {}]
    for what, tip in needs:
        if tip not in tool:
            raise ParameterError(
                f"parameter `controller`: {what} needs the wrench of `{tip}`, and the node has that of "
                "the first tip only; leave it out, or step the controller in your own program, with `wrenches`"
            )


def token(path: str) -> str | None:
    """Returns the content of the token file."""
    if not path:
        return None
    try:
        return Path(path).read_text().strip()
    except (OSError, UnicodeDecodeError) as error:
        raise ParameterError(f"parameter `token_file`: cannot read the file {path}: {error}") from error


def transform(pose: list[float]) -> Any | None:
    """Returns the pose of the sensor frame with the fields of geometry_msgs/Transform."""
    if list(pose) == SAME_FRAME:
        return None
    if len(pose) != 7 or not abs(sum(q * q for q in pose[3:]) - 1) < 1e-3:
        what = "must be seven numbers: position x, y, z in m, then a quaternion x, y, z, w of unit length"
        raise wrong("sensor_pose", list(pose), what)
    rotation = dict(zip("xyzw", pose[3:]))
    return SimpleNamespace(translation=SimpleNamespace(**dict(zip("xyz", pose))), rotation=SimpleNamespace(**rotation))


def topic(task: str) -> str:
    """Returns the name of a task as a part of a topic: letters, digits and underscores."""
    name = re.sub(r"\W", "_", task, flags=re.ASCII)
    return f"_{name}" if name[:1].isdigit() else name
