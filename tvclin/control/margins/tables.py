"""Margins as tables, of the whole loop and by band, beside what criteria ask of them."""

from collections.abc import Sequence

import numpy as np

from tvclin.base.lines import Line, Table, labelled, number, significant
from tvclin.control.margins.bands import GAIN, PHASE, RIGID, BandMargins, ModeBand
from tvclin.control.margins.criteria import Judgement
from tvclin.control.margins.record import MARGINS, Margins, factor_to, margin

_WORDS = {RIGID: "rigid"}
_FACTORS = {"aero_margin_dB": "aero_margin", "gain_increase_dB": "gain_increase"}
"""The factors on the gain that stand beside their size in dB."""


def margin_table(found: Margins, judged: Sequence[Judgement] = ()) -> Table:
    """Return the margins of one stable loop, where they are, and by how much criteria are met."""
    asked = {one.requirement.margin: one for one in judged if not one.band}
    rows: list[tuple[Line, ...]] = []
    for name, label, value, unit, frequency in found.rows():
        key = f"margin.{name}"
        at, shown = significant(f"{key}.rad_per_s", frequency), margin(key, value, unit)
        if name in _FACTORS and np.isfinite(value):
            factor = significant(f"{key}.factor", getattr(found, _FACTORS[name]), 3)
            shown = (*shown, " (", *factor, "x)")
        rows.append((labelled(label), shown, at, *_asked(asked.get(name))))
        if name == "disk_margin":
            gain = margin(f"{key}.gain", found.disk_margin_dB, "dB")
            phase = margin(f"{key}.phase", found.disk_phase_deg, "deg")
            rows.append((("  gain and phase",), (*gain, ", ", *phase), ("",), ("",), ("",)))
    return Table("Margins", ("margin", "value", "at [rad/s]", "asked", "by"), tuple(rows))


def band_table(found: BandMargins, judged: Sequence[Judgement] = ()) -> Table:
    """Return what the rigid body has, if the loop is stable, and what each mode has."""
    rows: list[tuple[Line, ...]] = []
    for name, label in zip(MARGINS, ("down", "up", "phase"), strict=False):
        _, unit, where = MARGINS[name]
        at = significant(f"rigid.{name}.rad_per_s", getattr(found.rigid, where))
        spare = margin(f"rigid.{name}", getattr(found.rigid, name), unit)
        rows.append(((f"rigid, {label}",), ("",), at, spare, ("",), ("",)))
    rows = rows if found.whole.stable else []
    asked = {one.band: one for one in judged if one.band and not np.isnan(one.value)}
    rows += [(*_mode(k, one), *_asked(asked.get(one.name))) for k, one in enumerate(found.modes)]
    head = ("band", "held by", "at [rad/s]", "margin", "asked", "by")
    width = len(head) if asked else len(head) - 2
    return Table("Margins by band", head[:width], tuple(row[:width] for row in rows))


def _mode(k: int, mode: ModeBand) -> tuple[Line, ...]:
    key = f"band.{k}"
    spare = {
        GAIN: margin(f"{key}.gain", mode.gain_margin_dB, "dB"),
        PHASE: margin(f"{key}.phase", mode.phase_margin_deg, "deg"),
        RIGID: (*number(f"{key}.distance", mode.distance, 2), " from -1"),
    }
    return (
        (mode.name,),
        (_WORDS.get(mode.stabilised, str(mode.stabilised)),),
        significant(f"{key}.rad_per_s", mode.frequency),
        spare.get(mode.stabilised, ("none",)),
    )


def _asked(one: Judgement | None) -> tuple[Line, Line]:
    """What is asked of a margin, and by how much it is met."""
    if one is None:
        return ("",), ("",)
    limit, unit = one.requirement.shown
    key = f"criteria.{one.band}{'.' * bool(one.band)}{one.requirement.margin}"
    most = ("at most ",) if one.requirement.at_most else ()
    surplus = factor_to(unit) * one.surplus
    by = ("+" if 0.0 <= surplus < np.inf else "", *significant(f"{key}.surplus", surplus, 3))
    return (
        (*most, *significant(key, limit, unit=unit)),
        (*by, " met" if one.met else " NOT MET"),
    )
