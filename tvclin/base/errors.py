"""Checks of arguments, whose errors are one sentence each.

Every check names the argument, the rule that it violates, and the value, so that the reader knows
which argument to change.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from difflib import get_close_matches
from importlib import import_module
from os import PathLike, fspath
from pathlib import Path
from reprlib import Repr
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray

MAX_AXES = 16
"""Largest number of axes of an array; numpy broadcasts at most 32, and some are added here."""
MAX_TIME = 1e9
"""Largest time [s]: later times can no longer be added without loss of digits."""
_Check = Callable[..., FloatArray]
_MAX_QUOTED_CHARACTERS = 60
"""Largest number of characters of a value that a message quotes."""
_MAX_LISTED_CHARACTERS, _MIN_QUOTED_CHARACTERS = 360, 20
"""Largest number of characters of a list of names with the value that is not among them, and the
smallest number of characters of that value."""
_MAX_FILE_NAME = 255
"""Largest number of characters of a file name."""


class InputError(ValueError):
    """Error of an argument, a key or a file that cannot be used; the message says the remedy."""


class NotKnownError(InputError):
    """Error of a case without a known answer, as for a wind that is too steep; others continue."""


@contextmanager
def naming(what: str) -> Iterator[None]:
    """Prefix each line of an `InputError` raised inside with `what`: a file, a table or a row.

    An error of several faults has a line for each.
    """
    try:
        yield
    except InputError as error:
        raise InputError("\n".join(f"{what}: {line}" for line in str(error).split("\n"))) from None


class Faults:
    """Collection of faults of a file, which are reported together, a line for each.

    Examples
    --------
    >>> faults = Faults()
    >>> for value in (-1.0, 1.0, -2.0):
    ...     with faults.collect():
    ...         _ = positive("number", value)
    >>> faults.raise_all()
    Traceback (most recent call last):
    tvclin.base.errors.InputError: number must be positive; got -1
    number must be positive; got -2
    """

    def __init__(self) -> None:
        """Start without faults."""
        self.lines: list[str] = []

    @contextmanager
    def collect(self) -> Iterator[None]:
        """Collect the `InputError` raised inside, each line once."""
        try:
            yield
        except InputError as error:
            self.lines += [line for line in str(error).split("\n") if line not in self.lines]

    def raise_all(self) -> None:
        """Raise an `InputError` of all collected lines, if there are any."""
        if self.lines:
            raise InputError("\n".join(self.lines))


def missing(needs: str, extra: str) -> InputError:
    """Return the error that an `extra` is not installed, as "`needs`, which is not installed"."""
    return InputError(f"{needs}, which is not installed: {install(extra)}")


def imported(package: str, needs: str, extra: str) -> Any:
    """Return the module `package` of an `extra`, imported on demand: many take half a second.

    `InputError` if it is not installed; `needs` begins the message, as "a Dataset needs xarray".
    """
    try:
        return import_module(package)
    except ImportError:
        raise missing(needs, extra) from None


def install(*extras: str) -> str:
    """Return the command that installs extras into the environment of this interpreter."""
    python = Path(sys.executable or "python")
    with suppress(OSError, ValueError):  # no working directory, or the interpreter is not in it
        python = python.relative_to(Path.cwd())
    return f'{python} -m pip install "tvclin[{",".join(extras)}]"'


def real(name: str, value: ArrayLike, unit: str = "") -> FloatArray:
    """Return `value` [`unit`] as an array, maybe infinite; `InputError` about `name` for NaN."""
    array = numbers(name, value, unit)
    _require(name, "a number", array, ~np.isnan(array), unit)
    return array


def finite(name: str, value: ArrayLike, unit: str = "") -> FloatArray:
    """Return `value` [`unit`] as a read-only array; `InputError` about `name` unless all finite."""
    return _finite(name, value, unit)[0]


def numbers(name: str, value: ArrayLike, unit: str = "") -> FloatArray:
    """Return `value` [`unit`] as a read-only array; `InputError` about `name` unless numeric."""
    array = array_of(name, value, "iuf", f"a number in {unit}" if unit else "a number")
    if array.ndim > MAX_AXES:
        raise InputError(f"{name} must have at most {MAX_AXES} axes; got {array.ndim}")
    array = np.array(array, dtype=float)
    array.flags.writeable = False
    return array


def array_of(name: str, value: ArrayLike, kinds: str, rule: str) -> AnyArray:
    """Return `value` as an array of numpy `kinds`; else `InputError`: `name` must be `rule`.

    `kinds`: letters of the kinds of numpy types, such as "iuf" for integers and floats.
    """
    try:
        array = np.asarray(value)
        if array.dtype.kind not in kinds:
            raise TypeError
    except Exception:  # whatever a stranger's conversion to an array may raise
        raise InputError(f"{name} must be {rule}; got {shown(value)}") from None
    return array


def _finite(name: str, value: ArrayLike, unit: str) -> tuple[FloatArray, float, float]:
    """Return `value` [`unit`] as a finite array, its minimum and its maximum; (inf, -inf) if empty.

    An empty array passes all checks of a range by these. `InputError` about the argument `name`
    otherwise.
    """
    array = numbers(name, value, unit)
    if not array.size:
        return array, np.inf, -np.inf
    low, high = array.min(), array.max()
    if not (low > -np.inf and high < np.inf):
        _require(name, "finite", array, np.isfinite(array), unit)
    return array, low, high


def positive(name: str, value: ArrayLike, unit: str = "") -> FloatArray:
    """Return `value` [`unit`] as an array; `InputError` about `name` unless all are above zero."""
    array, low, _ = _finite(name, value, unit)
    if not low > 0:
        _require(name, "positive", array, array > 0, unit)
    return array


def nonnegative(name: str, value: ArrayLike, unit: str = "") -> FloatArray:
    """Return `value` [`unit`] as an array; `InputError` about `name` if any is below zero."""
    array, low, _ = _finite(name, value, unit)
    if not low >= 0:
        _require(name, "zero or positive", array, array >= 0, unit)
    return array


def nonzero(name: str, value: ArrayLike, unit: str = "") -> FloatArray:
    """Return `value` [`unit`] as an array; `InputError` about `name` if an element is zero."""
    array = finite(name, value, unit)
    _require(name, "other than zero", array, array != 0, unit)
    return array


def within(
    name: str, value: ArrayLike, lowest: float, highest: float, unit: str = ""
) -> FloatArray:
    """Return `value` [`unit`] as an array; else `name` must be between `lowest` and `highest`."""
    array, low, high = _finite(name, value, unit)
    if not (low >= lowest and high <= highest):
        rule = f"between {lowest:.6g} and {highest:.6g}"
        _require(name, rule, array, (array >= lowest) & (array <= highest), unit)
    return array


def between(lowest: float, highest: float) -> Callable[..., FloatArray]:
    """Return the check `within` [`lowest`, `highest`] as a function of name, value and unit."""
    return lambda name, value, unit="": within(name, value, lowest, highest, unit)


def one_of(name: str, value: object, choices: Iterable[str]) -> str:
    """Return `value` if among `choices`; else `InputError` about `name`, with similar choices."""
    names = list(choices)
    if isinstance(value, str) and value in names:
        return value
    word = isinstance(value, str) and len(value) <= _MAX_QUOTED_CHARACTERS
    similar = get_close_matches(str(value), names, n=2, cutoff=0.5) if word else []
    hint = f" (did you mean {' or '.join(map(repr, similar))}?)" if similar else ""
    listed = ", ".join(names)
    # the quoted value gets what the choices leave of a message of limited length
    room = _MAX_LISTED_CHARACTERS - len(listed)
    got = _shortened(shown(value), max(room, _MIN_QUOTED_CHARACTERS))
    raise InputError(f"{name} must be one of {listed}; got {got}{hint}")


def instance(name: str, value: object, kind: type, maker: str) -> None:
    """Raise `InputError` about `name` unless `value` is a `kind`; `maker` says how to make one."""
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        raise InputError(f"{name} must be {article} {kind.__name__} ({maker}); got {shown(value)}")


def each(name: str, values: object, kind: type, maker: str) -> tuple[Any, ...]:
    """Return a tuple or list `values` as a tuple; `InputError` unless each element is a `kind`.

    `name`: of the argument, in the message. `maker`: text on how to make an element.
    """
    if isinstance(values, tuple | list) and all(isinstance(value, kind) for value in values):
        return tuple(values)
    raise InputError(f"{name} must be a tuple of {kind.__name__} ({maker}); got {shown(values)}")


def different(name: str, values: object) -> tuple[Any, ...]:
    """Return the tuple `values`; `InputError` about `name` if it is empty or repeats a value.

    Also for another type than a tuple, such as a list.
    """
    try:
        if isinstance(values, tuple) and 0 < len(values) == len(set(values)):
            return values
    except TypeError:  # values without a hash, which are not compared
        pass
    raise InputError(f"{name} must be a tuple of one or more different values; got {shown(values)}")


def text(name: str, value: object) -> str:
    """Return `value`; `InputError` about `name` unless it is a text of printable characters."""
    if isinstance(value, str) and value.isprintable():
        return value
    raise InputError(f"{name} must be a text of printable characters; got {shown(value)}")


def flag(name: str, value: object) -> bool:
    """Return `value`, maybe of numpy, as a bool; `name` must be True or False otherwise."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise InputError(f"{name} must be True or False; got {shown(value)}")


