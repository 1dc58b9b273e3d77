"""All numbers for the choices, and the verdict: a pure function."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.answers.requirement import covers
from tvclin.control.laws.registry import AUTOPILOT, DEAD_BAND
from tvclin.control.margins.record import Margins
from tvclin.show.explorer import parts
from tvclin.show.explorer.choices import REPORT, Choices

FloatArray = NDArray[np.float64]

_HELD = (
    "the report's control holds the limit for ever, and a limit above the boundary then turns"
    " the vehicle over to the other side; a law lets go of it"
)
_CALM = (
    "the dynamic pressure is that of calm air; tvclin study counts the more that a head wind needs"
)
_STRONG = float(np.radians(1.5))
"""Winds [rad] above this change it by more than a few percent."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What the panel shows.

    Attributes
    ----------
    choices : Choices
        What was asked.
    durations, boundary : ndarray
        The deflection that is needed [rad] over the duration of the wind [s], ``(n,)``; the
        second is None where there is no answer, as are the next three.
    whole : bool
        Whether that is the whole curve.
    required : float or None
        The same at the chosen duration [rad].
    motion : Motion or None
        Response or flight over time.
    margins : Margins or None
        Of the law's gains, if it has any.
    verdict : str
        One or two sentences.
    notes : tuple of str
        Why there is no answer, and warnings.
    """

    choices: Choices
    durations: FloatArray
    boundary: FloatArray | None
    whole: bool
    required: float | None
    motion: parts.Motion | None
    margins: Margins | None
    verdict: str
    notes: tuple[str, ...]


def answer(choices: Choices, most: int | None = None) -> Answer:
    """Return all numbers for the choices, with at most so many pieces of the curve.

    A part that cannot be answered, such as a law for a stable vehicle, is None and has its reason
    among the notes.
    """
    c = choices
    plant, law = (c.vehicle, c.plane, c.model), (c.law, _own_numbers(c))
    durations = parts.pieces(c.model, c.dead_band)
    known = durations[:most]
    wanted = *plant, c.shape, c.dead_band
    curve = [parts.boundary(*wanted, piece) for piece in known]
    point = parts.boundary(*wanted, (c.duration,))
    margins = parts.loop_margins(*plant, law, c.delay)
    wind = c.shape, c.duration, c.peak
    motion = parts.motion(*plant, wind, c.limit, law)
    values = [piece.value for piece in curve]
    unknown = point.value is None or any(value is None for value in values)
    boundary = None if unknown else np.concatenate([[], *values]) * abs(c.peak)
    required = None if point.value is None else float(point.value[0]) * abs(c.peak)
    notes = [note for part in (*curve, point, motion, margins) for note in part.notes]
    if c.law == REPORT and required is not None and c.limit > required > 0.0:
        notes.append(_HELD)
    if c.plane == "pitch" and abs(c.peak) > _STRONG and required:
        notes.append(_CALM)
    return Answer(
        choices=c,
        durations=np.concatenate([[], *known]),
        boundary=boundary,
        whole=len(known) == len(durations),
        required=required,
        motion=motion.value,
        margins=margins.value,
        verdict=_verdict(c, required, motion.value),
        notes=tuple(dict.fromkeys(notes)),
    )


def _own_numbers(c: Choices) -> tuple[float, ...]:
    """What the law depends on besides vehicle, wind and limit."""
    if c.law in (REPORT, DEAD_BAND):
        return (c.dead_band,)
    return (c.attitude_gain, c.rate_gain) if c.law == AUTOPILOT else ()


def _verdict(c: Choices, required: float | None, motion: parts.Motion | None) -> str:
    if required is None:
        return "No answer for these choices."
    have, need = float(np.degrees(c.limit)), float(np.degrees(required))
    enough = covers(c.limit, required)
    if not required:
        said = "No deflection is needed: no unstable pole that a wind could excite."
    else:
        said = (
            f"{'Enough' if enough else 'Not enough'}: with K = {c.dead_band:g} this wind needs"
            f" {need:.3f} deg, and the limit is {have:.3f} deg."
        )
    if motion is None or motion.survived is None:
        return said
    fate = "brings the vehicle back" if motion.survived else "loses the vehicle"
    return f"{said} Flown, the law {c.law} {fate}."
