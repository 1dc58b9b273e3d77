"""What `tvclin margins` says of the bands of a flexible vehicle: rigid body, bending, slosh."""

from math import isnan

from tvclin.cli.output import print_tables, say
from tvclin.control.margins.bands import BandMargins
from tvclin.control.margins.criteria import Criteria
from tvclin.control.margins.tables import band_table
from tvclin.vehicle.structure import Structure

_OPTIONS = {"gain": "--mode-gain-db", "phase": "--mode-phase-deg"}


def print_bands(found: BandMargins, asked: Criteria) -> None:
    """Print what the rigid body has and what each mode has, beside what is asked of modes."""
    judged = asked.judge(found)
    print_tables(band_table(found, judged))
    judged_modes = {one.band for one in judged if one.band and not isnan(one.value)}
    for word, option in _OPTIONS.items():
        free = [mode.name for mode in found.modes if mode.stabilised == word]
        if asked.of_modes and free and judged_modes.isdisjoint(free):
            say(
                f"Note: {', '.join(free)}: {word}-stabilised, without a required margin ({option});"
                " the margins of the whole loop count"
            )


def parts_line(structure: Structure) -> str:
    """Return in one line what makes a vehicle flexible."""
    counted = (("bending mode", len(structure.bending)), ("tank", len(structure.slosh)))
    parts = [f"{count} {name}{'s' * (count > 1)}" for name, count in counted if count]
    parts += ["engine with inertia"] * (structure.engine is not None)
    lags = {"attitude sensor": structure.attitude_sensor, "rate gyro": structure.rate_gyro}
    parts += [f"lag of the {name}" for name, lag in lags.items() if lag is not None]
    return f"Flexible vehicle (--rigid: without): {', '.join(parts)}"