def callable_for(name: str, value: object, what: str) -> None:
    """Raise `InputError` unless `value` can be called: `name` must be a function `what`."""
    if not callable(value):
        raise InputError(f"{name} must be a function {what}; got {shown(value)}")


def path(name: str, value: object, what: str = "a path that a file can have") -> Path:
    """Return `value` as a `Path`; else `InputError`: `name` must be `what`."""
    written = fspath(value) if isinstance(value, str | PathLike) else None
    if isinstance(written, str) and written and "\0" not in written:
        path_of_text = Path(written)
        if all(len(component) <= _MAX_FILE_NAME for component in path_of_text.parts):
            return path_of_text
    raise InputError(f"{name} must be {what}; got {shown(value)}")


def single(name: str, batch: tuple[int, ...]) -> None:
    """Raise `InputError` about the argument `name` if the shape of its `batch` is not ``()``."""
    if batch:
        raise InputError(f"{name} must be one {name}; got a batch of shape {batch}")


def number(
    name: str, value: ArrayLike, check: Callable[..., FloatArray] = finite, unit: str = ""
) -> float:
    """Return the scalar `value` [`unit`] as a float; `InputError` about `name` by the `check`."""
    array = np.asarray(check(name, value, unit))
    if array.ndim:
        raise InputError(f"{name} must be one number; got an array of shape {array.shape}")
    return float(array)


