"""Reads MuJoCo models (MJCF), from which robot descriptions in URDF are made."""

from __future__ import annotations

import os
from collections.abc import Container, Iterator, Mapping
from numbers import Real
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import mujoco

Array = NDArray[np.float64]
_Form = tuple[str, dict[str, str], Array]


def read_mjcf(
    model: str | os.PathLike[str] | mujoco.MjModel,
    velocity_limits: float | Mapping[str, float] | None = None,
) -> str:
    """Returns the kinematic tree of a MuJoCo model as URDF text, for `register_robot(urdf=…)`.

    Bodies and named sites become links, hinges and slides become joints. A joint keeps its position (`ref` included)
    and its range. A joint that an active `<equality>` couples to another one becomes a `mimic` joint, and one that it
    locks becomes fixed, with the joints that follow it. Ball joints and joints of closed kinematic loops cannot be
    part of a serial arm; they have the types `ball` and `closed_loop`. The world can close a loop too, but mocap
    bodies and free bodies do not. If nothing but a body with a free joint has joints, that body is the root;
    otherwise the root is `world`. Geoms that can collide, by their masks or by a `<pair>`, become `<collision>`
    elements, from which `shapes="fit"` of a registration makes capsules; meshes and ellipsoids become their bounding
    boxes, planes and height fields are left out. A link with visual geoms only has one of them as `<visual>`, so that
    the service lists it as uncovered. Free bodies and mocap bodies without other joints are left out, with all that
    they carry: they are fixed to no link. The text has no masses.

    Needs the package `mujoco`: `pip install revprio[mujoco]`.

    Args:
        model: An MJCF file, or a compiled model.
        velocity_limits: Maximum speed of all joints, or of each joint by its name, rad/s or m/s. MJCF has none. The
            registration needs one for each joint of the arm; its `limits` can state them too.

    Raises:
        ImportError: The package `mujoco` is not installed.
        ValueError: MuJoCo cannot compile the file, an `<equality>` couples two joints by a polynomial that is not
            linear, or `velocity_limits` names a joint that the model does not have.
        TypeError: `velocity_limits` is neither a number nor a mapping.

    """
    try:
        import mujoco  # noqa: PLC0415
    except ImportError as error:
        message = "MJCF files need the package `mujoco`: pip install revprio[mujoco]"
        raise ImportError(message) from error

    if isinstance(model, str | os.PathLike):
        try:
            model = mujoco.MjModel.from_xml_path(os.fspath(model))
        except ValueError as error:
            message = f"{os.fspath(model)}: {error}"
            raise ValueError(message) from error
    return _Tree(mujoco, model, velocity_limits).text()


class _Coupling(NamedTuple):
    """States the motion of a joint from its reference position: a polynomial of the motion of another joint.

    Without a leader, the motion is the first coefficient.
    """

    follower: int
    leader: int | None
    coefficients: list[float]


