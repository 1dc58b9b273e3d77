"""The option --set of commands that take a case, and messages that name options.

--set gives a key of the study file by name. An error names the argument of a function; its message
names the option, or the key, that gives the argument.
"""

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Annotated, Any

import typer
from typer.models import ArgumentInfo

from tvclin.base.errors import InputError, shown

_SOURCES = ("vehicle", "source")
"""Arguments of commands that take a case."""
_WITHOUT_SETTINGS = ("explore",)
"""Commands that write their source into a notebook."""
_PARAMETER = "settings"
_LAST = ("as_json", "csv", "plot")
"""Options of the output, which stand last in the help."""
_WIND_KEYS: dict[str, tuple[str, ...]] = {
    "--wind": ("wind.shape",),
    "--duration": ("wind.duration",),
    "--peak-deg": ("wind.peak", "wind.peak_speed"),
    "--peak-speed": ("wind.peak", "wind.peak_speed"),
    "--azimuth-deg": ("wind.azimuth",),
    "--winds": ("wind.sounding",),
    "--gust": ("gust",),
}
_OTHER_KEYS: dict[str, tuple[str, ...]] = {
    "--limit-shape": ("nozzle.limit_shape",),
    "--at": ("study.time",),
    "--criteria": ("criteria",),
}
"""Options that are no declared fields, and their keys without units, or their table."""
_HEADINGS = {
    "studyfile.study_plan.StudyPlan": "study",
    "case.nozzle.Nozzle": "nozzle",
    "case.load.LoadBound": "load",
    "control.autopilot.design_rules.AutopilotDesign": "autopilot",
    "requirement.flight.request.SizingRequest": "size",
    "ensembles.campaign.campaign_plan.Campaign": "campaign",
}
"""Tables of the records whose fields are options."""
_CAMPAIGN = ("cases", "seed", "method")
_QUESTION = ("probability", "confidence")
"""Fields of a study that stand in [campaign], and in [question]."""


def _completed(incomplete: str) -> Iterator[tuple[str, str]]:
    """Yield the keys that begin with an incomplete text, each with its line of help."""
    from tvclin.studyfile.keys import all_keys

    yield from ((key.name, key.help) for key in all_keys() if key.name.startswith(incomplete))


_Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY VALUE",
        autocompletion=_completed,
        help="Set a key of the study file, such as autopilot.rate_gain_s 0.8; none removes it. May"
        " be given several times (keys: tvclin init --keys).",
    ),
]


def settable(command: Callable[..., None], name: str = "") -> Callable[..., None]:
    """Return a command with the option --set, which edits keys of its study or vehicle file.

    `name`: name of the command. A command that reads no such file is returned unchanged. The option
    stands before the options of the output; typer reads it from the signature. The command's option
    azimuth_deg, if it has one, is set in the source too, for winds that have a direction.
    """
    parameters = signature(command).parameters
    arguments = [
        name
        for name, item in parameters.items()
        if any(isinstance(k, ArgumentInfo) for k in getattr(item.annotation, "__metadata__", ()))
    ]
    source = next((name for name in arguments if name in _SOURCES), None)
    if name in _WITHOUT_SETTINGS or source is None:
        return command

    @wraps(command)
    def run(**values: Any) -> None:
        """Run the command; its source has the keys of --set, and the azimuth of an option.

        `values`: arguments of the command by name, of which `source` is the name of its source.
        """
        settings = pairs(values.pop(_PARAMETER) or ())
        # the azimuths of `availability` are another option
        values[source] = _edited(values[source], settings, values.get("azimuth_deg"))
        command(**values)

    option = Parameter(
        _PARAMETER, Parameter.POSITIONAL_OR_KEYWORD, default=None, annotation=_Settings
    )
    last = [item for name, item in parameters.items() if name in _LAST]
    shown = [*(item for item in parameters.values() if item not in last), option, *last]
    run.__signature__ = Signature(shown)  # type: ignore[attr-defined]
    run.__annotations__ = {item.name: item.annotation for item in shown}
    return run


def joined(arguments: Sequence[str]) -> list[str]:
    """Return the arguments of a command line with key and value of --set as KEY=VALUE.

    typer has no list of pairs. An option at the end, as in a completion, is unchanged.
    """
    words, together = list(arguments), []
    while words:
        word = words.pop(0)
        together.append(word)
        if word == "--set" and len(words) > 1 and "=" not in words[0]:
            together.append(f"{words.pop(0)}={words.pop(0)}")
    return together


