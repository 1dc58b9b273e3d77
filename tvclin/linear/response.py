"""Forced response of a plant, exact at any time and on the stability boundary.

The response is decomposed into the modes of the plant. `numerics.modal` says how an unstable mode
is exact: on the boundary its residue, eq (4b), is zero, and only the remaining integral of its
inputs stays, which decays. Plants of nearly equal poles take matrix exponentials.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, broadcast, instance, one_of, shown, times_row
from tvclin.linear.plant import INPUTS, PLANT_HINT, Plant
from tvclin.numerics import modal
from tvclin.numerics.propagation import motions
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import TimeResponseData


@dataclass(frozen=True, eq=False)
class Responses:
    """Responses of a batch.

    Attributes
    ----------
    time : ndarray
        Times [s], ``(n,)``.
    outputs : ndarray
        Responses, ``(..., output, n)`` in the order of `labels` [rad, rad/s].
    labels : tuple of str
        Names of the outputs.
    """

    time: FloatArray
    outputs: FloatArray
    labels: tuple[str, ...]

    def __getitem__(self, label: str) -> FloatArray:
        """Return the output `label` of all cases, ``(..., n)`` [rad or rad/s]."""
        one_of("output", label, self.labels)
        return self.outputs[..., self.labels.index(label), :]


def attitude_response(
    plant: Plant, deflection: History, wind: History, timepts: ArrayLike
) -> TimeResponseData:
    """Return the exact response of one plant as `control.TimeResponseData`.

    Parameters
    ----------
    plant : Plant
        One plant of any model.
    deflection, wind : History
        Any two histories, not batches.
    timepts : array_like
        Times [s], ``(n,)``, in any order and spacing; breakpoints need not be among them.

    Returns
    -------
    control.TimeResponseData
        Outputs attitude, attitude_rate, flight_path_angle (where the model has it) and
        angle_of_attack [rad, rad/s]; inputs deflection and wind [rad], all by name.

    Raises
    ------
    InputError
        For a batch (use `attitude_responses`), and for times that are not finite or none at all.

    Notes
    -----
    Eqs (5), (B7) and (B8) are solved mode by mode. On the stability boundary all digits are kept
    at any time, where forward integration has lost them all beyond tau beta of about 12. Off the
    boundary the attitude grows without end, to infinity where floating point ends.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.53, B=0.107))
    >>> wind = tv.TriangularWind(peak=0.09, duration=7.5)
    >>> limit = tv.boundary_limit(plant, wind).deflection
    >>> held = tv.trim_then_hold(plant, wind, limit)
    >>> response = tv.attitude_response(plant, held, wind, np.linspace(0, 100, 5))
    >>> bool(np.isclose(response.outputs["attitude"][-1], limit / 0.107, rtol=1e-13))
    True
    """
    responses = attitude_responses(plant, deflection, wind, timepts)
    if responses.outputs.ndim > 2:
        raise InputError(
            f"attitude_response is for one case; got a batch of shape"
            f" {responses.outputs.shape[:-2]} (use attitude_responses)"
        )
    name, title = plant.model, f"Exact response, {plant.model} model"
    inputs = dict(zip(INPUTS, (deflection, wind), strict=True))
    return time_response(
        responses.time, responses.outputs, responses.labels, name=name, title=title, **inputs
    )


def time_response(
    times: FloatArray,
    outputs: FloatArray,
    labels: tuple[str, ...],
    *,
    name: str,
    title: str,
    **inputs: History,
) -> TimeResponseData:
    """Return outputs ``(n, m)`` at times ``(m,)`` [s] as `control.TimeResponseData`.

    `labels`: names of the outputs. `name`, `title`: name of the system, and title of its plot, to
    which the units are added. `inputs`: histories of the inputs, by name.
    """
    from control import TimeResponseData

    return TimeResponseData(
        times,
        outputs,
        states=None,
        inputs=np.stack([history(times) for history in inputs.values()]),
        issiso=False,
        output_labels=list(labels),
        input_labels=list(inputs),
        sysname=name,
        plot_inputs=True,
        title=f"{title} [rad, rad/s]",
        trace_types=["forced"],
    )


def attitude_responses(
    plant: Plant,
    deflection: History,
    wind: History,
    timepts: ArrayLike,
    outputs: Sequence[str] | None = None,
) -> Responses:
    """Return the exact responses of a batch of winds, of plants, or of both, in one call.

    Parameters
    ----------
    plant : Plant
        One plant or a batch.
    deflection, wind : History
        Any two histories; their batches broadcast with the plant's.
    timepts : array_like
        Times [s], ``(n,)``, the same for all.
    outputs : sequence of str, optional
        Names of the outputs to compute, by default all. They are returned in the order of the
        plant.

    Raises
    ------
    InputError
        For times that are not finite, not one row, or none at all, for batches that do not
        broadcast, and for outputs that the model does not have.
    """
    times = times_row("timepts", timepts)
    instance("plant", plant, Plant, PLANT_HINT)
    instance("deflection", deflection, History, "such as ConstantDeflection")
    instance("wind", wind, History, "such as TriangularWind")
    shape = broadcast(plant=plant.batch, deflection=deflection.batch, wind=wind.batch)
    system, labels = plant.modal, plant.outputs
    rows = list(range(len(labels)))  # of the outputs
    if outputs is not None:
        if not isinstance(outputs, tuple | list) or not outputs:
            raise InputError(f"outputs must be some of {', '.join(labels)}; got {shown(outputs)}")
        rows = sorted({labels.index(one_of("outputs", label, labels)) for label in outputs})
        # the wind is subtracted from the last of all outputs, if it is among them
        less_wind = system.less_wind and rows[-1] == len(labels) - 1
        system = replace(system, outputs=system.outputs[..., rows], less_wind=less_wind)
    values, indistinct = modal.responses(system, (deflection.pieces, wind.pieces), times, shape)
    if system.direct is not None:  # only of a `SystemPlant`
        inputs = np.stack(np.broadcast_arrays(deflection(times), wind(times)), axis=-2)
        values += system.direct[..., rows, :] @ inputs
    if indistinct is not None:  # cases with nearly equal poles, without a sum of modes
        flat = values.reshape(-1, *values.shape[-2:])
        for k in map(int, np.flatnonzero(indistinct)):
            histories = deflection.case(k, shape), wind.case(k, shape)
            flat[k] = _by_matrices(plant.case(k, shape), histories, times)[rows]
    return Responses(times, values, tuple(labels[k] for k in rows))


def _by_matrices(plant: Plant, inputs: tuple[History, History], times: FloatArray) -> FloatArray:
    """Return the responses ``(outputs, n)`` [rad, rad/s] of one plant by matrix exponentials.

    They admit any poles, also repeated ones, as of a vehicle without aerodynamic moment.
    `inputs`: deflection and wind [rad]. `times`: [s], ``(n,)``.
    """
    A, B, C, D = plant.matrices()
    outputs = np.zeros((len(C), times.size))
    for column, history in enumerate(inputs):
        (response,) = motions(A, B[:, column], [history.pieces])
        states = np.real(response.at(times)[:, : len(A)])  # without the history's own states
        outputs += C @ states.T + D[:, column, np.newaxis] * history(times)
    return outputs