class _Tree:
    """The links and joints of a model. A placement is a 4 × 4 matrix."""

    def __init__(
        self, library: ModuleType, model: mujoco.MjModel, velocity_limits: float | Mapping[str, float] | None
    ) -> None:
        self.kinds, self.geoms = library.mjtJoint, library.mjtGeom
        self.model = model
        self.bodies = _names("body", [model.body(i).name for i in range(model.nbody)])
        self.joints = _names("joint", [model.joint(i).name for i in range(model.njnt)])
        self.link_names, self.joint_names = set(self.bodies), set(self.joints)
        self.links: dict[str, ET.Element] = {}
        self.speeds = self.speeds_of(velocity_limits)
        couplings = list(_couplings(library, model))
        self.locked = _locked(model, couplings)
        self.mimics = dict(_mimics(model, couplings, self.locked))
        self.jointed_trees = self.find_jointed_trees()
        self.loops = set(_loops(library, model))
        # The pairs of `<contact>` collide whatever the masks of their geoms say.
        self.paired = {*map(int, model.pair_geom1), *map(int, model.pair_geom2)}
        self.robot = ET.Element("robot", name=model.names[: model.names.index(b"\0")].decode() or "mujoco")

    def speeds_of(self, limits: float | Mapping[str, float] | None) -> Mapping[str, float]:
        if limits is None:
            return {}
        if isinstance(limits, Real):
            return dict.fromkeys(self.joints, float(limits))
        if not isinstance(limits, Mapping):
            message = f"`velocity_limits`: give one number, or numbers by the names of joints, not {limits!r}"
            raise TypeError(message)
        unknown = sorted(limits.keys() - set(self.joints))
        if unknown:
            message = f"`velocity_limits`: the model has no joint {unknown[0]}; its joints are {', '.join(self.joints)}"
            raise ValueError(message)
        return limits

    def text(self) -> str:
        roots, named = self.roots(), self.named()
        inside = set(roots)
        # A body comes after its parent.
        for body in range(self.model.nbody):
            if body in roots:
                self.link(self.bodies[body])
            elif body in named and int(self.model.body_parentid[body]) in inside and not self.is_loose(body):
                inside.add(body)
                self.body(body)
            else:
                continue
            self.sites(body)
        self.shapes()
        return ET.tostring(self.robot, encoding="unicode")

    def roots(self) -> list[int]:
        """Returns the world, if it carries joints, and the free bodies that carry joints."""
        free = {body for body in self.jointed_trees if self.is_free(body)}
        world = [0] if self.jointed_trees - free or not self.jointed_trees else []
        return world + sorted(free)

    def find_jointed_trees(self) -> set[int]:
        """Returns the bodies right below the world that carry joints, other than a free joint."""
        model = self.model
        jointed = {int(model.jnt_bodyid[joint]) for joint in range(model.njnt)}
        return {int(model.body_rootid[body]) for body in jointed if not self.is_free(body)}

    def named(self) -> set[int]:
        """Returns the bodies that have a name, a joint or a named site, and those that carry them."""
        model = self.model
        named = {body for body in range(model.nbody) if model.body(body).name or model.body_jntnum[body]}
        named |= {int(model.site_bodyid[site]) for site in range(model.nsite) if model.site(site).name}
        return {above for body in named for above in _ancestors(model, body)}

    def is_free(self, body: int) -> bool:
        first = self.model.body_jntadr[body]
        return bool(first >= 0 and self.model.jnt_type[first] == self.kinds.mjJNT_FREE)

    def is_loose(self, body: int) -> bool:
        """Tells whether a body is fixed to nothing and carries no joints: an object of the scene, or a mocap body."""
        return body not in self.jointed_trees and (self.is_free(body) or self.model.body_mocapid[body] >= 0)

    def body(self, body: int) -> None:
        """Writes a body and its joints. MuJoCo moves a body by its joints, one after the other."""
        first, count = self.model.body_jntadr[body], self.model.body_jntnum[body]
        placement = _placement(self.model.body_pos[body], self.model.body_quat[body])
        link, parent = self.bodies[body], self.bodies[self.model.body_parentid[body]]
        for joint in range(first, first + count):
            before, after = self.around(joint)
            if joint in self.locked:
                placement = placement @ before @ self.motion(joint, self.locked[joint]) @ after
                continue
            is_last = joint == first + count - 1 and np.array_equal(after, np.eye(4))
            child = link if is_last else _unused(f"{link}_{self.joints[joint]}", self.link_names)
            self.moving(joint, parent, child, placement @ before)
            parent, placement = child, after
        if parent != link:
            self.fixed(link, parent, placement)

    def around(self, joint: int) -> tuple[Array, Array]:
        """Returns the placement of a joint in the frame of its body, and what follows its motion.

        The motion is by position − `ref`, about an anchor that need not be the origin of the body.
        """
        anchor, reference = self.model.jnt_pos[joint], _reference(self.model, joint)
        if self.model.jnt_type[joint] == self.kinds.mjJNT_SLIDE:
            return np.eye(4), self.motion(joint, -reference)
        return _placement(anchor), self.motion(joint, -reference) @ _placement(-anchor)

    def motion(self, joint: int, position: float) -> Array:
        """Returns the placement that a joint makes at a position, rad or m, about its own anchor."""
        axis = self.model.jnt_axis[joint]
        if self.model.jnt_type[joint] == self.kinds.mjJNT_SLIDE:
            return _placement(position * axis)
        if self.model.jnt_type[joint] == self.kinds.mjJNT_HINGE:
            return _placement(np.zeros(3), np.array([np.cos(position / 2), *(np.sin(position / 2) * axis)]))
        return np.eye(4)

    def sites(self, body: int) -> None:
        for site in range(self.model.nsite):
            name = self.model.site(site).name
            if name and self.model.site_bodyid[site] == body:
                placement = _placement(self.model.site_pos[site], self.model.site_quat[site])
                link = _unused(name if name not in self.link_names else f"{name}_site", self.link_names)
                self.fixed(link, self.bodies[body], placement)

    def shapes(self) -> None:
        """Writes the geoms that can collide, and a visual one into each other link that has one.

        The service then lists such a link as uncovered, and warns that nothing keeps it clear.
        """
        for geom in sorted(range(self.model.ngeom), key=self.is_visual):
            link, placement = self.carrier(geom)
            form = self.form(geom)
            if link is None or form is None:
                continue
            if not self.is_visual(geom):
                _write_shape(link, "collision", form, placement)
            elif link.find("collision") is None and link.find("visual") is None:
                _write_shape(link, "visual", form, placement)

    def is_visual(self, geom: int) -> bool:
        has_mask = self.model.geom_contype[geom] | self.model.geom_conaffinity[geom]
        return not has_mask and geom not in self.paired

    def carrier(self, geom: int) -> tuple[ET.Element | None, Array]:
        """Returns the link of the body of a geom, or of the nearest body above with a link, and the placement in it.

        There is no link if the geom moves with a loose body.
        """
        model = self.model
        body, placement = int(model.geom_bodyid[geom]), _placement(model.geom_pos[geom], model.geom_quat[geom])
        while body > 0 and self.bodies[body] not in self.links and not self.is_loose(body):
            placement = _placement(model.body_pos[body], model.body_quat[body]) @ placement
            body = int(model.body_parentid[body])
        return self.links.get(self.bodies[body]), placement

    def form(self, geom: int) -> _Form | None:
        """Returns the URDF element of a geom, its attributes, and where its middle is in the frame of the geom, m."""
        size, origin = self.model.geom_size[geom], np.zeros(3)
        kind = self.model.geom_type[geom]
        if kind == self.geoms.mjGEOM_SPHERE:
            return "sphere", {"radius": _number(size[0])}, origin
        if kind in {int(self.geoms.mjGEOM_CAPSULE), int(self.geoms.mjGEOM_CYLINDER)}:
            name = "capsule" if kind == self.geoms.mjGEOM_CAPSULE else "cylinder"
            return name, {"radius": _number(size[0]), "length": _number(2 * size[1])}, origin
        if kind in {int(self.geoms.mjGEOM_BOX), int(self.geoms.mjGEOM_ELLIPSOID)}:
            return "box", {"size": _numbers(2 * size)}, origin
        if kind in {int(self.geoms.mjGEOM_MESH), int(self.geoms.mjGEOM_SDF)}:
            middle, half = self.model.geom_aabb[geom][:3], self.model.geom_aabb[geom][3:]
            return "box", {"size": _numbers(2 * half)}, middle
        return None

    def link(self, name: str) -> None:
        self.links[name] = ET.SubElement(self.robot, "link", name=name)

    def fixed(self, link: str, parent: str, placement: Array) -> None:
        self.joint(_unused(f"{link}_fixed", self.joint_names), "fixed", (parent, link), placement)

    def moving(self, joint: int, parent: str, child: str, placement: Array) -> None:
        name, limits = self.joints[joint], {}
        if self.model.jnt_limited[joint]:
            limits = dict(zip(("lower", "upper"), map(_number, self.model.jnt_range[joint]), strict=True))
        element = self.joint(name, self.kind(joint), (parent, child), placement)
        ET.SubElement(element, "axis", xyz=_numbers(self.model.jnt_axis[joint]))
        if name in self.speeds:
            limits["velocity"] = _number(self.speeds[name])
        if limits:
            ET.SubElement(element, "limit", limits)
        if joint in self.mimics:
            leader, multiplier, offset = self.mimics[joint]
            values = {"multiplier": _number(multiplier), "offset": _number(offset)}
            ET.SubElement(element, "mimic", values, joint=self.joints[leader])

    def kind(self, joint: int) -> str:
        if joint in self.loops:
            return "closed_loop"
        if self.model.jnt_type[joint] == self.kinds.mjJNT_SLIDE:
            return "prismatic"
        if self.model.jnt_type[joint] == self.kinds.mjJNT_HINGE:
            return "revolute" if self.model.jnt_limited[joint] else "continuous"
        return "ball"

    def joint(self, name: str, kind: str, links: tuple[str, str], placement: Array) -> ET.Element:
        self.link(links[1])
        element = ET.SubElement(self.robot, "joint", name=name, type=kind)
        ET.SubElement(element, "parent", link=links[0])
        ET.SubElement(element, "child", link=links[1])
        ET.SubElement(element, "origin", xyz=_numbers(placement[:3, 3]), rpy=_numbers(_roll_pitch_yaw(placement)))
        return element


