"""The section of the vehicle: drawn to scale, its numbers, and what follows from them."""

from tvclin.answers import study_tables as tables
from tvclin.answers.findings import Findings
from tvclin.plots.vehicle_to_scale import vehicle_chart
from tvclin.show.report.blocks import Block, Figure, Section
from tvclin.show.report.figures import inline_svg
from tvclin.vehicle.vehicle import Vehicle

_CAPTION = (
    "The vehicle along its axis, with lengths to scale. Its radius, nose and nozzle are sketched:"
    " they are not among its numbers."
)


def vehicle(found: Findings) -> Section:
    """Return the vehicle; of one that is known by its coefficients alone there is no drawing."""
    own, blocks = found.study.vehicle, list[Block]()
    if isinstance(own, Vehicle):
        label = "The vehicle along its axis: control force, centres of gravity and of pressure"
        svg = inline_svg(vehicle_chart(own, found.study.limit), "vehicle", label)
        blocks.append(Figure(label, f"{_CAPTION} {_source(own)}", svg))
    each = (tables.vehicle(found.study), tables.coefficients(found.study))
    return Section("vehicle", "The vehicle", (*blocks, *each))


def _source(own: Vehicle) -> str:
    if own.numbers_from:
        return f"The numbers come from: {own.numbers_from}."
    return "The vehicle file does not say where its numbers come from (numbers_from in [vehicle])."
