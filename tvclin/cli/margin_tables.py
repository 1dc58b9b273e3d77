"""Tables of `tvclin margins` and `design`: an autopilot, its margins, and the criteria."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import isnan
from typing import Any

import numpy as np

from tvclin.base.errors import InputError
from tvclin.base.lines import Table, listed, quantities, text
from tvclin.base.quantities import satisfaction
from tvclin.cli.output import print_tables, say
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.detuning import Detuned, detuned
from tvclin.control.autopilot.margin_bounds import MarginBounds, margin_bounds
from tvclin.control.margins.bands import BandMargins
from tvclin.control.margins.criteria import Criteria, Judgement, band_table, margin_table
from tvclin.control.margins.loop import SampledLoop
from tvclin.control.margins.margins import Margins
from tvclin.linear.flexible import AnyPlant, FlexiblePlant
from tvclin.vehicle.structure import Structure

_MAX_POLE_DISTANCE_RATIO = 0.05
"""Largest distance of a pole with approximate delay from an exact pole, over its magnitude."""
_KEYS = {"gain": "mode_gain_margin_dB", "phase": "mode_phase_margin_deg"}
"""Key of the required margin of a mode, by its stabilisation."""


@dataclass(frozen=True, eq=False)
class JudgedMargins:
    """The margins of a loop, by band too of a flexible plant, and their criteria."""

    autopilot: Autopilot
    plant: AnyPlant
    whole: Margins
    bands: BandMargins | None
    criteria: Criteria

    @classmethod
    def of(cls, autopilot: Autopilot, plant: AnyPlant, criteria: Criteria) -> "JudgedMargins":
        """Return the margins of a plant, by band too where it is flexible."""
        if plant.structure is None:
            return cls(autopilot, plant, autopilot.margins(plant), None, criteria)
        bands = autopilot.band_margins(plant)
        return cls(autopilot, plant, bands.margins, bands, criteria)

    @property
    def judged(self) -> tuple[Judgement, ...]:
        """Judgement of each criterion, of the whole loop and of each mode."""
        return self.criteria.judge(self.bands or self.whole)

    @property
    def detuned(self) -> Detuned:
        """The margins of a flexible vehicle's loop with detuned modes."""
        assert isinstance(self.plant, FlexiblePlant)  # `margins` refuses it of all else
        return detuned(self.autopilot, self.plant, criteria=self.criteria)

    @property
    def satisfied(self) -> bool:
        """Whether all criteria are satisfied."""
        return bool(self.criteria.are_satisfied(self.bands or self.whole))

    @property
    def verdict(self) -> str:
        """The verdict on the criteria, with the margins that miss their limits."""
        head = f"criteria {self.criteria.name}: {satisfaction(self.satisfied)}"
        if not self.whole.stable:
            return f"{head}, {self.whole.reason}"
        missed = [judgement for judgement in self.judged if not judgement.satisfied]
        return f"{head} ({listed(text(item.shortfall) for item in missed)})" if missed else head


def margin_tables(result: JudgedMargins, title: str = "Margins") -> tuple[Table, ...]:
    """Return the tables of the margins of a loop and, of a flexible vehicle, of those by band."""
    tables = [margin_table(result.whole, result.judged)] if result.whole.stable else []
    if result.bands is not None:
        tables.append(band_table(result.bands, result.judged))
    return tuple(
        replace(table, caption=title if not k else table.caption) for k, table in enumerate(tables)
    )


def mode_notes(result: JudgedMargins) -> Iterator[str]:
    """Yield notes on modes without a required margin, where others have one."""
    if result.bands is None or not result.criteria.has_mode_limits:
        return
    judged = {item.band for item in result.judged if item.band and not isnan(item.value)}
    for word, key in _KEYS.items():
        free = [mode.name for mode in result.bands.modes if mode.stabilised == word]
        if free and judged.isdisjoint(free):
            yield (
                f"{', '.join(free)}: {word}-stabilised, without a required margin ({key} in"
                " [criteria]); the margins of the whole loop count"
            )


def print_autopilot(title: str, autopilot: Autopilot, plant: AnyPlant) -> None:
    """Print an autopilot, with the poles of its loop or the parts of its flexible vehicle."""
    rows = autopilot.rows()
    if plant.structure is not None:
        say(parts_line(plant.structure))
    elif autopilot.sample_rate is None:
        rows.append(("closed-loop poles [1/s]", (_poles(autopilot, plant),)))
    print_tables(quantities(title, rows), *autopilot.filter_tables())


def parts_line(structure: Structure) -> str:
    """Return the line that lists the parts of a flexible vehicle."""
    return f"Flexible vehicle (--set study.rigid true: without): {structure.parts}"


def print_bounds(autopilot: Autopilot, plant: AnyPlant) -> None:
    """Print the bounds on the margins of any autopilot with this plant, actuator and delay."""
    bounds = _bounds(autopilot, plant)
    if bounds is not None and bounds.sentence:
        say(f"Bounds: {bounds.sentence}.")


def _bounds(autopilot: Autopilot, plant: AnyPlant) -> MarginBounds | None:
    """Return the bounds on the margins; None for a plant without an unstable pole."""
    try:
        return margin_bounds(plant, actuator=autopilot.actuator, delay=float(autopilot.delay))
    except InputError:
        return None


def _poles(autopilot: Autopilot, plant: Any) -> str:
    """Return the closed-loop poles [1/s] as text, without those that only approximate the delay."""
    loop_poles = np.sort_complex(autopilot.closed_loop_poles(plant))[::-1]
    if autopilot.delay:
        exact = autopilot.exact_loop(plant).closed_loop_poles
        distance = np.abs(loop_poles[:, np.newaxis] - exact).min(axis=1)
        loop_poles = loop_poles[
            (loop_poles.real > 0.0) | (distance <= _MAX_POLE_DISTANCE_RATIO * np.abs(loop_poles))
        ]
    shown = [
        f"{p.real:.4g}" if p.imag == 0.0 else f"{p.real:.4g}±{p.imag:.4g}j" for p in loop_poles
    ]
    return ", ".join(dict.fromkeys(text for text in shown if "±-" not in text))


def margins_document(result: JudgedMargins) -> dict[str, Any]:
    """Return gains, poles, margins and criteria for JSON; what does not exist becomes null."""
    loop_margins, autopilot = result.whole, result.autopilot
    return {
        "flexible": result.bands is not None,
        "autopilot": autopilot,
        **poles_document(autopilot, result.plant),
        "stable": loop_margins.stable,
        "status": loop_margins.status,
        "reason": loop_margins.reason or None,
        "margins": loop_margins,
        "bounds": _bounds(autopilot, result.plant),
        **({} if result.bands is None else {"bands": result.bands}),
        "criteria": {
            "name": result.criteria.name,
            "met": result.satisfied,
            "limits": result.judged,
        },
        "notes": loop_margins.notes,
    }


def poles_document(autopilot: Autopilot, plant: AnyPlant) -> dict[str, Any]:
    """Return the closed-loop poles: s [1/s], or z of a sampled autopilot."""
    if autopilot.sample_rate is None:
        return {"closed_loop_poles": autopilot.closed_loop_poles(plant).tolist()}
    loop = autopilot.exact_loop(plant)
    assert isinstance(loop, SampledLoop)
    return {"closed_loop_poles_z": loop.closed_loop_poles.tolist()}