def unlimited(
    name: str, value: ArrayLike, check: Callable[..., FloatArray] = positive, unit: str = ""
) -> float:
    """Return a scalar limit `value` [`unit`] as a float: infinity, or else a number as by `number`.

    `name`: of the argument, in messages. `check`: function of name, value and unit.
    """
    if isinstance(value, float) and value == np.inf:
        return np.inf
    return number(name, value, check, unit)


def directions(name: str, value: ArrayLike, unit: str = "rad") -> FloatArray:
    """Return directions `value` in `unit`, rad or deg; `InputError` about `name` above a turn."""
    full_turn = 360.0 if unit == "deg" else 2.0 * np.pi
    return within(name, value, -full_turn, full_turn, unit)


def bearing(name: str, value: ArrayLike) -> float:
    """Return a direction `value` [rad] as a float; `InputError` about `name` beyond a full turn."""
    return number(name, value, directions, "rad")


def in_degrees(angle: float) -> str:
    """Return the text of an `angle` [rad] for a message, in degrees and in radians.

    Arguments are in radians, options of commands in degrees.
    """
    with np.errstate(over="ignore"):
        return f"{np.degrees(angle):.6g} deg ({angle:.6g} rad)"


def small_angle(what: str, check: _Check = finite) -> _Check:
    """Return a `check` of angles, called `what`, that are within 90 degrees, in rad or "deg".

    The check is a function of name, value and unit. 90 degrees themselves are refused.
    """

    def checked(name: str, value: ArrayLike, unit: str = "rad") -> FloatArray:
        """Return angles `value` as an array; `InputError` by `check`, and from 90 degrees on.

        `name`: of the argument, in messages. `unit`: "rad" or "deg", in which the angles are.
        """
        array = check(name, value, unit)
        largest = np.abs(array).max(initial=0.0)
        if unit == "deg" and largest >= 90.0:
            raise InputError(f"{name} must be {what} within 90 degrees; got {largest:.6g} deg")
        if unit != "deg" and largest >= np.pi / 2:
            raise InputError(f"{name} must be {what} within 90 degrees; got {in_degrees(largest)}")
        return array

    return checked