def _write_shape(link: ET.Element, kind: str, form: _Form, placement: Array) -> None:
    """Writes a geom as `collision` or `visual`; `placement`: that of the geom in the link."""
    name, sizes, middle = form
    placement = placement @ _placement(middle)
    element = ET.SubElement(link, kind)
    ET.SubElement(element, "origin", xyz=_numbers(placement[:3, 3]), rpy=_numbers(_roll_pitch_yaw(placement)))
    ET.SubElement(ET.SubElement(element, "geometry"), name, sizes)


def _couplings(library: ModuleType, model: mujoco.MjModel) -> Iterator[_Coupling]:
    """Yields the active equalities that state the position of a joint, by itself or by that of another joint."""
    for equality in range(model.neq):
        if model.eq_type[equality] == library.mjtEq.mjEQ_JOINT and model.eq_active0[equality]:
            follower, leader = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
            yield _Coupling(follower, leader if leader >= 0 else None, model.eq_data[equality][:5].tolist())


def _locked(model: mujoco.MjModel, couplings: list[_Coupling]) -> dict[int, float]:
    """Returns the position of each joint that is kept at one: by itself, or because it follows such a joint."""
    locked = {
        coupling.follower: _reference(model, coupling.follower) + coupling.coefficients[0]
        for coupling in couplings
        if coupling.leader is None
    }
    # Each round finds the joints that follow those of the round before.
    for _ in couplings:
        for follower, leader, coefficients in couplings:
            if leader in locked and follower not in locked:
                motion = locked[leader] - _reference(model, leader)
                position = sum(number * motion**degree for degree, number in enumerate(coefficients))
                locked[follower] = _reference(model, follower) + position
    return locked


