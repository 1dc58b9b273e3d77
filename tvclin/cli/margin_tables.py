"""What `tvclin margins` prints: an autopilot, the margins of its loop, and the criteria."""

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

_BESIDE = 0.05
"""A pole of an approximate delay is that of the exact one if it is so near, over its size."""
_OPTIONS = {"gain": "--mode-gain-db", "phase": "--mode-phase-deg"}


@dataclass(frozen=True, eq=False)
class MarginsFound:
    """The margins of a loop, by band too of a flexible plant, and what is asked of them."""

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
        """What is asked, of the whole loop and of each mode, and whether it is met."""
        return self.asked.judge(self.bands or self.whole)

    @property
    def detuned(self) -> Detuned:
        """The margins of a flexible vehicle's loop with detuned modes."""
        assert isinstance(self.plant, FlexiblePlant)  # margins refuses --detuned of all else
        return detuned(self.autopilot, self.plant, criteria=self.asked)

    @property
    def met(self) -> bool:
        """Whether all of it is met."""
        return bool(self.asked.are_satisfied(self.bands or self.whole))


def print_margins(title: str, found: MarginsFound) -> None:
    """Print an autopilot, the margins of its loop, those by band, and the criteria."""
    whole = found.whole
    print_autopilot(title, found.autopilot, found.plant)
    if whole.stable:
        print_tables(margin_table(whole, found.judged))
        print_bounds(found.autopilot, found.plant)
    else:
        say(f"NO MARGINS: {whole.reason}")
    if found.bands is not None:
        _print_bands(found.bands, found.asked)
    if whole.stable:
        say_notes(whole.notes)
        say(f"Criteria {found.asked.name}: {satisfaction(found.met)}")


def _print_bands(found: BandMargins, asked: Criteria) -> None:
    """Print what the rigid body has and what each mode has, beside what is asked of modes."""
    judged = asked.judge(found)
    print_tables(band_table(found, judged))
    judged_modes = {one.band for one in judged if one.band and not isnan(one.value)}
    for word, option in _OPTIONS.items():
        free = [mode.name for mode in found.modes if mode.stabilised == word]
        if asked.has_mode_limits and free and judged_modes.isdisjoint(free):
            say(
                f"Note: {', '.join(free)}: {word}-stabilised, without a required margin ({option});"
                " the margins of the whole loop count"
            )


def print_autopilot(title: str, autopilot: Autopilot, plant: AnyPlant) -> None:
    """Print an autopilot, with the poles of its loop or what makes its vehicle flexible."""
    rows = autopilot.rows()
    if plant.structure is not None:
        say(parts_line(plant.structure))
    elif autopilot.sample_rate is None:
        rows.append(("closed-loop poles [1/s]", (_poles(autopilot, plant),)))
    print_tables(quantities(title, rows), *autopilot.filter_tables())


def parts_line(structure: Structure) -> str:
    """Return in one line what makes a vehicle flexible."""
    return f"Flexible vehicle (--rigid: without): {structure.parts}"


def print_bounds(autopilot: Autopilot, plant: AnyPlant) -> None:
    """Print what no autopilot around a plant with this nozzle and delay can have."""
    found = _bounds(autopilot, plant)
    if found is not None and found.sentence:
        say(f"Bounds: {found.sentence}.")


def _bounds(autopilot: Autopilot, plant: AnyPlant) -> MarginBounds | None:
    """What bounds the margins; None where nothing grows."""
    try:
        return margin_bounds(plant, actuator=autopilot.actuator, delay=float(autopilot.delay))
    except InputError:
        return None


def _poles(autopilot: Autopilot, plant: Any) -> str:
    """The closed-loop poles [1/s], those that only approximate the delay left out."""
    every = np.sort_complex(autopilot.closed_loop_poles(plant))[::-1]
    if autopilot.delay:
        exact = autopilot.exact_loop(plant).closed_loop_poles
        apart = np.abs(every[:, np.newaxis] - exact).min(axis=1)
        every = every[(every.real > 0.0) | (apart <= _BESIDE * np.abs(every))]
    shown = [f"{p.real:.4g}" if p.imag == 0.0 else f"{p.real:.4g}±{p.imag:.4g}j" for p in every]
    return ", ".join(dict.fromkeys(text for text in shown if "±-" not in text))


def margins_document(found: MarginsFound) -> dict[str, Any]:
    """Return gains, poles, margins and criteria for JSON; what does not exist becomes null."""
    whole, autopilot = found.whole, found.autopilot
    return {
        "flexible": found.bands is not None,
        "autopilot": autopilot,
        **poles_document(autopilot, found.plant),
        "stable": whole.stable,
        "status": whole.status,
        "reason": whole.reason or None,
        "margins": whole,
        "bounds": _bounds(autopilot, found.plant),
        **({} if found.bands is None else {"bands": found.bands}),
        "criteria": {"name": found.asked.name, "met": found.met, "requirements": found.judged},
        "notes": whole.notes,
    }


def poles_document(autopilot: Autopilot, plant: AnyPlant) -> dict[str, Any]:
    """Return the closed-loop poles: s [1/s], or z of a sampled autopilot."""
    if autopilot.sample_rate is None:
        return {"closed_loop_poles": autopilot.closed_loop_poles(plant).tolist()}
    loop = autopilot.exact_loop(plant)
    assert isinstance(loop, SampledLoop)
    return {"closed_loop_poles_z": loop.closed_loop_poles.tolist()}
