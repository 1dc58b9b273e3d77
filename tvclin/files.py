"""Files, written whole or not at all."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tvclin.errors import InputError


def write_whole(path: Path, write: Callable[[str], Any]) -> None:
    """Call `write` with a temporary path and move the result into place when it is complete.

    Parameters
    ----------
    path : Path
        The file; one that is there already is replaced.
    write : callable
        Takes the temporary path and writes everything there.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    if path.is_dir():
        raise InputError(f"{path} is a directory; name a file in it")
    if path.exists() and not path.is_file():
        raise InputError(f"{path} is not an ordinary file; name another")
    if not path.parent.exists():
        raise InputError(f"{path} cannot be written: make the folder {path.parent} first")
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        os.close(handle)
    except (OSError, ValueError) as error:
        raise _unwritable(path, error) from None
    try:
        write(temporary)
        mask = os.umask(0)
        os.umask(mask)
        Path(temporary).chmod(0o666 & ~mask)
        Path(temporary).replace(path)
    except OSError as error:
        raise _unwritable(path, error) from None
    finally:
        Path(temporary).unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text as UTF-8; see `write_whole`."""
    write_whole(path, lambda target: Path(target).write_text(text, encoding="utf-8", newline=""))


def read_text(path: Path, kind: str, start: str = "") -> str:
    """Return the text of a file in UTF-8, with or without a byte order mark.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        What it should be, for messages: "a vehicle file".
    start : str
        How to get one, for messages.

    Raises
    ------
    InputError
        When the file cannot be read, is empty, or is no text.
    """
    hint = f"; {start}" if start else ""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            text = file.read()
    except IsADirectoryError:
        raise InputError(f"{path} is a directory; name {kind} in it") from None
    except FileNotFoundError:
        raise InputError(f"{path} does not exist{hint}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is not a text file in UTF-8") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{path} cannot be read: {reason}") from None
    if not text.strip():
        raise InputError(f"{path} is empty{hint}")
    return text


def make_directory(path: Path) -> None:
    """Make a directory, and those above it, unless it is there.

    Raises
    ------
    InputError
        When a file stands in its place, or it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise InputError(f"{path} is a file; name a directory") from None
    except (OSError, ValueError) as error:
        raise _unwritable(path, error) from None


def _unwritable(path: Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or str(error)
    return InputError(f"{path} cannot be written: {reason}")