def limit_angle(value: ArrayLike, name: str = "deflection_limit") -> float:
    """Return a limit `value` [rad] as a float; `InputError` unless positive, within 90 degrees.

    `name`: name of the argument, in messages.
    """
    return number(name, value, small_angle("a deflection", positive), "rad")


def fraction(name: str, value: ArrayLike, unit: str = "") -> float:
    """Return the scalar `value` [`unit`] as a float; `InputError` about `name` outside (0, 1)."""
    part = number(name, value, unit=unit)
    if not 0.0 < part < 1.0:
        raise InputError(f"{name} must be above 0 and below 1; got {part:.6g}")
    return part


def one_row(name: str, value: ArrayLike, unit: str = "") -> FloatArray:
    """Return `value` [`unit`] as an array ``(n,)``; `InputError` about `name` for other shapes."""
    array = finite(name, value, unit)
    if array.ndim != 1 or not array.size:
        raise InputError(f"{name} must be one row of numbers; got an array of shape {array.shape}")
    return array


def times_row(name: str, value: ArrayLike) -> FloatArray:
    """Return times `value` [s] as an array ``(n,)``; `InputError` about `name` beyond 1e9 s."""
    return within(name, one_row(name, value, "s"), -MAX_TIME, MAX_TIME, "s")


def whole_number(name: str, value: object) -> int:
    """Return `value` >= 0, also from numpy, as an int; `InputError` about `name` otherwise."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 0:
        raise InputError(f"{name} must be an integer, zero or positive; got {shown(value)}")
    return int(value)


def ending(name: str, end: ArrayLike) -> None:
    """Raise `InputError` about a history `name` without end, or zero: `end` [s] not finite.

    A history that is zero at all times has an end of minus infinity.
    """
    if not np.all(np.isfinite(end)):
        raise InputError(f"{name} must end, and be other than zero")


def plain(array: FloatArray | np.float64) -> float | FloatArray:
    """Return a Python float for an array of shape ``()``, and other arrays unchanged."""
    return float(array) if array.ndim == 0 else array


def together(**arrays: AnyArray) -> None:
    """Raise `InputError` unless the named arrays broadcast."""
    broadcast(**{name: array.shape for name, array in arrays.items()})


def broadcast(**shapes: tuple[int, ...]) -> tuple[int, ...]:
    """Return the shape to which the named shapes broadcast; `InputError` if there is none."""
    if not any(shapes.values()):
        return ()
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        listed = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
        raise InputError(
            f"arguments must have shapes that broadcast together; got {listed}"
        ) from None


def _require(name: str, rule: str, array: FloatArray, good: BoolArray, unit: str) -> None:
    """Raise `InputError` about the first of `array` that is not `good`: `name` must be `rule`.

    The message has the index of that element, unless the array is a single number. `good`: whether
    each element satisfies the rule, in its shape. `unit`: of the elements.
    """
    if np.all(good):
        return
    where = np.unravel_index(int(np.argmin(good)), good.shape)  # the first False, on all axes
    index = where[0] if len(where) == 1 else tuple(int(i) for i in where)
    position = f" at index {index}" if where else ""
    unit = f" {unit}" if unit else ""
    raise InputError(f"{name} must be {rule}; got {array[where]:.6g}{unit}{position}")


def shown(value: object) -> str:
    """Return the text by which a message quotes a value: one short line."""
    try:
        text = " ".join(_BRIEF.repr(value).split())
    except Exception:  # a value that cannot be written down
        text = f"something of type {type(value).__name__}"
    return _shortened(text, _MAX_QUOTED_CHARACTERS)


def _shortened(text: str, size: int) -> str:
    """Return a `text` cut to at most `size` characters, with an ellipsis at the end."""
    return text if len(text) <= size else f"{text[: size - 3]}..."


_BRIEF = Repr()
_BRIEF.maxstring = _BRIEF.maxlong = _BRIEF.maxother = 4 * _MAX_QUOTED_CHARACTERS
_BRIEF.maxlist = _BRIEF.maxtuple = _BRIEF.maxdict = _BRIEF.maxset = _BRIEF.maxfrozenset = (
    _MAX_QUOTED_CHARACTERS
)
