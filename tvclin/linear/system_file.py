"""Files of linear systems: MATLAB's .mat of version 5, and NumPy's .npz.

Both hold A, B, C, D, the sample time Ts [s], zero for continuous time, and cells of names:
InputName, OutputName, StateName. MATLAB and Octave read and write such a file with `load` and
`save -v7`; every number keeps its bits.
"""

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import numpy as np

from tvclin.base.arrays import AnyArray
from tvclin.base.errors import InputError
from tvclin.base.errors import path as a_path
from tvclin.base.files import called, read_bytes, write_whole
from tvclin.linear.named_systems import checked_system, named_system
from tvclin.linear.system import LinearSystem

if TYPE_CHECKING:
    from tvclin.linear.named_systems import AnySystem

_MATRICES = ("A", "B", "C", "D")
_NAMES = {"inputs": "InputName", "outputs": "OutputName", "states": "StateName"}
"""Variables of the names of signals; the keys are accepted as well."""
_PERIODS = ("Ts", "dt")
"""Variables of the sample time [s]: MATLAB's name, and python-control's."""
_DEFAULTS = {"inputs": "u[{}]", "outputs": "y[{}]", "states": "x[{}]"}
_SUFFIXES = (".mat", ".npz")
_MATLAB_73 = b"MATLAB 7.3"
_KIND = "a .mat file of version 5 or an .npz file with A, B, C and D"


def read_system(source: str | PathLike[str]) -> LinearSystem:
    """Return the system of a .mat file of version 5 or an .npz file.

    Parameters
    ----------
    source : str or path
        The file, with the matrices A, B, C and D; the names InputName, OutputName and StateName (or
        inputs, outputs and states), cells or rows of text; and the sample time Ts (or dt) [s], zero
        or absent for continuous time. In a .mat file a single struct may hold them.

    Returns
    -------
    LinearSystem
        `SystemPlant`, `SystemAutopilot` and `write_system` take it; ``to_control(name)`` is that of
        python-control.

    Raises
    ------
    InputError
        For a file that cannot be read, is of version 7.3, or lacks a matrix, and for sizes and
        names that do not fit.
    """
    file = a_path("source", source)
    name = called(file)
    variables = _variables(file, name)
    missing = [letter for letter in _MATRICES if letter not in variables]
    if missing:
        raise InputError(
            f"{name} has no {missing[0]}; its variables are {', '.join(variables) or 'none'}"
        )
    matrices = {m: _matrix(f"{m} of {name}", variables[m]) for m in _MATRICES}
    outputs, inputs = matrices["D"].shape
    sizes = {"inputs": inputs, "outputs": outputs, "states": len(matrices["A"])}
    signals = {}
    for kind, key in _NAMES.items():  # as "inputs" and "InputName"
        value = variables.get(key, variables.get(kind))
        names = () if value is None else _texts(f"{key} of {name}", value)
        if names and any(names):
            signals[kind] = names
        else:
            signals[kind] = tuple(_DEFAULTS[kind].format(k) for k in range(sizes[kind]))
    period = next((variables[key] for key in _PERIODS if key in variables), 0.0)
    return checked_system(name, [*matrices.values()], **signals, period=_period(name, period))


def write_system(system: AnySystem, path: str | PathLike[str]) -> None:
    """Write a system into a .mat file of version 5, or an .npz file, as `read_system` reads it.

    In MATLAB and Octave it is ``s = load("loop.mat"); ss(s.A, s.B, s.C, s.D, s.Ts)``.

    Parameters
    ----------
    system : control.StateSpace, control.TransferFunction or LinearSystem
        Such as ``plant.ss()``, ``autopilot.loop(plant)``, or ``autopilot.close(plant)``; one
        system, continuous or with a sample time.
    path : str or path
        The file to write, ending in .mat or .npz.

    Raises
    ------
    InputError
        For another ending, a batch, and a file that cannot be written.

    Examples
    --------
    >>> import tempfile, pathlib, numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "plant.mat")
    ...     tv.linear.write_system(plant.ss(), file)
    ...     read = tv.linear.read_system(file)
    >>> read.inputs, bool(np.all(read.A == plant.ss().A))
    (('deflection', 'wind'), True)
    """
    file, named = a_path("path", path), named_system("system", system)
    if named.batch:
        raise InputError(f"system must be one system; got a batch of shape {named.batch}")
    _suffix(file)
    period = 0.0 if named.period is None else float(named.period)
    variables: dict[str, Any] = dict(zip(_MATRICES, named.matrices(), strict=True))
    variables["Ts"] = period
    for kind, key in _NAMES.items():
        variables[key] = getattr(named, kind)
    write_whole(file, lambda target: _write(Path(target), file.suffix.lower(), variables))