def _mimics(
    model: mujoco.MjModel, couplings: list[_Coupling], locked: Container[int]
) -> Iterator[tuple[int, tuple[int, float, float]]]:
    """Yields each joint that follows one that moves, with that one, the factor and the offset."""
    for follower, leader, coefficients in couplings:
        if leader is None or follower in locked:
            continue
        offset, multiplier, *higher = coefficients
        if any(higher):
            raise ValueError(_not_linear(model.joint(follower).name, model.joint(leader).name, coefficients))
        y, x = _reference(model, follower), _reference(model, leader)
        yield follower, (leader, multiplier, y + offset - multiplier * x)


def _not_linear(follower: str, leader: str, coefficients: list[float]) -> str:
    """Returns why a coupling of two joints is refused."""
    numbers = " ".join(f"{number:g}" for number in coefficients)
    return (
        f'joint `{follower}` follows joint `{leader}` by a polynomial that is not linear, polycoef="{numbers}"; the '
        "service knows linear couplings only. Set the last three numbers to 0 if a line is accurate enough. Or set "
        f'active="false" at this <equality>: `{follower}` is then a joint with its own position'
    )


def _reference(model: mujoco.MjModel, joint: int) -> float:
    """Returns the position of a joint in the reference posture, rad or m."""
    return float(model.qpos0[model.jnt_qposadr[joint]])


