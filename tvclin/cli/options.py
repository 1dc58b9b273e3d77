"""Options that several commands share, options made of declared fields, and options of a law."""

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property, wraps
from importlib import import_module
from inspect import Parameter, Signature, signature
from keyword import iskeyword
from operator import methodcaller
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self, cast

import typer

from tvclin.base.errors import InputError
from tvclin.base.fields import Field, help_line, parameters
from tvclin.base.files import name_output, target_of, write_text
from tvclin.base.lines import listed
from tvclin.base.units import optional_unit
from tvclin.boundary.limit_shapes import LIMIT_SHAPES
from tvclin.cli.inputs import flag_of, keys_set, only_with
from tvclin.cli.output import draw
from tvclin.control.autopilot.design_rules import (
    GIVEN_GAINS,
    POLE_PLACEMENT_RULES,
    RULE_KEYS,
    AutopilotDesign,
)
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.winds.shaped import SHAPES

if TYPE_CHECKING:
    from control import ControlPlot

    from tvclin.plots.curves import Curves


def to_write(option: typer.CallbackParam, file: Path | None) -> Path | None:
    """Return the file that a command writes; no other option of it may read the same file.

    `InputError` before the work where it cannot be written. `option`: its name is noted with the
    file, for the message about a file that is read and written.
    """
    if file is not None:
        target_of(file)
        name_output(max(option.opts, key=len), file)
    return file


def to_draw(option: typer.CallbackParam, file: Path | None) -> Path | None:
    """Return the file of a figure; `InputError` if it cannot be written or has no known format."""
    if to_write(option, file) is not None:
        from tvclin.plots.style import figure_format

        figure_format(cast(Path, file))
    return file


VEHICLE_HELP = "A vehicle of the package (see: tvclin vehicles) or a TOML file."
SOURCE_HELP = (
    f"{VEHICLE_HELP[:-1]}, which may hold a table of coefficients alone, or a flight schedule with"
    " --at, or a study file (see: tvclin init --study), over which options count."
)

