"""The options that several commands share, with their meaning said once."""

from collections.abc import Callable
from dataclasses import dataclass, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.cli.inputs import changed
from tvclin.cli.output import draw

if TYPE_CHECKING:
    from control import ControlPlot

    from tvclin.answers.study_file.plan import StudyPlan
    from tvclin.plots.curves import Curves

MODELS_HELP = "fixed-path, drift, drift-exact or drift-and-speed."
MODEL_DEFAULT = "drift-exact; fixed-path where no more than mu_alpha and mu_delta is known"
VEHICLE_HELP = "A vehicle of the package (see: tvclin vehicles) or a TOML file."
SOURCE_HELP = (
    f"{VEHICLE_HELP[:-1]}, which may hold a table of coefficients alone, or a study file (see:"
    " tvclin init --study), over which options count."
)

Source = Annotated[str, typer.Argument(metavar="VEHICLE|STUDY", help=SOURCE_HELP)]
PeakDeg = Annotated[
    float | None, typer.Option(help="Peak wind angle of attack, in deg.", show_default="5")
]
PeakSpeed = Annotated[
    float | None, typer.Option(help="Peak wind speed, in m/s, in place of --peak-deg, by eq (B1e).")
]
LimitDeg = Annotated[float | None, typer.Option(help="Deflection limit, in deg: is it sufficient?")]
Plane = Annotated[
    str | None, typer.Option(help="Plane of the motion: pitch or yaw.", show_default="pitch")
]
Planes = Annotated[
    str | None,
    typer.Option(
        help="Plane of the motion: pitch, yaw, or both with one stop.", show_default="pitch"
    ),
]
Sign = Annotated[
    str | None,
    typer.Option(
        help="Which sign of a wind along the path counts, with the dynamic pressure met in it:"
        " head, tail, or frozen, that of calm air.",
        show_default="the worst of these",
    ),
]
STOPS_HELP = "round, round-each-plane, square or square-45."
WindDirectionDeg = Annotated[
    float | None,
    typer.Option(
        help="Where the wind blows from, in deg from north, clockwise; --peak-deg is then the size"
        " of the wind's vector in both planes. Needs --azimuth-deg."
    ),
]
AzimuthDeg = Annotated[
    float | None, typer.Option(help="Direction of flight, in deg from north, clockwise.")
]
Model = Annotated[
    str | None, typer.Option(help=f"Model: {MODELS_HELP}", show_default=MODEL_DEFAULT)
]
TIME_HELP = "as in '2024-02-15 12' (UTC). Without it: the first."
Until = Annotated[float, typer.Option(help="Length of the time shown, in durations of the wind.")]
Points = Annotated[int, typer.Option(help="Number of times in the CSV and the figure.")]
Shape = Annotated[
    str | None,
    typer.Option(help="Shape of the wind: triangular or rectangular.", show_default="triangular"),
]
RateLimitDeg = Annotated[
    float | None,
    typer.Option(
        help="Limit of the deflection rate, in deg/s. The laws trim and recoverable-attitude suit"
        " it: one by its gain, the other by how far it turns the nozzle."
    ),
]
SampleRate = Annotated[
    float | None,
    typer.Option(
        help="Sample rate of the autopilot or law, in Hz. Without it margins are of a continuous"
        " one, and flights sample it at 100."
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
Csv = Annotated[Path | None, typer.Option(help="Also write what --plot draws into this CSV file.")]
Plot = Annotated[
    Path | None, typer.Option(help="Also draw a figure into this file (png, pdf, svg).")
]
Rigid = Annotated[
    bool, typer.Option("--rigid", help="Leave out what the vehicle file says of its structure.")
]
Gust = Annotated[
    tuple[float, float] | None,
    typer.Option(
        metavar="DEG S", help="Gust (1 - cosine) on top of the wind: its peak and duration."
    ),
]
GustSpeed = Annotated[
    tuple[float, float] | None,
    typer.Option(metavar="M/S S", help="The same by its peak wind speed, in m/s, by eq (B1e)."),
]
GustPlateau = Annotated[
    float | None,
    typer.Option(
        help="Part of its duration that a gust stays at its peak, in s.", show_default="0"
    ),
]
GustAt = Annotated[
    float | None,
    typer.Option(help="When the gust peaks, in s.", show_default="when it asks for most"),
]


@dataclass(frozen=True)
class MotionOptions:
    """Model and plane; `grouped` gives them to a command."""

    model: Model = None
    plane: Plane = None

    def over(self, plan: "StudyPlan") -> "StudyPlan":
        """Return a plan with this model, in this plane."""
        return changed(plan, model=self.model, plane=self.plane)


@dataclass(frozen=True)
class Shown:
    """How an answer is shown; `grouped` gives the options to a command."""

    as_json: AsJson = False
    plot: Plot = None


@dataclass(frozen=True)
class _Csv:
    csv: Csv = None


@dataclass(frozen=True)
class ShownCurves(Shown, _Csv):
    """The same of an answer with curves, first their CSV file."""

    def write(
        self, curves: "Callable[[], Curves]", chart: "Callable[[Curves], ControlPlot]"
    ) -> None:
        """Write the CSV file and the figure that are asked for."""
        if self.csv is None and self.plot is None:
            return
        from tvclin.base.files import write_text

        numbers = curves()
        if self.csv is not None:
            write_text(self.csv, numbers.csv())
        draw(self.plot, lambda: chart(numbers))


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the fields of each parameter that is a group of options, in its place.

    A group is a dataclass of options, and the default of its parameter one without any.
    """
    shown: list[Parameter] = []
    groups: dict[str, tuple[Any, list[Parameter]]] = {}
    for name, parameter in signature(command).parameters.items():
        options = [parameter]
        if is_dataclass(parameter.default):
            kind = type(parameter.default)
            options = list(signature(kind).parameters.values())
            groups[name] = (kind, options)
        shown += options

    @wraps(command)
    def run(**given: Any) -> None:
        for name, (kind, options) in groups.items():
            given[name] = kind(**{one.name: given.pop(one.name) for one in options})
        command(**given)

    run.__signature__ = Signature(shown)  # type: ignore[attr-defined]
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in shown}
    return run