def _loops(library: ModuleType, model: mujoco.MjModel) -> Iterator[int]:
    """Yields the joints of closed loops: those between two connected bodies. The world can close a loop too.

    A loop is open if a free body is part of it, or a mocap body: that one pulls the arm to where the user moves it.
    """
    for first, second in _connected(library, model):
        between = set(_ancestors(model, first)) ^ set(_ancestors(model, second))
        joints = [model.body_jntadr[body] + i for body in between for i in range(model.body_jntnum[body])]
        is_free = any(model.jnt_type[joint] == library.mjtJoint.mjJNT_FREE for joint in joints)
        if not is_free and all(model.body_mocapid[body] < 0 for body in between):
            yield from map(int, joints)


def _connected(library: ModuleType, model: mujoco.MjModel) -> Iterator[tuple[int, int]]:
    """Yields the pairs of bodies that active equalities connect. Body 0 is the world."""
    for equality in range(model.neq):
        kind, is_active = int(model.eq_type[equality]), bool(model.eq_active0[equality])
        if not is_active or kind not in {int(library.mjtEq.mjEQ_CONNECT), int(library.mjtEq.mjEQ_WELD)}:
            continue
        first, second = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
        if model.eq_objtype[equality] == library.mjtObj.mjOBJ_SITE:
            first, second = int(model.site_bodyid[first]), int(model.site_bodyid[second])
        yield first, second


def _ancestors(model: mujoco.MjModel, body: int) -> Iterator[int]:
    """Yields a body and those below it in the tree, without the world."""
    while body > 0:
        yield body
        body = int(model.body_parentid[body])


def _names(kind: str, given: list[str]) -> list[str]:
    """Returns the names, with new ones for those that are empty."""
    used = set(given)
    return [name or _unused(f"{kind}_{i}", used) for i, name in enumerate(given)]


def _unused(name: str, used: set[str]) -> str:
    """Returns the name, with a number if it is used already."""
    found = next(new for i in range(len(used) + 1) if (new := f"{name}_{i + 1}" if i else name) not in used)
    used.add(found)
    return found


def _placement(position: Array, quaternion: Array | None = None) -> Array:
    placement = np.eye(4)
    placement[:3, 3] = position
    if quaternion is not None:
        w, x, y, z = quaternion / np.linalg.norm(quaternion)
        placement[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    return placement


def _roll_pitch_yaw(placement: Array) -> Array:
    """Returns the angles about the fixed axes x, y, z; accurate also where roll and yaw turn about the same axis."""
    r = placement[:3, :3]
    yaw = np.arctan2(r[1, 0], r[0, 0])
    pitch = np.arctan2(-r[2, 0], np.hypot(r[0, 0], r[1, 0]))
    sine, cosine = np.sin(yaw), np.cos(yaw)
    roll = np.arctan2(sine * r[0, 2] - cosine * r[1, 2], cosine * r[1, 1] - sine * r[0, 1])
    return np.array([roll, pitch, yaw])


def _number(value: float) -> str:
    return repr(float(value))


def _numbers(values: Array) -> str:
    return " ".join(map(_number, values))
