"""Simulations that the service runs."""

from __future__ import annotations

import time
from collections.abc import Callable

from revprio import routes
from revprio.errors import RevprioError
from revprio.models import Simulation, SimulationControl, StepRequest
from revprio.transport import Caller
from revprio.typed import fields_of

POLL_S = 0.1
"""Interval between two status requests, s."""


class SimulationError(RevprioError):
    """A simulation failed or was cancelled."""

    def __init__(self, simulation: Simulation) -> None:
        """`simulation`: its state and error, as the service reports them."""
        super().__init__(f"simulation {simulation.id} {simulation.state}: {simulation.error or 'a client deleted it'}")
        self.simulation = simulation


class SimulationRun:
    """A simulation that is queued, running or finished."""

    def __init__(self, client: Caller, simulation_id: str) -> None:
        """`simulation_id`: identifier of a run that was started."""
        self._client, self.id = client, simulation_id

    def status(self) -> Simulation:
        """Returns state and progress (0 … 1); includes metrics once the simulation is finished."""
        return self._client.call(routes.SIMULATION(self.id))

    def result(self, on_progress: Callable[[Simulation], object] = lambda _: None) -> Simulation:
        """Waits for the end; raises `SimulationError` if the simulation failed or was cancelled."""
        while not has_ended(status := self.status()):
            on_progress(status)
            time.sleep(POLL_S)
        return status

    @fields_of(SimulationControl)
    def control(self, command: SimulationControl) -> Simulation:
        """Controls an interactive run: `run.control(paused=False, speed=0.5, external_force=[0, 20, 0])`."""
        return self._client.call(routes.CONTROL_SIMULATION(self.id, body=command))

    def cycle(self) -> StepRequest:
        """Returns the latest control period of an interactive run, as a request for `Client.step`."""
        return self._client.call(routes.CYCLE(self.id))

    def trace(self) -> routes.Trace:
        """Returns all control periods of a finished run: one array per column, as the service documents them."""
        return self._client.call(routes.TRACE(self.id))

    def cancel(self) -> None:
        """Cancels a running simulation; deletes a finished one."""
        self._client.call(routes.DELETE_SIMULATION(self.id))


def has_ended(status: Simulation) -> bool:
    """Returns whether the simulation is finished; raises `SimulationError` if it failed or was cancelled."""
    if status.state in ("failed", "cancelled"):
        raise SimulationError(status)
    return status.state == "finished"
