"""`tvclin poles`: the poles, and the residues of the inputs at the unstable ones."""

from typing import Any

import numpy as np

from tvclin.base.errors import one_of
from tvclin.cli.inputs import case_of
from tvclin.cli.options import PLANE, AsJson, At, Options, Plot, Source, System, option
from tvclin.cli.output import answer, draw, print_answer
from tvclin.linear.flexible import AnyPlant, mode_tables, named_modes, plant_of
from tvclin.linear.modes import Modes, all_modes, mode_table, select_unstable
from tvclin.linear.plant import MODELS, Plant, models_of
from tvclin.linear.system_file import write_system

_CLOSED_LOOP = (
    "these are poles without an autopilot; tvclin margins --more prints those of the closed loop"
)


def poles(
    vehicle: Source = "configuration-i",
    time: At = None,
    model: str = option("fixed-path, drift, drift-exact, drift-and-speed, or all.", "all"),
    within: Options = PLANE,
    system: System = None,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Print the poles of a vehicle without an autopilot, with the residues of the rigid models.

    A vehicle file with bending, slosh or engine inertia has a second table: the poles of the
    coupled vehicle, with frequency and damping of each mode. --system writes the plant of one
    model, --model or the case's, with all of these; --set study.rigid true leaves them out.
    tvclin margins --more prints the poles of the loop closed by an autopilot.
    """
    from tvclin import plots

    one_of("model", model, [*MODELS, "all"])
    case = case_of(vehicle, within.applied_to, questions=("poles",), time=time)
    loaded, plane = case.vehicle, case.plane
    names = models_of(loaded) if model == "all" else [model]
    plants = {name: Plant.from_vehicle(loaded, name, plane) for name in names}
    modes = {name: all_modes(plant) for name, plant in plants.items()}
    draw(plot, lambda: plots.pole_map(plants[names[0]].coefficients, names))
    models = {name: _document(mode_set) for name, mode_set in modes.items()}
    first = case.model if case.model in modes else names[0]
    if system is not None:
        plant = case.plant if model == "all" else plant_of(loaded, model, plane)
        write_system(plant.ss(), system)
    title = f"{loaded.name or vehicle}, {plane}: poles of the attitude"
    answer(
        as_json,
        lambda: {
            "vehicle": loaded.name,
            "plane": plane,
            "models": models,
            "modes": _named(case.plant),
        },
        lambda: print_answer(
            _fastest(first, modes[first]),
            mode_table(title, modes),
            *mode_tables(case.plant),
            notes=[_CLOSED_LOOP],
        ),
    )


def _fastest(model: str, modes: Modes) -> str:
    """Return the fastest unstable pole [1/s] of a model in words, with the doubling time.

    That is ln(2) over its real part.
    """
    poles = select_unstable(modes.poles)
    if not poles.size:
        return f"no unstable pole, model {model}"
    rate = float(np.real(poles).max())
    doubled = f"the attitude error doubles in {np.log(2.0) / rate:.3g} s"
    return f"fastest unstable pole {rate:.4g} 1/s, model {model}: {doubled}"


def _named(plant: AnyPlant) -> list[dict[str, Any]]:
    """Return the named modes of a flexible plant for JSON; none of a rigid one."""
    return [
        {
            "name": name,
            "pole_per_s": pole,
            "frequency_rad_per_s": abs(pole),
            "damping": -pole.real / abs(pole),
        }
        for name, pole in zip(*named_modes(plant), strict=True)
    ]


def _document(modes: Modes) -> list[dict[str, Any]]:
    """Return the poles [1/s] of a plant with their residues, for JSON."""
    columns = (modes.poles, modes.deflection_residues, modes.wind_residues)
    return [
        {"pole_per_s": p, "deflection_residue_per_s": d, "wind_residue_per_s": w}
        for p, d, w in zip(*(column.tolist() for column in columns), strict=True)
    ]
