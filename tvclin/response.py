"""The forced response of a plant, exact at any time and on the stability boundary.

The response is taken apart into the modes of the plant. A mode that does not grow is the
discounted past of its inputs, carried from knot to knot. A mode that grows is written as

    z(t) = R e^(p t) - (discounted future of its inputs),

R being its residue, eq (4b). On the boundary R is zero and what remains decays, so nothing is
lost; integrated forward, the same mode would be the difference of two numbers that grow with
e^(p t). A residue that is zero within the rounding of its own sum counts as zero.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.errors import InputError, broadcast, finite, instance, one_of
from tvclin.histories import History
from tvclin.kernels import integrals, lags
from tvclin.modes import Modes, all_modes, first_time, growing, residues_at
from tvclin.plant import INPUTS, Plant

if TYPE_CHECKING:
    from control import TimeResponseData

FloatArray = NDArray[np.float64]

_SEPARATE = 1e-3
"""Poles nearer to each other than this, over the largest or over the time, count as near."""
_FORWARD = 20.0
"""A mode that grows by no more than e^20 may be carried forward."""


@dataclass(frozen=True, eq=False)
class Responses:
    """The responses of a batch.

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
        """Return one output by its name, ``(..., n)``."""
        one_of("output", label, self.labels)
        return self.outputs[..., self.labels.index(label), :]


