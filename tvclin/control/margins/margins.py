"""Stability margins of a loop, under names that cannot be misread.

All follow from L(j omega): gain and phase at its crossings, the disk margin and the peaks of S =
1/(1 + L) and T = L/(1 + L). The arithmetic is that of `numerics.loop_margins`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Row, Shown, card
from tvclin.base.documents import decibels, keyed
from tvclin.base.errors import InputError, instance, plain
from tvclin.base.lines import Line, number, text
from tvclin.control.margins.loop import Loop
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
"""Of what criteria are asked: a label, the unit that is shown, and where the frequency stands."""


class MarginRow(NamedTuple):
    """A margin as tables show it: its name in `Margins`, and at what frequency [rad/s] it is."""

    name: str
    label: str
    value: Any
    unit: str
    frequency: Any


DIGITS = {"dB": 2, "deg": 2, "ms": 1, "": 3}
"""Behind the point of margins, by unit."""


def margin(name: str, value: Any, unit: str) -> Line:
    """Return a margin with the digits of its unit."""
    return number(name, value, DIGITS[unit], unit)


def factor_to(unit: str) -> float:
    """Return what a margin is multiplied with to be shown in a unit."""
    return 1000.0 if unit == "ms" else 1.0


@dataclass(frozen=True, eq=False)
class Crossings:
    """Every crossing, sorted by kind; frequencies rise along the last axis, NaN fills the rest.

    With a delay there are phase crossovers without end; they are listed up to where the loop gain
    stays below 1/100 and at least one turn of the delay's phase further.

    Attributes
    ----------
    gain_frequencies : ndarray
        Gain crossovers, ``|L| = 1`` [rad/s], ``(..., k)``.
    phase_margins : ndarray
        The phase [rad] by which L may lag more there (positive) or lead more (negative) before
        it is -1, ``(..., k)``.
    phase_frequencies : ndarray
        Phase crossovers, L real and negative [rad/s], ``(..., m)``.
    gain_factors : ndarray
        The factor on the loop gain with which L is -1 there, ``(..., m)``: above one an increase,
        below one a reduction (the aerodynamic side).
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
    """How far a loop is from instability; every number has the shape ``(...)`` of the batch.

    For a loop whose closed loop is not stable every margin is NaN: it has none. A margin that
    does not exist is infinite, and so is its frequency NaN; `notes` says why.

    Attributes
    ----------
    status : str or ndarray of str
        "ok", "unstable" (closed-loop poles in the right half plane) or "marginal" (on the axis).
    unstable_poles : int or ndarray of int
        Number of closed-loop poles in the right half plane, with the exact delay.
    aero_margin : float or ndarray
        The factor by which the loop gain may be divided; an unstable vehicle falls over below.
    gain_increase : float or ndarray
        The factor by which the loop gain may be multiplied.
    phase_margin : float or ndarray
        The least phase [rad], lag or lead, that makes L = -1 at a gain crossover.
    delay_margin : float or ndarray
        The further delay [s] that the loop bears.
    disk_margin : float or ndarray
        alpha = ``1/max |(S - T)/2|``: gain and phase may change together by any factor in the disk
        with the real axis cuts (2 - alpha)/(2 + alpha) and (2 + alpha)/(2 - alpha).
    peak_sensitivity, peak_complementary_sensitivity : float or ndarray
        Largest ``|S|`` and ``|T|``.
    aero_frequency, gain_increase_frequency, crossover_frequency, delay_margin_frequency, \
disk_frequency, peak_sensitivity_frequency, peak_complementary_sensitivity_frequency : \
float or ndarray
        Where each of them is found [rad/s]; `crossover_frequency` belongs to `phase_margin`.
    crossings : Crossings
        All crossings, also those that do not decide.
    """

    status: Any
    unstable_poles: Any
    aero_margin: Any
    aero_frequency: Any
    gain_increase: Any
    gain_increase_frequency: Any
    phase_margin: Any
    crossover_frequency: Any
    delay_margin: Any
    delay_margin_frequency: Any
    disk_margin: Any
    disk_frequency: Any
    peak_sensitivity: Any
    peak_sensitivity_frequency: Any
    peak_complementary_sensitivity: Any
    peak_complementary_sensitivity_frequency: Any
    crossings: Crossings

    _keys = "status aero_margin_dB gain_increase_dB phase_margin_deg delay_margin_s disk_margin"

    def rows(self) -> list[MarginRow]:
        """Return the margins that criteria are asked of, as tables show them."""
        return [
            MarginRow(name, label, factor_to(unit) * getattr(self, name), unit, getattr(self, at))
            for name, (label, unit, at) in MARGINS.items()
        ]

    as_dict = keyed(
        "unstable_poles aero_margin_dB aero_frequency_rad_per_s gain_increase_dB"
        " gain_increase_frequency_rad_per_s phase_margin_deg crossover_frequency_rad_per_s"
        " delay_margin_s delay_margin_frequency_rad_per_s disk_margin disk_margin_dB"
        " disk_frequency_rad_per_s peak_sensitivity peak_sensitivity_frequency_rad_per_s"
        " peak_complementary_sensitivity peak_complementary_sensitivity_frequency_rad_per_s"
    )

    def _repr_html_(self) -> str:
        rows: list[Row] = [("status", self.status, "")]
        for name, label, value, unit, at in self.rows():
            shown = value if np.ndim(value) else text(margin(name, value, unit)[:1])
            rows += [(label, shown, unit), ("at", at, "rad/s")]
        return card("Margins", rows)

    @property
    def stable(self) -> Any:
        """Whether the closed loop is stable."""
        return self.status == OK

    @property
    def disk_margin_dB(self) -> Any:
        """The gain in dB, up or down, that the disk allows whatever the phase within it."""
        alpha = np.asarray(self.disk_margin)
        with np.errstate(divide="ignore"):
            return decibels((2.0 + alpha) / np.maximum(2.0 - alpha, 0.0))

    @property
    def disk_phase_deg(self) -> Any:
        """The phase in degrees, lag or lead, that the disk allows: 2 arctan(alpha/2)."""
        return plain(np.degrees(2.0 * np.arctan(self.disk_margin / 2.0)))

    @property
    def reason(self) -> str:
        """Why there are no margins, in one sentence; empty for a stable loop. One loop only."""
        if not isinstance(self.status, str):
            raise InputError(
                "reason and notes are of one loop; these are margins of a batch of shape"
                f" {np.shape(self.status)} (use status and unstable_poles)"
            )
        if self.status == UNSTABLE:
            many = (
                f"{self.unstable_poles} closed-loop poles lie"
                if self.unstable_poles != 1
                else ("1 closed-loop pole lies")
            )
            return f"the closed loop is unstable: {many} in the right half plane"
        if self.status == MARGINAL:
            return "the closed loop is not asymptotically stable: a pole lies on the imaginary axis"
        return ""

    @property
    def notes(self) -> tuple[str, ...]:
        """What is to be known about margins that do not exist. One loop only."""
        if self.reason:
            return (self.reason,)
        found = []
        if np.isinf(self.aero_margin):
            found.append("aero margin inf: the loop stays stable however far its gain falls")
        if np.isinf(self.gain_increase):
            found.append(
                "gain-increase margin inf: the loop stays stable however far its gain rises, which"
                " no loop with an actuator and a delay does"
            )
        if np.isinf(self.phase_margin):
            found.append("phase and delay margin inf: the loop gain is one at no frequency")
        return tuple(found)


