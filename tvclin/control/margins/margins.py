"""Stability margins of a loop, under names that cannot be misread.

All follow from L(j omega): gain and phase at its crossings, the disk margin and the peaks of S =
1/(1 + L) and T = L/(1 + L). The arithmetic is in `numerics.loop_margins`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Row, Shown, card
from tvclin.base.errors import InputError, instance, plain
from tvclin.base.fields import Field, decibels, spec, specs
from tvclin.base.lines import Line, number, text
from tvclin.control.margins.loop import Loop, SampledLoop
from tvclin.numerics.loop_margins import LoopAnalysis, classical_margins

OK = "ok"
UNSTABLE = "unstable"
MARGINAL = "marginal"


MARGINS = {
    "aero_margin_dB": ("aero: gain may fall", "dB", "aero_frequency"),
    "gain_increase_dB": ("gain may rise", "dB", "gain_increase_frequency"),
    "phase_margin_deg": ("phase", "deg", "crossover_frequency"),
    "delay_margin": ("delay", "ms", "delay_margin_frequency"),
    "disk_margin": ("disk", "", "disk_frequency"),
    "peak_sensitivity": ("peak of S", "", "peak_sensitivity_frequency"),
    "peak_complementary_sensitivity": (
        "peak of T",
        "",
        "peak_complementary_sensitivity_frequency",
    ),
}
"""Margins that criteria may limit: label, unit of tables, and the attribute of its frequency."""


class MarginRow(NamedTuple):
    """Row of a margin table: name in `Margins`, label, value, its unit, and frequency [rad/s]."""

    name: str
    label: str
    value: Any
    unit: str
    frequency: Any


DIGITS = {"dB": 2, "deg": 2, "ms": 1, "": 3}
"""Number of decimals of a margin, by unit."""


def margin(name: str, value: Any, unit: str) -> Line:
    """Return a margin as a cell of a table, with its unit and the decimals usual for it.

    `name`: key of the number. `unit`: "dB", "deg", "ms" or "", in which `value` is.
    """
    return number(name, value, DIGITS[unit], unit)


def unit_factor(unit: str) -> float:
    """Return the factor from a margin in SI units to a unit of tables: 1000 for ms, else one."""
    return 1000.0 if unit == "ms" else 1.0


@dataclass(frozen=True, eq=False)
class Crossings:
    """All gain and phase crossovers; frequencies rise along the last axis, padded with NaN.

    With a delay there are infinitely many phase crossovers; the list ends where the loop gain stays
    below 1/100, at least one turn of the delay's phase later.

    Attributes
    ----------
    gain_frequencies : ndarray
        Gain crossovers, ``|L| = 1`` [rad/s], ``(..., k)``.
    phase_margins : ndarray
        Phase [rad] by which L may lag more (positive) or lead more (negative) until L = -1,
        ``(..., k)``.
    phase_frequencies : ndarray
        Phase crossovers, L real and negative [rad/s], ``(..., m)``.
    gain_factors : ndarray
        Factor on the loop gain with which L = -1, ``(..., m)``: above one an increase, below one a
        reduction (the aerodynamic margin).
    """

    gain_frequencies: FloatArray
    phase_margins: FloatArray
    phase_frequencies: FloatArray
    gain_factors: FloatArray


class InDecibels:
    """Gain and phase margins of a record in the units of tables."""

    aero_margin: Any
    gain_increase: Any
    phase_margin: Any

    @property
    def aero_margin_dB(self) -> Any:
        """The aero margin in dB, positive: how far the gain may fall."""
        return decibels(self.aero_margin)

    @property
    def gain_increase_dB(self) -> Any:
        """The gain-increase margin in dB, positive: how far the gain may rise."""
        return decibels(self.gain_increase)

    @property
    def phase_margin_deg(self) -> Any:
        """The phase margin in degrees."""
        return plain(np.degrees(self.phase_margin))


@dataclass(frozen=True, eq=False)
class Margins(Shown, InDecibels):
    """Stability margins of a loop; every number has the shape ``(...)`` of the batch.

    Every margin of an unstable closed loop is NaN. A margin without a crossing is infinite, with
    the frequency NaN; `notes` says why.

    Attributes
    ----------
    status : str or ndarray of str
        "ok", "unstable" (closed-loop poles in the right half plane, of a sampled loop outside the
        unit circle) or "marginal" (on the axis, or the circle).
    unstable_poles : int or ndarray of int
        Number of such closed-loop poles, with the exact delay.
    aero_margin : float or ndarray
        Factor by which the loop gain may be divided; below, an unstable vehicle tumbles.
    gain_increase : float or ndarray
        Factor by which the loop gain may be multiplied.
    phase_margin : float or ndarray
        Smallest phase [rad], lag or lead, that makes L = -1 at a gain crossover.
    delay_margin : float or ndarray
        Smallest further delay [s] that makes the loop unstable.
    disk_margin : float or ndarray
        alpha = ``1/max |(S - T)/2|``: gain and phase may change together by any factor in the disk
        with the real axis cuts (2 - alpha)/(2 + alpha) and (2 + alpha)/(2 - alpha).
    peak_sensitivity, peak_complementary_sensitivity : float or ndarray
        Largest ``|S|`` and ``|T|``.
    aero_frequency, gain_increase_frequency, crossover_frequency, delay_margin_frequency, \
