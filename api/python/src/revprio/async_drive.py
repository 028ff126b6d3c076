"""The control loop with a watchdog, for asyncio."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any, Protocol

from revprio.bodies import FloatArray
from revprio.drive import LoopState, Measurement, ramp_to_rest, ticks
from revprio.models import StepAnswer
from revprio.pace import Drive
from revprio.watchdog import Watchdog


class Stepper(Protocol):
    """An `AsyncController`, or another object that computes the commands of an arm."""

    period_s: float
    """Control period T, s."""

    def step(self, *args: Any, **fields: Any) -> Coroutine[Any, Any, StepAnswer]:  # noqa: ANN401 - the arguments vary
        """Runs one control period; the arguments are those of `Controller.step`."""


async def drive(
    controller: Stepper,
    read: Callable[[], Awaitable[Measurement]],
    write: Callable[[FloatArray], None],
    *,
    watchdog: Watchdog,
    duration_s: float = math.inf,
) -> Drive:
    """As `revprio.drive`. The final ramp blocks the event loop until the arm is at rest."""
    state = LoopState(watchdog, controller.period_s)
    pending: asyncio.Task[StepAnswer] | None = None
    with ramp_to_rest(watchdog, write, controller.period_s):
        try:
            for tick in ticks(controller.period_s, duration_s):
                state.begin(tick)
                measurement = await read()
                if pending is None:
                    pending = asyncio.ensure_future(controller.step(**state.step_arguments(measurement, tick)))
                await asyncio.wait([pending], timeout=tick.remaining_s())
                if pending.done():
                    state.update(pending)
                    pending = None
                write(state.command())
                state.report.periods += 1
                await asyncio.sleep(tick.remaining_s())
        finally:
            if pending is not None:
                pending.cancel()
    return state.report