def loop_margins(loop: Loop) -> Margins:
    """Return the margins of one loop or of thousands; the closed-loop poles come first.

    Parameters
    ----------
    loop : Loop
        One or a batch, of shape ``(...)``.

    Returns
    -------
    Margins
        Each with its status: an unstable loop in a batch does not touch the others.

    Notes
    -----
    Stability is decided by the closed-loop poles without the delay and, with one, by counting what
    crosses the imaginary axis as it grows: exactly, not by an approximation of the delay. Gain
    crossovers are roots of ``|N|^2 - |D|^2``, or eigenvalues of a Hamiltonian matrix. Phase
    crossovers and peaks are bracketed between frequencies laid around all poles and zeros, and
    refined to rounding.

    Examples
    --------
    >>> from tvclin.control.margins.loop import Loop
    >>> from tvclin.control.margins.margins import loop_margins
    >>> m = loop_margins(Loop([1.317 * 1.59, 1.317 * 1.88], [1, 0, -0.228]))
    >>> round(m.phase_margin_deg, 1), round(m.aero_margin_dB, 1), m.gain_increase
    (62.4, 20.7, inf)
    """
    instance("loop", loop, Loop, "see Loop.from_system")
    return margins_of(loop.findings(), loop.batch)


def margins_of(found: LoopAnalysis, batch: tuple[int, ...]) -> Margins:
    """Return the margins in what was found of loops on one axis, in the shape of their batch."""
    good = found.stable
    status = np.where(found.marginal, MARGINAL, np.where(good, OK, UNSTABLE))
    status = np.where(found.unstable_poles > 0, UNSTABLE, status)
    tops = found.peaks.transpose(1, 2, 0)[[2, 0, 1]]
    tops[0, 0] = 1.0 / tops[0, 0]
    pairs = np.concatenate([classical_margins(found), tops])
    pairs[..., ~good] = np.nan
    numbers = (status, found.unstable_poles, *pairs.reshape(2 * len(pairs), good.size))
    lists = (found.gain_frequencies, found.phases, found.phase_frequencies, found.factors)
    crossings = Crossings(*(_trimmed(rows, batch) for rows in lists))
    names = [field.name for field in fields(Margins)][:-1]
    shaped = {name: in_shape(one, batch) for name, one in zip(names, numbers, strict=True)}
    return Margins(**shaped, crossings=crossings)


def in_shape(values: Any, batch: tuple[int, ...]) -> Any:
    """Return a number of each loop on one axis in the shape of their batch; of one a plain one."""
    array = np.asarray(values).reshape(batch)
    return array if array.ndim else array.item()


def _trimmed(rows: FloatArray, batch: tuple[int, ...]) -> FloatArray:
    width = int(np.sum(~np.isnan(rows), axis=-1).max(initial=0))
    return rows[:, :width].reshape((*batch, width))