def pairs(settings: Iterable[str]) -> list[tuple[str, str]]:
    """Return the keys and values, as texts, of settings of --set such as wind.peak_deg=6."""
    parts = [setting.partition("=") for setting in settings]
    for key, equals, _ in parts:
        if not equals:
            raise InputError(f"--set takes a key and a value, wind.peak_deg 6; got {shown(key)}")
    return [(key, value) for key, _, value in parts]


def check_settings(options: Iterable[Any], values: Mapping[str, Any]) -> None:
    """Raise `InputError` for a key that is set beside its own option.

    `options`: the parameters of a command. `values`: their values, by name. The key is the option's
    in a study file, or any key of the table that the option stands for; --winds of a command
    without flight times (--every) stands for all of [wind].
    """
    settings = values.get(_PARAMETER)
    if not settings:
        return
    from tvclin.studyfile.settings import quantity_name

    keys = _WIND_KEYS | _OTHER_KEYS | _field_keys()
    if all(option.opts[0] != "--every" for option in options):  # a flight has pulses too
        keys["--winds"] = ("wind",)
    flags = [option.opts[0] for option in options if is_set(option, values)]
    for key, _ in pairs(settings):
        for flag in flags:
            if {quantity_name(key), key.partition(".")[0]} & set(keys.get(flag, ())):
                raise InputError(f"give {flag} or --set {key}, not both")


def _edited(
    source: str | None, settings: Sequence[tuple[str, str]], azimuth: float | None
) -> str | None:
    """Return the source with keys set: `settings` of --set, and the azimuth of winds that need one.

    Such winds are soundings and winds with a direction. `azimuth`: direction of flight [deg].
    `InputError` for settings without a source.
    """
    if not settings and azimuth is None:
        return source
    from tvclin.cli.inputs import only_with
    from tvclin.studyfile.settings import with_settings
    from tvclin.vehicle.vehicle_file import source_tables
    from tvclin.winds.wind_file import directed_winds

    if source is None:
        only_with("a vehicle or a study file", set=settings or None)
        return None
    edited, keys = with_settings(str(source), settings) if settings else source, []
    if azimuth is not None:
        directed = directed_winds(source_tables(edited))
        keys = [(f"wind.{k + 1}.azimuth_deg", f"{azimuth!r}") for k in directed]
    return with_settings(str(source), [*settings, *keys]) if keys else edited


def faulty_key(error: ValueError, values: Mapping[str, Any]) -> ValueError:
    """Return the error of a command, which blames keys of --set and not the file that they change.

    `values`: values of arguments and options of the command, by name. A line of the message that
    begins with the file and has the name of a quantity that --set changes begins with its key:
    "my.toml: weight ..." becomes "--set vehicle.weight: weight ...". So does a line on a key that
    is missing in the table of that quantity.
    """
    from tvclin.base.files import called

    source, message = next((values[name] for name in _SOURCES if values.get(name)), ""), str(error)
    if not isinstance(error, InputError) or not source:
        return error
    for key, _ in pairs(values.get(_PARAMETER) or ()):
        # the name of the quantity later in the line, not as a part of another name
        heading = re.escape(f"[{key.partition('.')[0]}]")
        about = rf"(?=.*(?<![\w.\-]){_quantity(key)}(?![a-z])|a key is missing in \[?{heading})"
        message = re.sub(rf"(?m)^{re.escape(called(source))}: {about}", f"--set {key}: ", message)
    return InputError(message)


def keys_of_arguments(options: Iterable[Any], values: Mapping[str, Any]) -> dict[str, str]:
    """Return the keys of a study file that may give each argument, as messages name them.

    The argument "damping" has the key "--set autopilot.damping" if --set changes [autopilot], else
    "autopilot.damping" if the file has [autopilot] and no option of it is given. Of several such
    keys the first that is set counts, or else the first. `options`: parameters of a command.
    `values`: their values, by parameter.
    """
    from tvclin.studyfile.keys import all_keys

    set_keys = [key for key, _ in pairs(values.get(_PARAMETER) or ())]
    flags = [option.opts[0] for option in options if is_set(option, values)]
    option_keys = _WIND_KEYS | _OTHER_KEYS | _field_keys()
    of_options = {key.partition(".")[0] for flag in flags for key in option_keys.get(flag, ())}
    file_tables = {k: v for k, v in _tables_of_file(values).items() if k not in of_options}
    file_keys = [f"{home}.{key}" for home, table in file_tables.items() for key in table]

    def completed(keys: Iterable[str], homes: Collection[str]) -> dict[str, str]:
        """Return the keys by name without table and unit: `keys`, or others of tables `homes`."""
        others = [key.name for key in all_keys() if key.name.rpartition(".")[0] in homes]
        # of equal names the last replaces the others, so reversed
        return {_quantity(key): key for key in reversed([*keys, *others])}

    of_set = completed(set_keys, {key.partition(".")[0] for key in set_keys})
    return completed(file_keys, file_tables) | {k: f"--set {key}" for k, key in of_set.items()}


