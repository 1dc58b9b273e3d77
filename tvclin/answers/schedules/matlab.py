"""Tables in .mat files of version 5: a vector for each column, by name."""

from __future__ import annotations

from os import PathLike

import numpy as np

from tvclin.answers.schedules.sheet import Heading, Sheet
from tvclin.base.errors import InputError, shown
from tvclin.base.errors import path as a_path
from tvclin.base.files import called
from tvclin.winds.soundings.text import Text


def matlab_sheet(path: str | PathLike[str]) -> Sheet:
    """Return the vectors of equal length in a .mat file as a table; single numbers as columns.

    `InputError` for a file that cannot be read, and one without two such vectors.
    """
    from scipy.io import loadmat

    source = called(file := a_path("path", path))
    try:
        found = loadmat(file, squeeze_me=True)
    except NotImplementedError:
        raise InputError(
            f"{source} is a .mat file of version 7.3; save it in MATLAB with -v7"
        ) from None
    except OSError as error:
        if error.filename:
            raise
        raise _unreadable(source) from None
    except Exception:  # scipy raises whatever a damaged file leads to
        raise _unreadable(source) from None
    held = {k: np.asarray(value) for k, value in found.items() if not k.startswith("__")}
    if len(held) == 1 and (only := next(iter(held.values()))).dtype.names:
        held = {name: only[name].item() for name in only.dtype.names}
    arrays = {name: np.asarray(value) for name, value in held.items()}
    numbers = {
        k: a.astype(float) for k, a in arrays.items() if a.ndim <= 1 and a.dtype.kind in "iuf"
    }
    rows = max((one.size for one in numbers.values()), default=0)
    columns = {name: one for name, one in numbers.items() if one.size in (1, rows)}
    if rows < 2:
        held_names = shown(", ".join(held)) if held else "nothing"
        raise InputError(f"{source} must hold vectors of one length; it holds {held_names}")
    whole = np.stack([np.broadcast_to(one, rows) for one in columns.values()], axis=1)
    cells = tuple(tuple(map(repr, row)) for row in whole.tolist())
    headings = tuple(Heading(k, name, name, None) for k, name in enumerate(columns))
    return Sheet(Text(source, ()), headings, np.arange(1, rows + 1), cells)


def _unreadable(source: str) -> InputError:
    return InputError(f"{source} is not a .mat file of version 5 that can be read")