disk_frequency, peak_sensitivity_frequency, peak_complementary_sensitivity_frequency : \
float or ndarray
        Frequency of each [rad/s]; `crossover_frequency` belongs to `phase_margin`.
    crossings : Crossings
        All crossings, also those that do not limit a margin.
    sampled : bool
        Whether the loop is sampled, so that stable poles lie inside the unit circle.
    """

    status: Any = field(metadata=spec(document=False))
    unstable_poles: Any = field(metadata=spec(card=False))
    aero_margin: Any = field(metadata=spec("gain"))
    aero_frequency: Any = field(metadata=spec("natural frequency", card=False))
    gain_increase: Any = field(metadata=spec("gain"))
    gain_increase_frequency: Any = field(metadata=spec("natural frequency", card=False))
    phase_margin: Any = field(metadata=spec("angle"))
    crossover_frequency: Any = field(metadata=spec("natural frequency", card=False))
    delay_margin: Any = field(metadata=spec("time"))
    delay_margin_frequency: Any = field(metadata=spec("natural frequency", card=False))
    disk_margin: Any = field(
        metadata=specs(Field(), Field(kind="decibels", of="disk_margin_dB", card=False))
    )
    disk_frequency: Any = field(metadata=spec("natural frequency", card=False))
    peak_sensitivity: Any = field(metadata=spec(card=False))
    peak_sensitivity_frequency: Any = field(metadata=spec("natural frequency", card=False))
    peak_complementary_sensitivity: Any = field(metadata=spec(card=False))
    peak_complementary_sensitivity_frequency: Any = field(
        metadata=spec("natural frequency", card=False)
    )
    crossings: Crossings
    sampled: bool = False

    def rows(self) -> list[MarginRow]:
        """Return a table row for each margin that criteria may limit, with its frequency."""
        return [
            MarginRow(
                name=name,
                label=label,
                value=unit_factor(unit) * getattr(self, name),
                unit=unit,
                frequency=getattr(self, frequency),
            )
            for name, (label, unit, frequency) in MARGINS.items()
        ]

    def _repr_html_(self) -> str:
        """Return the margins and their frequencies as a card for a notebook."""
        rows: list[Row] = [("status", self.status, "")]
        for name, label, value, unit, frequency in self.rows():
            # of one loop with the decimals of a table, without the unit behind the number
            shown = value if np.ndim(value) else text(margin(name, value, unit)[:1])
            rows += [(label, shown, unit), ("at", frequency, "rad/s")]
        return card("Margins", rows)

    @property
    def stable(self) -> Any:
        """Whether the closed loop is stable."""
        return self.status == OK

    @property
    def disk_margin_dB(self) -> Any:
        """Gain change in dB, up or down, within the disk: (2 + alpha)/(2 - alpha) as a factor.

        alpha: the disk margin; infinite for 2 and more.
        """
        alpha = np.asarray(self.disk_margin)
        with np.errstate(divide="ignore"):
            return decibels((2.0 + alpha) / np.maximum(2.0 - alpha, 0.0))

    @property
    def disk_phase_deg(self) -> Any:
        """Phase change in degrees, lag or lead, within the disk margin alpha: 2 arctan(alpha/2)."""
        return plain(np.degrees(2.0 * np.arctan(self.disk_margin / 2.0)))

    @property
    def reason(self) -> str:
        """Reason for the absence of margins; empty for a stable loop. One loop only."""
        if not isinstance(self.status, str):
            raise InputError(
                "reason and notes are of one loop; these are margins of a batch of shape"
                f" {np.shape(self.status)} (use status and unstable_poles)"
            )
        if self.status == UNSTABLE:
            count = self.unstable_poles
            poles = "1 closed-loop pole lies" if count == 1 else f"{count} closed-loop poles lie"
            where = "outside the unit circle" if self.sampled else "in the right half plane"
            return f"the closed loop is unstable: {poles} {where}"
        if self.status == MARGINAL:
            edge = "unit circle" if self.sampled else "imaginary axis"
            return f"the closed loop is not asymptotically stable: a pole lies on the {edge}"
        return ""

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on margins that do not exist. One loop only."""
        if self.reason:
            return (self.reason,)
        notes = []
        if np.isinf(self.aero_margin):
            notes.append("aero margin inf: the loop stays stable however far its gain falls")
        if np.isinf(self.gain_increase):
            notes.append(
                "gain-increase margin inf: the loop stays stable however far its gain rises, which"
                " no loop with an actuator and a delay does"
            )
        if np.isinf(self.phase_margin):
            notes.append("phase and delay margin inf: the loop gain is one at no frequency")
        return tuple(notes)


