"""One autopilot around one plant in python-control's own systems and responses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tvclin.control.autopilot.actuator import pade_delay
from tvclin.control.autopilot.feedback import Feedback
from tvclin.control.autopilot.wiring import ClosedLoop, wired
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History

if TYPE_CHECKING:
    import control

FloatArray = NDArray[np.float64]

_DISTURBANCES = ("wind", "attitude_command", "deflection_disturbance")


def open_loop(autopilot: Feedback, plant: AnyPlant) -> control.StateSpace:
    """Return the loop from the deflection command to minus what returns, for 1 + L = 0."""
    import control

    delay = pade_delay(float(autopilot.delay), autopilot.pade_order)
    states, motion, _, _, returned = wired(autopilot, plant, delay)
    n = len(states)
    return control.StateSpace(
        motion[:, :n],
        motion[:, -1:],
        0.0 - returned[:, :n],
        0.0 - returned[:, -1:],
        0,
        name=f"{plant.model} loop",
        inputs=["deflection_command"],
        outputs=["returned_command"],
        states=list(states),
    )


def closed_loop(plant: AnyPlant, loop: ClosedLoop) -> control.StateSpace:
    """Return the closed loop from the three disturbances to the plant's outputs and deflection."""
    import control

    return control.StateSpace(
        loop.A,
        loop.B,
        loop.C,
        loop.D,
        0,
        name=f"{plant.model} with autopilot",
        inputs=list(_DISTURBANCES),
        outputs=[*plant.outputs, "deflection"],
        states=list(loop.states),
    )


def wind_response(
    times: FloatArray,
    outputs: FloatArray,
    wind: History,
    labels: tuple[str, ...],
    *,
    name: str,
    title: str,
) -> control.TimeResponseData:
    """Return a response to a wind alone as `control.TimeResponseData`.

    Parameters
    ----------
    times, outputs : ndarray
        Times [s], ``(m,)``, and the outputs there, ``(n, m)``.
    wind : History
        The wind [rad].
    labels : tuple of str
        Names of the outputs.
    name, title : str
        What responds, and the title of its plot.
    """
    from control import TimeResponseData

    return TimeResponseData(
        times,
        outputs,
        None,
        wind(times)[np.newaxis],
        issiso=False,
        output_labels=list(labels),
        input_labels=["wind"],
        sysname=name,
        plot_inputs=True,
        title=f"{title} [rad, rad/s]",
        trace_types=["forced"],
    )
