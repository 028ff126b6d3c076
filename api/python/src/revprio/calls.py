"""The calls that need no server: the same methods for a service in this process and for one over HTTP."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TypeVar

from revprio import routes
from revprio.models import (
    BatchItem,
    BatchRequest,
    ControllerConfig,
    KinematicsAnswer,
    KinematicsRequest,
    PayloadAnswer,
    PayloadRequest,
    ResolveAnswer,
    ResolveRequest,
    Robot,
    RobotRegistration,
    StabilityAnswer,
    StabilityRequest,
    StepAnswer,
    StepRequest,
)
from revprio.remote import Stateless
from revprio.typed import fields_of

A = TypeVar("A")


class Calls(ABC):
    """The calls of a service, wherever it runs."""

    step_timeout_s: float
    """Time limit of a control period, s."""

    @abstractmethod
    def call(self, call: routes.Call[A], timeout_s: float | None = None) -> A:
        """Makes a call of `revprio.routes` and returns its answer."""

    @fields_of(ResolveRequest)
    def resolve(self, request: ResolveRequest) -> ResolveAnswer:
        """Computes joint velocities for tasks: `client.resolve(robot=…, joint_position=…, tasks=[…])`.

        In the answer, `joint_velocity` has n numbers, rad/s or m/s; `tasks` has the result of each task, highest
        priority first.
        """
        return self.call(routes.RESOLVE(body=request))

    def resolve_batch(self, items: Sequence[ResolveRequest]) -> list[BatchItem]:
        """Resolves many requests at once. Returns, in the same order, an answer or a `Problem` for each."""
        return self.call(routes.RESOLVE_BATCH(body=BatchRequest(items=list(items)))).items

    @fields_of(KinematicsRequest)
    def kinematics(self, request: KinematicsRequest) -> KinematicsAnswer:
        """Returns tool pose (m), `jacobian` (6 × n, base axes, linear rows first), singular values and link frames."""
        return self.call(routes.KINEMATICS(body=request))

    @fields_of(StabilityRequest)
    def stability(self, request: StabilityRequest) -> StabilityAnswer:
        """Returns stability margins of one axis in contact: maximum lag (s) and delay (periods), minimum damping."""
        return self.call(routes.STABILITY(body=request))

    @fields_of(PayloadRequest)
    def payload(self, request: PayloadRequest) -> PayloadAnswer:
        """Identifies bias and payload of a wrist sensor from readings at rest in six postures or more.

        `bias` and `payload` of the answer fit into a `WrenchSensor`. Similar postures, a wrong sign and exchanged axes
        raise an `InvalidError` that says which posture to add, or what is exchanged.
        """
        return self.call(routes.PAYLOAD(body=request))

    @fields_of(StepRequest)
    def step(self, request: StepRequest) -> StepAnswer:
        """Runs one control period of a stateless controller; `stateless` keeps the memory between periods for you."""
        return self.call(routes.STEP(body=request), self.step_timeout_s)

    @fields_of(ControllerConfig)
    def stateless(self, config: ControllerConfig) -> Stateless:
        """Returns a controller that sends its memory with each request."""
        return Stateless(self, config)

    def robots(self) -> list[Robot]:
        """Lists the robots that requests can name, with limits and units of their joints."""
        return self.call(routes.ROBOTS()).robots

    def robot(self, name: str) -> Robot:
        """Returns the robot of this name, with limits and units of its joints."""
        return self.call(routes.ROBOT(name))

    @fields_of(RobotRegistration)
    def register_robot(self, registration: RobotRegistration) -> Robot:
        """Registers a robot from the text of a URDF file. `tip` names the link of its tool."""
        return self.call(routes.REGISTER_ROBOT(body=registration))

    def delete_robot(self, name: str) -> None:
        """Deletes a registered robot."""
        self.call(routes.DELETE_ROBOT(name))
