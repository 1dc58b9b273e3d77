"""The section of a flexible vehicle: its modes, margins by band, detuning, and the flight."""

from typing import Any

import numpy as np

from tvclin.base.lines import Line, Table, degrees, minimum_limit, number, significant
from tvclin.case.flexible_autopilot import FlexibleAnswer, shift_of
from tvclin.control.margins.criteria import band_table
from tvclin.linear.flexible import FlexiblePlant, named_modes
from tvclin.linear.plant import DEFAULT_MODEL
from tvclin.plots import bode_chart
from tvclin.show.report.blocks import Block, Paragraph, Section, checks
from tvclin.show.report.figures import figure_of
from tvclin.studyfile.findings import Findings
from tvclin.vehicle.filters import filter_cells
from tvclin.vehicle.structure import Structure

_NAME, _TITLE = "flexible", "The flexible vehicle"
_BENDING = {
    "frequency": " [rad/s]",
    "damping": "",
    "modal_mass": " [kg]",
    "gimbal_displacement": "",
    "gimbal_slope": " [1/m]",
    "attitude_slope": " [1/m]",
    "rate_slope": " [1/m]",
    "pressure_displacement": "",
}
_SLOSH = {
    "mass": " [kg]",
    "station": " [m]",
    "damping": "",
    "pendulum_length": " [m]",
    "frequency": " [rad/s]",
}
_ENGINE = {"mass": " [kg]", "arm": " [m]", "moment_of_inertia": " [kg m^2]"}
"""Fields shown of a bending mode, a slosh mode and the engine, with their units."""


def flexible(findings: Findings) -> Section | None:
    """Return the section of modes, margins and flight; None for a rigid vehicle."""
    plan, f = findings.plan, findings.flexible
    if plan.vehicle.structure is None:
        return None
    arguments = plan.vehicle, plan.vehicle.structure, DEFAULT_MODEL, plan.plane
    plant = FlexiblePlant.from_vehicle(*arguments) if f is None else f.plant
    blocks: list[Block] = [Paragraph(_words(plant)), *_modes(plant)]
    if f is None:
        none = "Its margins and flights need an autopilot: [autopilot] in a study file."
        why = findings.reasons.get("flexible")
        blocks.append(Paragraph((f"There is no answer: {why}." if why else none,)))
        return Section(_NAME, _TITLE, tuple(blocks))
    blocks += [band_table(f.bands, findings.criteria.judge(f.bands)), *_detuned(f)]
    label = "Bode diagram of the loop of the flexible vehicle, each mode marked by its name"
    caption = "Magnitude and phase of the loop, with its margins; each mode is named at its peak."
    blocks.append(figure_of(bode_chart(f.autopilot, plant), "bode", label, caption))
    plane = findings.study.plane if findings.study.in_both else ""
    blocks += [_flown(f, plane), *_notes(f)]
    return Section(_NAME, _TITLE, tuple(blocks))


def given(structure: Structure) -> list[Table]:
    """Return the tables of the structure's inputs in SI units: modes, tanks, engine, sensors."""
    kinds: tuple[tuple[str, str, tuple[Any, ...], dict[str, str]], ...] = (
        ("Bending", "bending", structure.bending, _BENDING),
        ("Slosh", "slosh", structure.slosh, _SLOSH),
        ("Engine", "engine", () if structure.engine is None else (structure.engine,), _ENGINE),
    )
    tables = []
    for title, name, elements, units in kinds:
        rows: list[tuple[Line, ...]] = []
        for field, unit in units.items():
            values = [getattr(element, field) for element in elements]
            if any(value is not None for value in values):
                cells = (
                    ("-",)
                    if value is None
                    else significant(f"structure.{name}.{k}.{field}", value, 6)
                    for k, value in enumerate(values)
                )
                rows.append(((f"{field.replace('_', ' ')}{unit}",), *cells))
        head = ("quantity", *(f"{name} {k}" for k in range(1, len(elements) + 1)))
        tables += [Table(title, head, tuple(rows))] if elements else []
    lags = {"attitude": structure.attitude_sensor, "rate gyro": structure.rate_gyro}
    sensors = tuple(
        ((name,), *filter_cells(element, f"structure.{name.replace(' ', '_')}"))
        for name, element in lags.items()
        if element is not None
    )
    head = ("sensor", "zeros", "poles", "gain")
    return [*tables, *([Table("Sensors", head, sensors)] if sensors else [])]


def _words(plant: FlexiblePlant) -> Line:
    """Return the line that says which results are of the flexible vehicle, and its shifts [%]."""
    said = (
        "The margins and flights of the autopilot are those of the flexible vehicle, on the"
        f" {plant.model} model. Boundaries, minimum and sizes are those of the rigid vehicle"
    )
    moved = shift_of(plant)
    if moved is None:
        return (f"{said}.",)
    pole = number("flexible.shift.fast_pole", moved.fast_pole, 1, "%")
    price = number("flexible.shift.trim_price", moved.trim_price, 1, "%")
    ask = ", and the deflection that a wind needs by "
    return (f"{said}; the structure would move its fast pole by ", *pole, ask, *price, ".")


def _modes(plant: FlexiblePlant) -> list[Block]:
    names, poles = named_modes(plant)
    if not names:
        return []
    rows: list[tuple[Line, ...]] = []
    for k, (name, pole) in enumerate(zip(names, poles, strict=True)):
        size = abs(pole)
        key = f"flexible.mode.{k}"
        rows.append(
            (
                (name,),
                significant(f"{key}.rad_per_s", size, 3),
                significant(f"{key}.Hz", size / (2.0 * np.pi), 3),
                significant(f"{key}.damping", -pole.real / size if size else np.nan, 3),
            )
        )
    head = ("mode", "[rad/s]", "[Hz]", "damping")
    return [Table("Modes of the coupled vehicle, without an autopilot", head, tuple(rows))]


def _detuned(f: FlexibleAnswer) -> list[Block]:
    """Return the margins of the loop with each mode detuned, and the first one to fail."""
    d = f.detuned
    if d is None:
        return []
    return [d.table(), *(Paragraph(line) for line in d.stability_lines)]


def _flown(f: FlexibleAnswer, plane: str) -> Table:
    """Return the table of the flight with limits; `plane`: empty unless both planes share them."""
    caption = f"Flown in this wind with the nozzle's limits, {f.sample_rate:g} samples a second"
    caption += f", {plane} plane alone" if plane else ""
    bends, rigid = (abs(boundary.deflection) for boundary in f.boundaries)
    if f.flight is not None:
        return f.flight.table(caption, ("flexible", "rigid"), (bends, rigid))
    limits = (
        minimum_limit(degrees(f"flown.0.{k}", boundary))
        for k, boundary in enumerate((bends, rigid))
    )
    head = ("quantity", "flexible", "rigid")
    return Table(caption, head, ((("least limit that survives [deg]",), *limits),))


def _notes(f: FlexibleAnswer) -> list[Block]:
    names = ("the flexible vehicle", "the rigid vehicle")
    pairs = zip(names, f.boundaries, strict=True)
    return checks(
        f"{name}: {boundary.status}" for name, boundary in pairs if boundary.status != "ok"
    )
