"""Tables of `tvclin margins`: an autopilot, the margins of its loop, and the criteria."""

from dataclasses import dataclass
from math import isnan
from typing import Any

import numpy as np

from tvclin.base.errors import InputError
from tvclin.base.lines import quantities
from tvclin.base.quantities import satisfaction
from tvclin.cli.output import print_tables, say, say_notes
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
class MarginsFound:
    """The margins of a loop, by band too of a flexible plant, and their criteria."""

    autopilot: Autopilot
    plant: AnyPlant
    whole: Margins
    bands: BandMargins | None
    asked: Criteria

    @classmethod
    def of(cls, autopilot: Autopilot, plant: AnyPlant, asked: Criteria) -> "MarginsFound":
        """Return the margins of a plant, by band too where it is flexible."""
        if plant.structure is None:
            return cls(autopilot, plant, autopilot.margins(plant), None, asked)
        bands = autopilot.band_margins(plant)
        return cls(autopilot, plant, bands.margins, bands, asked)

    @property
    def judged(self) -> tuple[Judgement, ...]:
        """Judgement of each criterion, of the whole loop and of each mode."""
        return self.asked.judge(self.bands or self.whole)

    @property
    def detuned(self) -> Detuned:
        """The margins of a flexible vehicle's loop with detuned modes."""
        assert isinstance(self.plant, FlexiblePlant)  # margins refuses --detuned of all else
        return detuned(self.autopilot, self.plant, criteria=self.asked)

    @property
    def met(self) -> bool:
        """Whether all criteria are satisfied."""
        return bool(self.asked.are_satisfied(self.bands or self.whole))


def print_margins(title: str, result: MarginsFound) -> None:
    """Print an autopilot, the margins of its loop, those by band, and the criteria."""
    loop_margins = result.whole
    print_autopilot(title, result.autopilot, result.plant)
    if loop_margins.stable:
        print_tables(margin_table(loop_margins, result.judged))
        print_bounds(result.autopilot, result.plant)
    else:
        say(f"NO MARGINS: {loop_margins.reason}")
    if result.bands is not None:
        _print_bands(result.bands, result.asked)
    if loop_margins.stable:
        say_notes(loop_margins.notes)
        say(f"Criteria {result.asked.name}: {satisfaction(result.met)}")


def _print_bands(bands: BandMargins, criteria: Criteria) -> None:
    """Print the margins of the rigid body and of each mode, with their criteria."""
    judged = criteria.judge(bands)
    print_tables(band_table(bands, judged))
    judged_modes = {
        judgement.band for judgement in judged if judgement.band and not isnan(judgement.value)
    }
    for word, key in _KEYS.items():
        free = [mode.name for mode in bands.modes if mode.stabilised == word]
        if criteria.has_mode_limits and free and judged_modes.isdisjoint(free):
            say(
                f"Note: {', '.join(free)}: {word}-stabilised, without a required margin ({key} in"
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
    return f"Flexible vehicle (--rigid: without): {structure.parts}"


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


def margins_document(result: MarginsFound) -> dict[str, Any]:
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
        "criteria": {"name": result.asked.name, "met": result.met, "limits": result.judged},
        "notes": loop_margins.notes,
    }


def poles_document(autopilot: Autopilot, plant: AnyPlant) -> dict[str, Any]:
    """Return the closed-loop poles: s [1/s], or z of a sampled autopilot."""
    if autopilot.sample_rate is None:
        return {"closed_loop_poles": autopilot.closed_loop_poles(plant).tolist()}
    loop = autopilot.exact_loop(plant)
    assert isinstance(loop, SampledLoop)
    return {"closed_loop_poles_z": loop.closed_loop_poles.tolist()}