def loop_margins(loop: Loop) -> Margins:
    """Return the stability margins of one loop or a batch of loops.

    Parameters
    ----------
    loop : Loop
        One loop or a batch, of shape ``(...)``.

    Returns
    -------
    Margins
        Status and margins of each loop; an unstable loop in a batch does not affect the others.

    Notes
    -----
    Stability follows from the closed-loop poles without delay and from the poles that cross the
    imaginary axis as the delay grows: exactly, without an approximation of the delay. Gain
    crossovers are roots of ``|N|^2 - |D|^2``, or eigenvalues of a Hamiltonian matrix. Phase
    crossovers and peaks are bracketed on a grid around all poles and zeros, and refined to
    rounding.

    Examples
    --------
    >>> from tvclin.control.margins.loop import Loop
    >>> from tvclin.control.margins.margins import loop_margins
    >>> m = loop_margins(Loop([1.317 * 1.59, 1.317 * 1.88], [1, 0, -0.228]))
    >>> round(m.phase_margin_deg, 1), round(m.aero_margin_dB, 1), m.gain_increase
    (62.4, 20.7, inf)
    """
    instance("loop", loop, Loop, "see Loop.from_system")
    return margins_of(loop.analysis(), loop)


def margins_of(analysis: LoopAnalysis, loop: Loop) -> Margins:
    """Return the margins of the k loops of a batch, `loop`, in the shape of the batch.

    `analysis`: crossings and peaks of the flattened batch of loops; of its `peaks` ``(k, 3, 2)``
    those of S = 1/(1 + L), T = L/(1 + L) and (S - T)/2 are 0, 1 and 2, with their frequencies.
    """
    unstable, stable = analysis.unstable_poles > 0, analysis.stable
    status = np.select([unstable, analysis.marginal], [UNSTABLE, MARGINAL], OK)
    # Peaks of (S - T)/2, S and T with their frequencies, (3, 2, k); the disk margin is 1 over the
    # first. With the classical margins all pairs are in the order of the fields of `Margins`.
    peaks = analysis.peaks.transpose(1, 2, 0)[[2, 0, 1]]
    peaks[0, 0] = 1.0 / peaks[0, 0]
    pairs = np.concatenate([classical_margins(analysis), peaks])
    pairs[..., ~stable] = np.nan
    numbers = (status, analysis.unstable_poles, *pairs.reshape(2 * len(pairs), stable.size))
    batch = loop.batch
    *names, _, _ = (field.name for field in fields(Margins))  # without crossings and sampled
    shaped = {name: in_batch_shape(v, batch) for name, v in zip(names, numbers, strict=True)}
    crossings = Crossings(
        gain_frequencies=_trimmed(analysis.gain_frequencies, batch),
        phase_margins=_trimmed(analysis.phases, batch),
        phase_frequencies=_trimmed(analysis.phase_frequencies, batch),
        gain_factors=_trimmed(analysis.factors, batch),
    )
    return Margins(**shaped, crossings=crossings, sampled=isinstance(loop, SampledLoop))


def in_batch_shape(values: Any, batch: tuple[int, ...]) -> Any:
    """Return `values` ``(k,)`` of k loops in the shape of their batch; a scalar for ``()``."""
    array = np.asarray(values).reshape(batch)
    return array if array.ndim else array.item()


def _trimmed(rows: FloatArray, batch: tuple[int, ...]) -> FloatArray:
    """Return crossings of k loops in the shape of their batch, ``batch + (m,)``.

    `rows`: ``(k, n)``, each with NaN behind its crossings; m is the largest number of them.
    """
    m = int(np.sum(~np.isnan(rows), axis=-1).max(initial=0))
    return rows[:, :m].reshape((*batch, m))
