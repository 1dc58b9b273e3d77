"""Wind lists of RocketPy's custom atmosphere, in Python or JSON; no code is executed."""

from __future__ import annotations

import ast
import json
import warnings
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, shown
from tvclin.base.lines import plural
from tvclin.base.sheet import Text
from tvclin.winds.soundings.levels import Levels, SoundingEntry

_LISTS = ("wind_u", "wind_v")


def soundings_in(text: Text) -> list[SoundingEntry]:
    """Return the sounding in a text with the lists wind_u and wind_v of (height m, m/s)."""
    return [SoundingEntry(lambda: _read(text))]


def _read(text: Text) -> Levels:
    """Return levels with the winds of the lists wind_u and wind_v in a text, at all heights.

    Each wind is interpolated linearly; heights that only one list reaches are omitted.
    """
    lists = _lists(text)  # line and value of each list
    # line, heights [m] and winds [m/s] towards east (u) and north (v)
    (line, z_u, u), (_, z_v, v) = (_pairs(text, name, *lists[name]) for name in _LISTS)
    height = np.unique(np.concatenate([z_u, z_v]))
    low, high = max(z_u[0], z_v[0]), min(z_u[-1], z_v[-1])
    common = height[(height >= low) & (height <= high)]
    cut = height.size - common.size
    return Levels(
        text=text,
        line=np.full(common.size, line, dtype=np.int64),
        height=common,
        east=np.interp(common, z_u, u),
        north=np.interp(common, z_v, v),
        notes=(f"{plural(cut, 'level')} that only one list reaches left out",) if cut else (),
    )


def _lists(text: Text) -> dict[str, tuple[int, Any]]:
    """Return line and value of the lists wind_u and wind_v in a text, JSON or Python, by name."""
    content = "\n".join(text.lines)
    try:
        table = json.loads(content)
        lists = {name: (1, table[name]) for name in _LISTS if name in table}
    except (ValueError, TypeError, RecursionError):
        lists = _assigned(text, content)
    for name in _LISTS:
        if name not in lists:
            raise InputError(
                f"{text.source} must hold lists wind_u and wind_v of (height m, m/s); {name} is"
                " missing"
            )
    return lists


def _assigned(text: Text, content: str) -> dict[str, tuple[int, Any]]:
    """Return line and value of the lists that Python code assigns or passes by name, by name.

    `text`: the file, for errors. `content`: its code, which is parsed and not executed.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about escapes in strings of no interest
            nodes = list(ast.walk(ast.parse(content)))
    except SyntaxError as error:
        raise text.error(error.lineno or 1, f"neither JSON nor Python: {error.msg}") from None
    except (ValueError, RecursionError, MemoryError):
        raise InputError(f"{text.source} is neither JSON nor Python") from None
    lists: dict[str, tuple[int, Any]] = {}
    expressions: dict[str, ast.expr] = {}
    for node in nodes:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                pass
            case ast.keyword(arg=str(name), value=value):
                pass
            case _:
                continue
        if name in _LISTS and isinstance(value, ast.List | ast.Tuple):
            lists[name] = (value.lineno, _literal(text, name, value))
        elif name in _LISTS:
            expressions[name] = value
    for name in expressions.keys() - lists.keys():
        raise text.error(
            expressions[name].lineno,
            f"{name} is given as {shown(ast.unparse(expressions[name]))} and no list: write its"
            " numbers as a list of (height m, m/s)",
        )
    return lists


def _literal(text: Text, name: str, value: ast.expr) -> Any:
    """Return the value of a literal; an error names the line of any other expression.

    `text`: the file, and `name`: the list, for the error. `value`: the expression.
    """
    try:
        return ast.literal_eval(value)
    except (ValueError, TypeError, RecursionError, MemoryError):
        raise text.error(value.lineno, f"{name} must be a list of numbers, nothing else") from None


def _pairs(text: Text, name: str, line: int, value: Any) -> tuple[int, FloatArray, FloatArray]:
    """Return line, heights [m] and winds [m/s], ``(n,)``, of a list of pairs.

    `text`, `name`, `line`: file, name and line of the list, for errors. `value`: the list.
    """
    try:
        pairs = np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        pairs = np.empty(0)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or len(pairs) < 2 or not np.all(np.isfinite(pairs)):
        raise text.error(line, f"{name} must be a list of two or more pairs (height m, m/s)")
    height, wind = pairs.T
    if np.any(np.diff(height) <= 0.0):
        raise text.error(line, f"the heights of {name} must ascend; sort the list")
    return line, height, wind