Source = Annotated[str, typer.Argument(metavar="VEHICLE|STUDY", help=SOURCE_HELP)]
AT_HELP = (
    "Time of flight of the vehicle, in s, where the file is a flight schedule, or a vehicle with a"
    " table flight."
)
At = Annotated[float | None, typer.Option("--at", help=AT_HELP)]
LIMIT_SHAPES_HELP = f"{listed(LIMIT_SHAPES, 'or')}."
Until = Annotated[float, typer.Option(help="Length of the time shown, in durations of the wind.")]
Points = Annotated[int, typer.Option(help="Number of times in the CSV and the figure.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
More = Annotated[
    bool, typer.Option("--more", help="Print all tables and notes, not the answer alone.")
]
Csv = Annotated[
    Path | None,
    typer.Option(help="Also write what --plot draws into this CSV file.", callback=to_write),
]
Plot = Annotated[
    Path | None,
    typer.Option(help="Also draw a figure into this file (png, pdf, svg).", callback=to_draw),
]
System = Annotated[
    Path | None,
    typer.Option(
        "--system",
        help="Also write the system into this file (.mat of version 5, or .npz): its matrices, the"
        " names of its signals and its sample time.",
        metavar="FILE",
        callback=to_write,
    ),
]


def option(
    help: str,
    default: Any = None,
    *,
    shown: str = "",
    flag: str = "",
    metavar: str | None = None,
    callback: Callable[..., Any] | None = None,
) -> Any:
    """Return the option of a command for a parameter, with its help.

    `shown`: text for the default in the help. `flag`: name of the option where it is not that of
    the parameter. `metavar`: name of its value in the help. `callback`: check of the value.
    """
    named = [flag] if flag else []
    return typer.Option(
        default, *named, help=help, show_default=shown or True, metavar=metavar, callback=callback
    )


def switch(flag: str, help: str) -> Any:
    """Return the option `flag` of a parameter that is false unless it is given."""
    return typer.Option(False, flag, help=help)


@dataclass(frozen=True)
class Options:
    """Options of declared fields of a case or a question; `grouped` gives them to a command.

    `kind`: the module of the dataclass, and its name: "case.nozzle.Nozzle". `names`: its fields;
    without, all that have an option. `at`: which part of a plan it is; the plan itself where it is
    empty. `shown`: text for the default of an option, where it is not the declared default.
    `values`: what was given, by field, in SI units.
    """

    kind: str
    names: tuple[str, ...] = ()
    at: str = ""
    shown: Mapping[str, str] = field(default_factory=dict)
    values: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def fields(self) -> dict[str, Field]:
        """The fields by the names of parameters; without those that have no option."""
        all_fields = parameters(self._kind)
        chosen = [all_fields[name] for name in self.names]
        return {
            _parameter(item): item
            for item in chosen or all_fields.values()
            if item.option is not None
        }

    @property
    def _kind(self) -> Any:
        """The dataclass that `kind` names."""
        module, _, name = self.kind.rpartition(".")
        return getattr(import_module(f"tvclin.{module}"), name)

    def parameters(self) -> list[Parameter]:
        """Return the parameters of a command."""
        panel = _PANELS.get(self.kind)
        return [_option(name, item, self.shown, panel) for name, item in self.fields.items()]

    def taken(self, options: dict[str, Any]) -> Self:
        """Return the options of the group with values [SI], and remove them from the command's.

        `options`: values of a command by parameter, in the units of the options; None, or an empty
        list, is not given.
        """
        chosen = {name: options.pop(name) for name in self.fields}
        values = {
            item.name: item.from_option(flag_of(name), chosen[name])
            for name, item in self.fields.items()
            if chosen[name] is not None and chosen[name] != []
        }
        return replace(self, values=values)

    def applied_to(self, plan: Any) -> Any:
        """Return a plan with the values of these options in place of its own.

        They are fields of the plan, or of the part of it that `at` names, which is made where the
        plan has none.
        """
        if not self.values:
            return plan
        if not self.at:
            return replace(plan, **self.values)
        record = getattr(plan, self.at)
        changed = self._kind(**self.values) if record is None else replace(record, **self.values)
        return replace(plan, **{self.at: changed})

    def only_with(self, needed: str, *names: str) -> None:
        """Raise `InputError` if options are given without what they require, `needed` in words.

        `names`: fields whose options count, all by default.
        """
        values = {
            name: self.values.get(item.name)
            for name, item in self.fields.items()
            if not names or item.name in names
        }
        only_with(needed, **values)


def _parameter(item: Field) -> str:
    """Return the parameter's name of a field, from its option or from its name and unit."""
    if item.option and "/" not in item.option:  # not a pair of flags, "--yes/--no"
        name = item.option.strip("-").replace("-", "_")
        return f"{name}_" if iskeyword(name) else name
    if not item.numeric:
        return item.name
    suffix, _, _ = optional_unit(item.kind)  # of the unit, such as "_deg"
    return item.name + suffix


def _option(name: str, item: Field, shown: Mapping[str, str], panel: str | None) -> Parameter:
    """Return the parameter of a command for a field `item`, with help, default and panel.

    `name`: name of the parameter. `shown`: texts for defaults, by field. The parameter has no
    default, so that an option that is not given leaves the value of a file; the help shows that of
    the field in the unit of the option.
    """
    kinds = {"text": str, "flag": bool, "count": int}
    kind: Any = kinds.get(item.kind, float)
    default = shown.get(item.name, item.shown)
    if not default and item.default is not None:
        _, _, factor = optional_unit(item.kind) if item.numeric else ("", "", None)  # to SI
        defaults = item.default if item.many else (item.default,)
        default = " and ".join(
            f"{value / factor:g}" if factor else str(value) for value in defaults
        )
    declared = typer.Option(
        *([item.option] if item.option else []),
        help=help_line(item),
        show_default=default or False,
        rich_help_panel=panel,
    )
    return Parameter(
        name,
        Parameter.POSITIONAL_OR_KEYWORD,
        default=None,
        annotation=Annotated[(list[kind] if item.many else kind) | None, declared],
    )


GROUP: Any = object()
"""The default of a parameter that is a dataclass of options."""
SHAPE = option(f"Shape of the wind: {listed(SHAPES, 'or')}.", shown="triangular")
STUDY = "studyfile.study_plan.StudyPlan"
DESIGN = "control.autopilot.design_rules.AutopilotDesign"
NOZZLE = "case.nozzle.Nozzle"
SIZING = "requirement.flight.request.SizingRequest"
CAMPAIGN = "ensembles.campaign.campaign_plan.Campaign"
_PANELS = {NOZZLE: "Nozzle", DESIGN: "Autopilot", CAMPAIGN: "Answer"}
"""Panels of the help, by the record whose options they group."""
MODEL_AND_PLANE = Options(STUDY, ("model", "plane"))
MODEL, PLANE = (Options(STUDY, (name,)) for name in ("model", "plane"))
LIMIT = Options(NOZZLE, ("limit",), "nozzle")
BOTH_LIMITS = Options(NOZZLE, ("limit", "rate_limit"), "nozzle")
TIMING = Options(DESIGN, ("sample_rate", "delay"), "design")


@dataclass(frozen=True)
class Shown:
    """Options of the output of an answer; `grouped` gives them to a command."""

    as_json: AsJson = False
    plot: Plot = None


@dataclass(frozen=True)
class _Csv:
    csv: Csv = None


@dataclass(frozen=True)
class ShownCurves(Shown, _Csv):
    """Options for showing an answer with curves: their CSV file, then the options of `Shown`."""

    def write(
        self, curves: "Callable[[], Curves]", chart: "Callable[[Curves], ControlPlot]"
    ) -> None:
        """Write the CSV file and the figure that the options name.

        `curves`: function that computes the curves, called once where either is asked for. `chart`:
        function that draws them.
        """
        if self.csv is None and self.plot is None:
            return
        numbers = curves()
        if self.csv is not None:
            write_text(self.csv, numbers.csv())
        draw(self.plot, lambda: chart(numbers))


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command in which the options of a group replace the parameter that is the group.

    A group is an `Options`, as the default of its parameter, or a dataclass of options and of such
    groups, whose parameter has the default `GROUP`. typer reads the signature and the annotations
    of the returned function.
    """
    # options as parameters of a signature; function from their values by name to the call
    shown, call = _expanded(command)

    @wraps(command)
    def run(**values: Any) -> None:
        """Run the command with the values of its options, which `_expanded` puts together."""
        call(values)

    run.__signature__ = Signature(shown)  # type: ignore[attr-defined]
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in shown}
    return run


def _expanded(
    made: Callable[..., Any],
) -> tuple[list[Parameter], Callable[[dict[str, Any]], Any]]:
    """Return the options of a command or group `made`, and the function that calls it with them.

    That function takes the values of all options by name, removes those of `made`, and returns what
    `made` returns: a group is a dataclass, which is made. A group in a group is expanded as well; a
    parameter that is no group is an option itself.
    """
    shown: list[Parameter] = []
    takers: dict[str, Callable[[dict[str, Any]], Any]] = {}
    for name, parameter in signature(made).parameters.items():
        group, kind = parameter.default, parameter.annotation
        if isinstance(group, Options):
            shown += group.parameters()
            takers[name] = group.taken
        elif group is GROUP:
            options, takers[name] = _expanded(kind)
            shown += [_in_panel(option, getattr(kind, "panel", None)) for option in options]
        else:
            shown.append(parameter)
            takers[name] = methodcaller("pop", name)  # the value itself

    def call(values: dict[str, Any]) -> Any:
        """Call the command or make the group with its options, which are removed from `values`."""
        return made(**{name: taker(values) for name, taker in takers.items()})

    return shown, call


def _in_panel(option: Parameter, panel: str | None) -> Parameter:
    """Return an option in a panel of the help; unchanged without a panel.

    An option that is declared in its annotation has a plain value as its default, in which no panel
    can be set: it is unchanged too.
    """
    if panel is None or not hasattr(option.default, "rich_help_panel"):
        return option
    default = copy(option.default)
    default.rich_help_panel = panel
    return option.replace(default=default)


@dataclass(frozen=True)
class GainOptions(Options):
    """Options of the gains, or of a rule for them."""

    def applied_to(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan with these gains, or with this rule for them."""
        values = self.values
        return replace(plan, design=with_gains(plan.autopilot_design, **values)) if values else plan


GAINS = GainOptions(
    DESIGN, ("design", "natural_frequency", "damping", "attitude_gain", "rate_gain")
)


@dataclass(frozen=True)
class FlownLaw:
    """Options of a flown law: its samples and delay, and the gains of the law autopilot."""

    timing: Options = TIMING
    gains: Options = GAINS

    def applied_to(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan with the values of all these options."""
        return self.gains.applied_to(self.timing.applied_to(plan))

    def only_with_autopilot(self, source: str) -> None:
        """Raise `InputError` for gains of a law without gains.

        They are options, or keys of --set, which `source`, file or name of the vehicle, holds.
        """
        from tvclin.control.laws.registry import AUTOPILOT  # late: of all laws

        needed = f"--law {AUTOPILOT}"
        self.gains.only_with(needed)
        for key in self._gain_keys(source):
            raise InputError(f"--set {key} needs {needed}")

    def has_gains(self, source: str) -> bool:
        """Return whether options give gains, or keys of --set, which the vehicle `source` holds."""
        return bool(self.gains.values or self._gain_keys(source))

    def _gain_keys(self, source: str) -> list[str]:
        """Return the keys of --set that give gains, or a rule for them; empty without --set.

        `source`: file or name of the vehicle; an `EditedSource`, also a text, holds these keys.
        """
        if not (keys := keys_set(source)):
            return []
        from tvclin.studyfile.settings import quantity_name  # late: it knows the keys of all files

        gains = {f"autopilot.{name}" for name in (*GIVEN_GAINS, *RULE_KEYS, "integral_gain")}
        return [key for key in keys if quantity_name(key) in gains]


def with_gains(base: AutopilotDesign, **values: float | str | None) -> AutopilotDesign:
    """Return a design with the gains or the rule of options.

    Gains remove a rule and a rule removes gains; a named rule also removes parameters of another.
    Both replace a schedule's gains, not its filters. `values`: fields; their names alone decide.
    """
    removed: tuple[str, ...] = ()
    if values.keys() & {*GIVEN_GAINS, *RULE_KEYS} and base.schedule is not None:
        base = replace(base, schedule=replace(base.schedule, gains={}))
    if values.keys() & set(GIVEN_GAINS):
        removed = RULE_KEYS
    elif values.keys() & set(RULE_KEYS):
        # another rule: by its name, or by a parameter alone, which is of pole placement
        rule_changes = "design" in values or base.design not in (None, *POLE_PLACEMENT_RULES)
        removed = (*GIVEN_GAINS, *(RULE_KEYS if rule_changes else ()))
    changed: Any = dict.fromkeys(removed) | values
    return replace(base, **changed)
