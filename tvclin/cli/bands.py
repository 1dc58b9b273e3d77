"""What `tvclin margins` says of the bands of a flexible vehicle: rigid body, bending, slosh."""

from math import isnan
from typing import TYPE_CHECKING

from tvclin.cli.output import say

if TYPE_CHECKING:
    from tvclin.control.margins.bands import BandMargins, ModeBand, RigidBand
    from tvclin.control.margins.criteria import Criteria, Judgement
    from tvclin.vehicle.structure import Structure

_HEADINGS = ["band", "held by", "at [rad/s]", "margin", "asked", "by"]
_WORDS = {"with the rigid body": "rigid"}
_OPTIONS = {"gain": "--mode-gain-db", "phase": "--mode-phase-deg"}


def print_bands(found: "BandMargins", asked: "Criteria") -> None:
    """Print what the rigid body has and what each mode has, beside what is asked of modes."""
    from tvclin.cli.output import print_table

    rows = _rigid(found.rigid) if found.whole.stable else []
    asked_of = {one.band: one for one in asked.judge(found) if one.band and not isnan(one.value)}
    rows += [[*_mode(mode), *judged_cells(asked_of.get(mode.name))] for mode in found.modes]
    columns = len(_HEADINGS) if asked_of else len(_HEADINGS) - 2
    print_table("By band", _HEADINGS[:columns], [row[:columns] for row in rows])
    for word, option in _OPTIONS.items():
        free = [mode.name for mode in found.modes if mode.stabilised == word]
        judged = any(name in asked_of for name in free)
        if asked.of_modes and free and not judged:
            say(
                f"Note: {', '.join(free)}: {word}-stabilised, without a required margin ({option});"
                " the margins of the whole loop count"
            )


def judged_cells(one: "Judgement | None") -> list[str]:
    """Return what is asked of a margin, and by how much it is met, as two cells."""
    from tvclin.control.margins.record import factor_to

    if one is None:
        return ["", ""]
    limit, unit = one.requirement.shown
    asked = f"{'at most ' if one.requirement.at_most else ''}{limit:g} {unit}"
    by = f"{factor_to(unit) * one.surplus:+.3g}"
    return [asked.strip(), f"{by} {'met' if one.met else 'NOT MET'}"]


def parts_line(structure: "Structure") -> str:
    """Return in one line what makes a vehicle flexible."""
    counted = (("bending mode", len(structure.bending)), ("tank", len(structure.slosh)))
    parts = [f"{count} {name}{'s' * (count > 1)}" for name, count in counted if count]
    parts += ["engine with inertia"] * (structure.engine is not None)
    lags = {"attitude sensor": structure.attitude_sensor, "rate gyro": structure.rate_gyro}
    parts += [f"lag of the {name}" for name, lag in lags.items() if lag is not None]
    return f"Flexible vehicle (--rigid: without): {', '.join(parts)}"


def _rigid(rigid: "RigidBand") -> list[list[str]]:
    parts = (
        ("down", rigid.aero_margin_dB, "dB", rigid.aero_frequency),
        ("up", rigid.gain_increase_dB, "dB", rigid.gain_increase_frequency),
        ("phase", rigid.phase_margin_deg, "deg", rigid.crossover_frequency),
    )
    return [
        [f"rigid, {label}", "", _shown(at, ".4g"), _shown(value, ".2f", unit), "", ""]
        for label, value, unit, at in parts
    ]


def _mode(mode: "ModeBand") -> list[str]:
    margin = {
        "gain": _shown(mode.gain_margin_dB, ".2f", "dB"),
        "phase": _shown(mode.phase_margin_deg, ".2f", "deg"),
        "with the rigid body": f"{mode.distance:.2f} from -1",
    }
    return [
        mode.name,
        _WORDS.get(mode.stabilised, mode.stabilised),
        _shown(mode.frequency, ".4g"),
        margin.get(mode.stabilised, "none"),
    ]


def _shown(value: float, digits: str, unit: str = "") -> str:
    return "-" if isnan(value) else f"{value:{digits}} {unit}".rstrip()