def attitude_response(
    plant: Plant, deflection: History, wind: History, timepts: ArrayLike
) -> "TimeResponseData":
    """Return the exact response of one plant as `control.TimeResponseData`.

    Parameters
    ----------
    plant : Plant
        One plant of any model.
    deflection, wind : History
        Any two histories, not batches.
    timepts : array_like
        Times [s], ``(n,)``, in any order and spacing; knots need not be among them.

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
    Eqs (5), (B7) and (B8) answered mode by mode. On the stability boundary all digits are kept
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
    from control import TimeResponseData

    found = attitude_responses(plant, deflection, wind, timepts)
    if found.outputs.ndim > 2:
        raise InputError(
            f"attitude_response is for one case; got a batch of shape {found.outputs.shape[:-2]}"
            " (use attitude_responses)"
        )
    return TimeResponseData(
        found.time,
        found.outputs,
        None,
        np.stack([deflection(found.time), wind(found.time)]),
        issiso=False,
        output_labels=list(found.labels),
        input_labels=list(INPUTS),
        sysname=plant.model,
        plot_inputs=True,
        title=f"Exact response, {plant.model} model",
        trace_types=["forced"],
    )


def attitude_responses(
    plant: Plant, deflection: History, wind: History, timepts: ArrayLike
) -> Responses:
    """Return the exact responses of a batch: many winds, many plants, or both, in one call.

    Parameters
    ----------
    plant : Plant
        One plant or a batch.
    deflection, wind : History
        Any two histories; their batches broadcast with the plant's.
    timepts : array_like
        Times [s], ``(n,)``, the same for all.

    Raises
    ------
    InputError
        For times that are not finite, not one row, or none at all, and for batches that do not
        broadcast.
    """
    times = finite("timepts", timepts, "s")
    if times.ndim != 1 or not times.size:
        raise InputError(f"timepts must be one row of times; got an array of shape {times.shape}")
    instance("plant", plant, Plant, "see Plant.from_vehicle")
    instance("deflection", deflection, History, "such as HeldDeflection")
    instance("wind", wind, History, "such as TriangularWind")
    shape = broadcast(plant=plant.batch, deflection=deflection.batch, wind=wind.batch)
    modes = all_modes(plant)
    near = _near_poles(modes.poles, times.max() - first_time(deflection, wind))
    with np.errstate(invalid="ignore"):  # near poles have no residues; they are answered below
        amplitudes = _amplitudes(modes, deflection, wind, times)
        outputs = _outputs(plant, modes, amplitudes, wind, times, shape)
    if np.any(near):
        lags = _by_lags(plant, deflection, wind, times, shape)
        outputs = np.where(near[..., np.newaxis, np.newaxis], lags, outputs)
    return Responses(times, outputs, plant.outputs)


def _amplitudes(
    modes: Modes, deflection: History, wind: History, times: FloatArray
) -> NDArray[Any]:
    """The part of the attitude that each mode makes, ``(..., N, n)``."""
    unstable = growing(modes.poles)
    fast = Modes(
        np.where(unstable, modes.poles, np.nan), modes.deflection_residues, modes.wind_residues
    )
    start = first_time(deflection, wind)
    found, tolerance = residues_at(fast, deflection, wind, start)
    found = np.where(unstable & (np.abs(found) > tolerance), found, 0.0)
    columns = []
    for k in range(modes.poles.shape[-1]):
        pole, up = modes.poles[..., k], unstable[..., k]
        weights = (modes.deflection_residues[..., k], modes.wind_residues[..., k])
        forward = _sum(lags.past, np.where(up, 0.0, pole), weights, (deflection, wind), times)
        if not np.any(up):
            columns.append(forward)
            continue
        back = _sum(integrals.future, np.where(up, pole, 1.0), weights, (deflection, wind), times)
        with np.errstate(over="ignore", invalid="ignore"):
            since = times - start[..., np.newaxis]
            growth = np.where(up, pole, 0.0)[..., np.newaxis] * since
            excess = found[..., k, np.newaxis]
            grown = np.where(excess == 0.0, 0.0, excess * np.exp(growth))
            grown = np.where(since < 0.0, 0.0, grown - back)
        columns.append(np.where(up[..., np.newaxis], grown, forward))
    return np.stack(np.broadcast_arrays(*columns), axis=-2)


def _sum(
    integral: Any,
    pole: NDArray[Any],
    weights: tuple[NDArray[Any], ...],
    histories: tuple[History, ...],
    times: FloatArray,
) -> NDArray[Any]:
    terms = [
        weight[..., np.newaxis] * integral(history.pieces, pole, times)
        for weight, history in zip(weights, histories, strict=True)
    ]
    return np.asarray(terms[0] + terms[1])


def _outputs(
    plant: Plant,
    modes: Modes,
    amplitudes: NDArray[Any],
    wind: History,
    times: FloatArray,
    shape: tuple[int, ...],
) -> FloatArray:
    """Each mode of the attitude turns with its pole, and takes its share of flight path along."""
    poles = modes.poles[..., np.newaxis]
    attitude = np.real(amplitudes.sum(axis=-2))
    rows = [attitude, np.real((poles * amplitudes).sum(axis=-2))]
    angle = attitude - wind(times)
    if "flight_path_angle" in plant.outputs:
        share = plant.path_per_attitude(modes.poles)[..., np.newaxis]
        rows.append(np.real((share * amplitudes).sum(axis=-2)))
        angle = np.real(((1.0 - share) * amplitudes).sum(axis=-2)) - wind(times)
    rows.append(angle)
    return np.stack([np.broadcast_to(row, (*shape, times.size)) for row in rows], axis=-2)


def _by_lags(
    plant: Plant, deflection: History, wind: History, times: FloatArray, shape: tuple[int, ...]
) -> FloatArray:
    """The response by a chain of lags, which needs no distinct poles (a vehicle without moment)."""
    rows = []
    for output in plant.outputs:
        parts = [
            history.filter(plant.numerator(output, name), plant.denominator)(times)
            for name, history in zip(INPUTS, (deflection, wind), strict=True)
        ]
        rows.append(np.broadcast_to(parts[0] + parts[1], (*shape, times.size)))
    return np.stack(rows, axis=-2)


def _near_poles(poles: NDArray[Any], span: FloatArray) -> NDArray[np.bool_]:
    """Where two poles are too near for the modes to be told apart within the time span, ``(...)``.

    A plant that grows fast all the same keeps its modes: a chain of lags runs forward.
    """
    gaps = np.abs(poles[..., :, np.newaxis] - poles[..., np.newaxis, :])
    gaps[..., np.arange(poles.shape[-1]), np.arange(poles.shape[-1])] = np.inf
    gap, size = gaps.min(axis=(-2, -1)), np.abs(poles).max(axis=-1)
    span = np.maximum(span, 0.0)
    near = (gap <= _SEPARATE * size) | (gap * span <= _SEPARATE)
    return near & ((np.real(poles).max(axis=-1) * span <= _FORWARD) | (gap == 0.0))