def _tables_of_file(values: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the tables of a study file by heading but repeated ones; empty for another source.

    `values`: values of arguments and options of a command, of which one may be its source.
    """
    from tvclin.vehicle.vehicle_file import source_tables

    source = next((values[name] for name in _SOURCES if values.get(name)), None)
    if source is None:
        return {}
    with suppress(InputError):  # the file itself may be at fault
        tables = source_tables(source)
        if "study" in tables:
            return {home: table for home, table in tables.items() if isinstance(table, dict)}
    return {}


def _quantity(key: str) -> str:
    """Return the name of a key without its table, its row and its unit."""
    from tvclin.studyfile.settings import quantity_name

    return quantity_name(key).rpartition(".")[2]


def similar_key(option: str) -> str | None:
    """Return the first key of a study file with the name of an unknown option; None if none.

    A table of that name has its first key, and a key may have its table before it: --gust-peak.
    """
    from tvclin.studyfile.keys import all_keys

    name = without_unit(option.strip("-").replace("-", "_"))
    keys = [key.name for key in all_keys()]
    quantities = [key.rpartition(".")[2] for key in keys]
    for names in (quantities, [key.replace(".", "_") for key in keys]):
        # equal but for a unit, or the begin of a name up to an underscore
        for key, full_name in zip(keys, names, strict=True):
            if f"{full_name}_".startswith(f"{name}_"):
                return key
    return None


def field_key(option: str) -> str | None:
    """Return the key that gives the same as an option, with its unit; None without such a key.

    The unit is that of the option where the key may have it: of --delay-ms ``autopilot.delay_ms``.
    """
    from tvclin.studyfile.keys import all_keys
    from tvclin.studyfile.settings import quantity_name

    # without unit; behind it are the keys that the option excludes
    own_key, *_ = (_OTHER_KEYS | _field_keys()).get(option, ("",))
    in_its_unit = f"{own_key.partition('.')[0]}.{option.strip('-').replace('-', '_')}"
    if quantity_name(in_its_unit) == own_key != in_its_unit:
        return in_its_unit
    return next((k.name for k in all_keys() if quantity_name(k.name) == own_key), None)


def required_with(key: str, option: str) -> list[str]:
    """Return a `key`, and the keys that its table requires if the `option` is named like the table.

    With --gust and a key of [gust] they are the key, ``gust.peak_deg`` and ``gust.duration_s``.
    """
    from tvclin.studyfile.keys import all_keys
    from tvclin.studyfile.settings import quantity_name, required_names

    heading = key.partition(".")[0]
    if option.strip("-") != heading:
        return [key]
    required = [f"{heading}.{name}" for name in required_names(heading)]
    # `required` has names without units, such as gust.peak
    others = (k.name for k in all_keys() if quantity_name(k.name) in required)
    return list(dict.fromkeys((key, *others)))


def option_of_key(key: str, flags: Iterable[str]) -> str | None:
    """Return the first of options that gives the same as a `key` of a file; None without one.

    `flags`: options of a command, such as "--at", which gives ``study.time_s``.
    """
    from tvclin.studyfile.settings import quantity_name

    name, keys = quantity_name(key), _WIND_KEYS | _OTHER_KEYS | _field_keys()
    # the first key of an option is what it gives; the others are only excluded beside it
    return next((flag for flag in flags if name in keys.get(flag, ())[:1]), None)


def _field_keys() -> dict[str, tuple[str, ...]]:
    """Return the keys, without units, that --set may not set beside an option, by option.

    The first is the key of the option's own field, as "nozzle.limit" of --limit-deg. Beside a gain
    none of the keys of the rules for gains may be set, and the reverse.
    """
    from tvclin.cli.inputs import flag_of
    from tvclin.cli.options import Options
    from tvclin.control.autopilot.design_rules import GIVEN_GAINS, RULE_KEYS

    keys: dict[str, tuple[str, ...]] = {}
    for kind, heading in _HEADINGS.items():
        for parameter, item in Options(kind).fields.items():
            flag = item.option or flag_of(parameter)
            # the table with the key, which for some fields is not the record's own
            home = "campaign" if item.name in _CAMPAIGN else heading
            home = "question" if item.name in _QUESTION else home
            keys[flag] = (*keys.get(flag, ()), f"{home}.{item.file_key}")
            for group, others in ((GIVEN_GAINS, RULE_KEYS), (RULE_KEYS, GIVEN_GAINS)):
                if heading == "autopilot" and item.name in group:  # a rule replaces gains
                    keys[flag] += tuple(f"autopilot.{field_name}" for field_name in others)
    keys["--design"] += tuple(f"autopilot.{name}" for name in RULE_KEYS)
    return keys


_UNIT = re.compile(r"_(deg|rad|m|m2|s|ms|hz|per_rad|percent)$")
"""Unit at the end of a parameter's name."""
_ARGUMENTS: dict[str, tuple[str, ...]] = {
    "--gust": ("peak", "duration"),
    "--gust-speed": ("speed", "duration"),
    "--peak-speed": ("speed",),
    "--wind": ("shape",),
    "--limit-deg": ("deflection_limit",),
    "--cn-alpha-per-rad": ("normal_force_coefficient_slope",),
    "--cn-alpha": ("normal_force_coefficient_slope",),
    "--inertia": ("moment_of_inertia",),
    "--from": ("start",),
    "--to": ("stop",),
}
"""Arguments of other names than their options."""
_PAIR = re.compile(r"\b(with|between) (\w+) and (\w+)\b")
"""Two arguments in a sentence: leave these rows out with start and stop."""
_IN_A_FILE = re.compile(r"(\S+\.toml|\[|--set )")
"""Beginning of a line about a key of a file, or of --set."""


def without_unit(name: str) -> str:
    """Return the name of a parameter without its unit."""
    return _UNIT.sub("", name)


def named(
    error: ValueError,
    options: Iterable[Any],
    values: Mapping[str, Any],
    keys: Mapping[str, str],
) -> ValueError:
    """Return the error of a command with options in its message in place of arguments.

    Errors other than `InputError` stay. `options`: typer's parameters of the command. `values`:
    their values, by parameter. `keys`: keys of the study file by the argument that they give, as
    the message names them, for arguments of which no option is on the command line.
    """
    if not isinstance(error, InputError):
        return error
    flags = [option for option in options if option.opts[0].startswith("--")]
    set_flags = [option.opts[0] for option in flags if is_set(option, values)]
    candidates = _candidates(flags)  # options that may give each argument
    for name, key in keys.items():
        if not set(candidates.get(name, ())) & set(set_flags):
            candidates[name] = (key,)
    return InputError(in_options(str(error), candidates, set_flags))


def in_options(
    message: str, candidates: Mapping[str, tuple[str, ...]], set_options: Collection[str]
) -> str:
    """Return an error message with names of options in place of names of Python arguments.

    `candidates`: by argument, the options that may give it, the option of the same name first.
    `set_options`: options of the command line. An argument stays where two of its options are set;
    a single word, which may be English, is replaced at a few places only. A line on a key of a file
    stays.
    """
    lines = []
    for text in message.split("\n"):
        line, named_options = text, {} if _IN_A_FILE.match(text) else candidates
        for name, options in named_options.items():
            likely = [option for option in options if option in set_options]
            if "_" in name:  # wherever it is a word: by the given option, or else by the first one
                option = (likely or options[:1])[0] if len(likely) < 2 else name
                line = re.sub(rf"(?<![\w.\-]){name}(?![\w=(])", option, line)
                continue
            if len(likely) == 1:  # at the begin of a line: "duration of the wind must be ..."
                line = re.sub(rf"^{name}( of the wind)?(?= (must|is|needs)\b)", likely[0], line)
            line = re.sub(rf"(?<=\bgive ){name}(?=,)", options[0], line)  # "give duration, ..."
        for word, first, second in _PAIR.findall(line):
            if first in named_options and second in named_options:
                pair = f"{named_options[first][0]} and {named_options[second][0]}"
                line = line.replace(f"{word} {first} and {second}", f"{word} {pair}")
        lines.append(line)
    return "\n".join(lines)


def _candidates(options: Iterable[Any]) -> dict[str, tuple[str, ...]]:
    """Return the options that may give each argument, the option of the same name first.

    An argument has the name of its option without the unit, or a name in `_ARGUMENTS`. `options`:
    options of a command, which are returned as they are written, "--peak-deg".
    """
    by_name: dict[str, list[str]] = {}
    others: dict[str, list[str]] = {}
    for option in options:
        by_name.setdefault(without_unit(option.name.strip("_")), []).append(option.opts[0])
        for name in _ARGUMENTS.get(option.opts[0], ()):
            others.setdefault(name, []).append(option.opts[0])
    return {
        name: tuple(dict.fromkeys([*by_name.get(name, []), *others.get(name, [])]))
        for name in [*by_name, *(option for option in others if option not in by_name)]
    }


def is_set(option: Any, values: Mapping[str, Any]) -> bool:
    """Return whether an option has another value than its default."""
    value = values.get(option.name)
    return value is not None and value is not False and value not in ([], (), option.default)
