"""What a wind with a direction asks of the nozzle over time, against its stop."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tvclin.answers.study import Study
from tvclin.base.errors import InputError, between, instance, number, single
from tvclin.boundary.planes.limit import plane_limit
from tvclin.boundary.planes.pair import Pair, checked
from tvclin.boundary.stops import Stop, stop_of
from tvclin.linear.plant import Plant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, WARM, Look, Style, called, draw
from tvclin.vehicle.coefficients import PLANES
from tvclin.winds.plane_wind import PlaneWind, unit_vector

if TYPE_CHECKING:
    from control import ControlPlot


TRIMS, MEANS = "trim, over time", "mean of the trim to come"
HELD, STOP = "held from the dead band on", "the stop at the least limit"
_TIMES, _SIDES = 240, 360
_ROOM = 0.06
"""Around what is drawn, over its size."""


def plane_chart(
    plant: Plant,
    wind: PlaneWind,
    stop: Stop | str = "round",
    dead_band: float = 1.0,
    yaw_plant: Plant | None = None,
) -> ControlPlot:
    """Draw the deflections that a wind asks for in pitch and yaw, against the stop.

    The trim deflection wanders with the wind; the mean of the trim to come, discounted, is what
    must be held from then on, eq (4b). The least limit is that at which the stop reaches the mean
    where the dead band is left, which is held.

    Parameters
    ----------
    plant, wind, stop, dead_band, yaw_plant
        As of `plane_limit`, one of each; a stop may be a word, as of `size`.

    Raises
    ------
    InputError
        As `plane_limit`, and for batches.
    """
    shape = stop_of(stop)
    checked(plant, wind, shape, yaw_plant)
    for name, one in (("plant", plant), ("yaw_plant", yaw_plant or plant)):
        single(name, one.batch)
    dead_band = number("dead_band", dead_band, between(0.0, 1.0))
    found = plane_limit(plant, wind, shape, dead_band, "literal", yaw_plant)
    pair = Pair((plant, yaw_plant or plant), wind)
    knots = np.union1d(wind.pitch.knots, wind.yaw.knots)
    ends = float(wind.onset), float(wind.end)
    times = np.union1d(knots[(knots > ends[0]) & (knots < ends[1])], np.linspace(*ends, _TIMES))
    around = 2.0 * np.pi * np.arange(_SIDES + 1) / _SIDES
    held = found.in_plane + 1j * found.across
    vectors = {
        STOP: found.deflection * shape.reach(around) * unit_vector(around),
        TRIMS: pair.trim(times),
        MEANS: pair.held(times),
        HELD: np.array([0.0, held]),
    }
    whole = np.concatenate(list(vectors.values())) * (180.0 / np.pi)
    first, columns = 0, []
    for label, values in vectors.items():
        across = np.full(whole.size, np.nan)
        across[first : first + values.size] = whole[first : first + values.size].imag
        columns.append(Column(label, across, "deg"))
        first += values.size
    words = (
        f"{plant.model}, K = {dead_band:g}, limit {np.degrees(found.deflection):.4f} deg, pitch"
        f" alone {np.degrees(found.pitch_alone):.4f} deg"
    )
    curves = Curves("planes", words, "deflection in pitch [deg]", whole.real, tuple(columns))
    title = called(plant.coefficients.name, f"Deflection that a wind needs in both planes\n{words}")
    look = Look(title, "deflection in yaw [deg]", _styles())
    plot = draw(curves, look)
    axes, most = plot.axes[0, 0], (1.0 + _ROOM) * np.abs([whole.real, whole.imag]).max()
    axes.set(xlim=(-most, most), ylim=(-most, most))
    axes.set_aspect("equal")
    return plot


def study_planes_chart(study: Study) -> ControlPlot:
    """Draw the same of a study whose wind has a direction.

    Raises
    ------
    InputError
        For a study of a wind without one, and as `plane_chart`.
    """
    instance("study", study, Study, "see Study.from_vehicle")
    if study.slanting is None or study.planes is None:
        raise InputError("study must be of a wind with a direction: give it a heading")
    pitch, yaw = (Plant.from_vehicle(study.vehicle, study.model, plane) for plane in PLANES)
    return plane_chart(pitch, study.planes.wind, study.planes.stop, study.dead_band, yaw)


def _styles() -> dict[str, Style]:
    return {
        STOP: {"color": WARM, "ls": "-", "lw": 1.4},
        TRIMS: {"color": INK, "ls": "--", "lw": 1.4},
        MEANS: {"color": COLOURS[0], "ls": "-", "lw": 1.8},
        HELD: {"color": COLOURS[1], "ls": "-", "lw": 1.8, "marker": "o", "ms": 5.0},
    }
