"""Messages of commands: arguments of Python by the options that give them."""

import re
from collections.abc import Iterable, Mapping
from typing import Any

from tvclin.base.errors import InputError

_UNIT = re.compile(r"_(deg|rad|m|m2|s|ms|hz|per_rad|percent)$")
"""Unit at the end of a parameter's name."""
_ARGUMENTS: dict[str, tuple[str, ...]] = {
    "--gust": ("peak", "duration"),
    "--gust-speed": ("speed", "duration"),
    "--peak-speed": ("speed",),
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
    """Return the error of a command with its options in place of arguments, if it is of an input.

    `options`: the parameters of the command. `values`: their values, by name. `keys`: keys of --set
    that give an argument, where no option does.
    """
    if not isinstance(error, InputError):
        return error
    flags = [option for option in options if option.opts[0].startswith("--")]
    flags_given = [option.opts[0] for option in flags if is_set(option, values)]
    candidates = _candidates(flags)
    for name, key in keys.items():
        if not set(candidates.get(name, ())) & set(flags_given):
            candidates[name] = (f"--set {key}",)
    return InputError(in_options(str(error), candidates, flags_given))


def in_options(
    message: str, candidates: Mapping[str, tuple[str, ...]], given: Iterable[str]
) -> str:
    """Return a message with options in place of arguments.

    `candidates`: the options that may give an argument, its own first. `given`: those that are
    given; where that leaves two, or none of a single word, the argument stays.
    """
    options = set(given)
    return "\n".join(_in_options(line, candidates, options) for line in message.split("\n"))


def _in_options(line: str, candidates: Mapping[str, tuple[str, ...]], given: set[str]) -> str:
    """Return a line of a message with names of parameters replaced by options of the command."""
    if _IN_A_FILE.match(line):
        return line
    for name, options in candidates.items():
        likely = [option for option in options if option in given]
        if "_" in name:
            option = (likely or options[:1])[0] if len(likely) < 2 else name
            line = re.sub(rf"(?<![\w.\-]){name}(?![\w=(])", option, line)
            continue
        if len(likely) == 1:
            line = re.sub(rf"^{name}(?=( of the wind)? (must|is|needs)\b)", likely[0], line)
        line = re.sub(rf"(?<=\bgive ){name}(?=,)", options[0], line)
    for word, *pair in _PAIR.findall(line):
        if all(name in candidates for name in pair):
            first, second = (candidates[name][0] for name in pair)
            line = line.replace(f"{word} {pair[0]} and {pair[1]}", f"{word} {first} and {second}")
    return line


def _candidates(options: Iterable[Any]) -> dict[str, tuple[str, ...]]:
    """Return the options that may give each argument, the option of the same name first."""
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