def _write(target: Path, suffix: str, variables: Mapping[str, Any]) -> None:
    """Write variables into a file; names as cells in MATLAB's format, or as rows of text.

    `target`: the file. `suffix`: ".mat" or ".npz". `variables`: matrices, sample time and names.
    """
    if suffix == ".npz":
        arrays: dict[str, Any] = {key: np.asarray(value) for key, value in variables.items()}
        with target.open("wb") as stream:
            np.savez(stream, **arrays)
        return
    from scipy.io import savemat  # late: it takes 0.1 s to import

    with target.open("wb") as stream:
        cells = {  # a tuple of names is a column of cells
            key: np.array(value, object).reshape(-1, 1) if isinstance(value, tuple) else value
            for key, value in variables.items()
        }
        savemat(stream, cells)


def _suffix(file: Path) -> str:
    """Return the ending of a file, ".mat" or ".npz" in lower case; `InputError` for another."""
    suffix = file.suffix.lower()
    if suffix not in _SUFFIXES:
        raise InputError(f"{called(file)} must end in .mat or .npz, for {_KIND}")
    return suffix


def _variables(file: Path, name: str) -> dict[str, Any]:
    """Return the variables of a .mat or .npz file by their names, of a single struct its fields.

    `name`: of the file in messages. `InputError` for a file that cannot be read.
    """
    suffix, content = _suffix(file), read_bytes(file, _KIND)
    if suffix == ".npz":
        try:
            with np.load(BytesIO(content), allow_pickle=False) as archive:
                return dict(archive.items())
        except (ValueError, OSError, BadZipFile, KeyError, EOFError):
            raise InputError(f"{name} is not {_KIND}") from None
    if content.startswith(_MATLAB_73):
        raise InputError(f"{name} is a .mat file of version 7.3; save it in MATLAB with -v7")
    from scipy.io import loadmat  # late: it takes 0.1 s to import

    try:
        variables = loadmat(BytesIO(content), struct_as_record=True)
    except Exception:  # scipy raises errors of many types on damaged bytes
        raise InputError(f"{name} is not {_KIND}; save it with -v7") from None
    variables = {key: value for key, value in variables.items() if not key.startswith("__")}
    # arrays with fields are MATLAB's structs
    structs = [v for v in variables.values() if getattr(v, "dtype", None) and v.dtype.names]
    if "A" not in variables and len(structs) == 1 and structs[0].size == 1:
        record = structs[0].flat[0]
        return {key: record[key] for key in structs[0].dtype.names}
    return variables


def _matrix(what: str, value: Any) -> AnyArray:
    """Return a matrix ``(m, n)`` of real numbers; `InputError` for anything else.

    `what`: name of the matrix in the message. `value`: variable of the file.
    """
    array = np.asarray(value)
    if array.dtype.kind not in "fiub" or array.ndim > 2:
        raise InputError(f"{what} must be a matrix of real numbers; got {array.dtype} numbers")
    return np.atleast_2d(np.asarray(array, float))


def _texts(what: str, value: Any) -> tuple[str, ...]:
    """Return names of signals from cells, rows of text, or one text.

    `what`: name of the variable in the message. `value`: variable of the file.
    """
    # a cell is an array with its text as only element, or empty
    entries = [np.ravel(entry) for entry in np.ravel(np.asarray(value))]
    texts = [entry[0] if entry.size else "" for entry in entries]
    if not all(isinstance(text, str) for text in texts):
        raise InputError(f"{what} must be cells or rows of text")
    return tuple(str(text).strip() for text in texts)


def _period(name: str, value: Any) -> AnyArray | None:
    """Return the sample time [s]; None for zero. `InputError` for one that is not a number.

    `name`: name of the file in the message. `value`: variable of the file.
    """
    array = np.ravel(np.asarray(value))
    if array.size != 1 or array.dtype.kind not in "fiu" or not 0.0 <= float(array[0]) < np.inf:
        raise InputError(
            f"{name} must have a sample time Ts in seconds, zero in continuous time; got"
            f" {array.tolist()}"
        )
    return np.asarray(float(array[0])) if array[0] else None
