"""Files: texts and tables read, and everything written whole or not at all."""

from __future__ import annotations

import codecs
import csv
import io
import os
import re
import stat
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from copy import deepcopy
from os import PathLike
from pathlib import Path
from typing import Any, Self

from tvclin.base.errors import InputError, shown
from tvclin.base.errors import path as a_path


class EditedSource(str):
    """Complete name or path of a file, whose tables are these in place of those in the file.

    `tables_of` (`base/files`) returns them, so that every reader of the source has the same.

    Parameters
    ----------
    source : str
        Name or path, as messages quote it.
    tables : dict, optional
        Tables by heading, as TOML has them; without them the file's own content counts.
    keys : tuple of str, optional
        Names of the keys that were set, other than those removed.

    Attributes
    ----------
    keys : tuple of str
        As the parameter.
    """

    _tables: dict[str, Any] | None
    keys: tuple[str, ...]

    def __new__(
        cls, source: str, tables: dict[str, Any] | None = None, keys: tuple[str, ...] = ()
    ) -> Self:
        """Return the text `source` with its edited `tables`, and the `keys` that were set."""
        edited = super().__new__(cls, source)
        edited._tables, edited.keys = tables, keys
        return edited

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        """Return the source itself, which is never changed; `memo` belongs to `copy.deepcopy`."""
        return self

    @property
    def tables(self) -> dict[str, Any] | None:
        """A copy of the tables; None where they equal the tables of the file."""
        return deepcopy(self._tables)


_MAX_DEPTH = 8
"""Largest depth of nested tables and lists; real files have at most four levels."""
_MAX_QUOTED_NAME = 160
"""Largest number of characters of a name that messages quote in full."""
_MAX_TEMPORARY_PREFIX = 60
"""Characters of its name in the temporary file, at most four bytes each."""
MAX_BYTES, _MAX_TABLE_CHARACTERS = 100_000_000, 4_000_000
"""Largest number of bytes of a file that is read at once, and of characters of its tables."""
_MAX_LINE_CHARACTERS = 1_000_000
"""Largest number of characters of a line."""
UTF_8 = ("utf-8-sig",)
ENCODINGS = (*UTF_8, "utf-16", "cp1252")
"""Encodings of tables, in the order in which they are tried."""
_MAX_DOTS = 100
"""Largest number of dots in a key; parsing takes the square of their number."""
_CONTROL = re.compile(
    r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
"""Control characters but tab and line feed, those that change the direction of writing, and bytes
in the name of a file that are no letters."""
_FORMULA = ("=", "+", "-", "@", "\t")
"""First characters of a cell that a spreadsheet takes for a formula."""
_QUOTED = re.compile(r"\"[^\"\n]*\"|'[^'\n]*'")
_OUTPUTS: ContextVar[tuple[tuple[str, Path], ...]] = ContextVar("outputs", default=())
"""Options of the running command that name files to write, with these files."""


@contextmanager
def separate_outputs() -> Iterator[None]:
    """Within it, a file that `name_output` has named cannot be read."""
    token = _OUTPUTS.set(())
    try:
        yield
    finally:
        _OUTPUTS.reset(token)


def name_output(option: str, path: Path) -> None:
    """Add a file that is written at last to those that are not read; `option` names it."""
    _OUTPUTS.set((*_OUTPUTS.get(), (option, path)))


def check_not_output(path: Path) -> None:
    """Raise `InputError` if `path`, which is about to be read, is a file that is written later."""
    for option, output in _OUTPUTS.get():
        if exists(output) and exists(path) and output.samefile(path):
            raise InputError(f"{option} must not be a file that is read; got {called(output)}")


def write_whole(path: Path, write: Callable[[str], Any]) -> None:
    """Call `write` with a temporary path, and move the complete file to its place.

    An existing file is replaced, with its mode; a link is followed. If `write` fails, the temporary
    file is removed and the old one stays. `InputError` where the file cannot be written.
    """
    path = target_of(path)
    try:
        handle, temporary = tempfile.mkstemp(
            dir=path.parent, prefix=f".{path.name[:_MAX_TEMPORARY_PREFIX]}."
        )
        os.close(handle)
    except (OSError, ValueError) as error:
        raise _unwritable(path, error) from None
    try:
        write(temporary)
        with Path(temporary).open("rb+") as file:
            os.fsync(file.fileno())
        Path(temporary).chmod(_mode(path))
        Path(temporary).replace(path)
    except OSError as error:
        raise _unwritable(path, error) from None
    finally:
        Path(temporary).unlink(missing_ok=True)


def target_of(path: Path) -> Path:
    """Return the path to write, behind links; `InputError` where no file can be written.

    That is a directory, a device, a folder that does not exist, or a name that is too long.
    """
    name, path = called(path), _behind_links(path)
    if exists(path) and path.is_dir():
        raise InputError(f"{name} is a directory; name a file in it")
    if exists(path) and not path.is_file():
        raise InputError(f"{name} is not an ordinary file; name another")
    if not exists(path.parent):
        raise InputError(f"{name} cannot be written: make the folder {called(path.parent)} first")
    try:
        path.lstat()
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as error:  # its name is too long
        raise _unwritable(path, error) from None
    return path


def write_text(path: Path, text: str) -> None:
    """Write `text` to `path` as UTF-8; an old file stays until the new one is complete."""
    write_whole(path, lambda target: Path(target).write_text(text, encoding="utf-8", newline=""))


def write_rows(rows: Iterable[Iterable[Any]], path: str | PathLike[str] | None = None) -> str:
    """Return rows of cells as CSV, and write it if there is a path, wholly or not at all.

    A text that a spreadsheet would take for a formula gets a leading apostrophe.
    """
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(map(_cell, row) for row in rows)
    if path is not None:
        write_text(a_path("path", path), text.getvalue())
    return text.getvalue()


def _cell(value: Any) -> Any:
    """Return a number `value` unchanged; a text without control characters, and never a formula."""
    if not isinstance(value, str):
        return value
    name = printable(value)
    return f"'{name}" if name.startswith(_FORMULA) else name


def write_new(path: Path, text: str) -> None:
    """Write `text` to `path`; `InputError` if that file exists and is not empty."""
    if exists(path) and path.is_file() and path.stat().st_size > 0:
        raise InputError(f"{called(path)} exists already; name another file or move it away")
    write_text(path, text)


def read_text(path: Path, kind: str, start: str = "", encodings: tuple[str, ...] = UTF_8) -> str:
    """Return the text of the file `path`, with or without a byte order mark.

    For messages, `kind` is what it should be, "a vehicle file", and `start` how to get one.
    `InputError` for an empty file, and a line that is too long. `encodings`: UTF-8, or `ENCODINGS`
    of tables that spreadsheets write.
    """
    content, name, text = read_bytes(path, kind, start), called(path), None
    marked = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    for encoding in encodings:  # the first that fits; UTF-16 exactly where the bytes have its mark
        if text is None and marked == (encoding == "utf-16"):
            with suppress(UnicodeDecodeError):
                text = content.decode(encoding)
    if text is None:
        others = "" if encodings == UTF_8 else ", UTF-16 or code page 1252"
        raise InputError(f"{name} is not a text file in UTF-8{others}")
    if not text.strip():
        raise InputError(f"{name} is empty{_hint(start)}")
    _check_lines(text, name)
    return text


def read_bytes(path: Path, kind: str, start: str = "") -> bytes:
    """Return the bytes of the file `path`, at most `MAX_BYTES`; `InputError` if it cannot be read.

    For messages, `kind` is what it should be, "a vehicle file", and `start` how to get one.
    """
    name = called(path)
    check_not_output(path)
    _check_ordinary(path)
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except IsADirectoryError:
        raise InputError(f"{name} is a directory; name {kind} in it") from None
    except FileNotFoundError:
        raise InputError(f"{name} does not exist{_hint(start)}") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{name} cannot be read: {reason(error)}") from None
    if len(content) > MAX_BYTES:
        raise InputError(f"{name} has more than {MAX_BYTES // 1_000_000} MB; name {kind}")
    return content


def _hint(start: str) -> str:
    """Return the end of a message, `start`: how to get a file; "" if that is empty."""
    return f"; {start}" if start else ""


def tables_of(text: str, source: str) -> dict[str, Any]:
    """Return the tables of a TOML text, or of an edited source; `source` names it in messages.

    The tables of an `EditedSource` replace the tables of the text. `InputError` for a text
    that is not TOML, nested too deep, or has a number beyond all floats.
    """
    tables = source.tables if isinstance(source, EditedSource) else None
    if tables is not None:
        return tables
    name = called(source)
    _check_text(text, name)
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        text_of_error = called(error)  # in one line
        raise InputError(f"{name} is not valid TOML: {text_of_error}") from None
    except RecursionError:
        raise InputError(f"{name} is not valid TOML: its lists are nested too deep") from None
    except ValueError:  # Python refuses integers of so many digits
        largest = sys.get_int_max_str_digits()
        raise InputError(f"{name} holds a whole number of more than {largest} digits") from None
    _check(document, name)
    return document


def exists(path: str | os.PathLike[str]) -> bool:
    """Return whether a file or directory `path` exists; False for an invalid name."""
    try:
        return Path(path).exists()
    except (OSError, ValueError):
        return False


def printable(text: str) -> str:
    """Return a text with a question mark for each control character but tab and line feed."""
    return _CONTROL.sub("?", text)


def called(path: object) -> str:
    """Return a file name, the text of `path`, as messages quote it: one line, shortened if long."""
    name = "".join(letter if letter.isprintable() else "?" for letter in str(path))
    half = _MAX_QUOTED_NAME // 2
    return name if len(name) <= _MAX_QUOTED_NAME else f"{name[:half]}...{name[3 - half :]}"


def reason(error: Exception) -> str:
    """Return the system's text of an `error` of opening a file."""
    return getattr(error, "strerror", None) or str(error)


def make_directory(path: Path) -> None:
    """Make the directory `path`, and its parents, unless it exists."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise InputError(f"{called(path)} is a file; name a directory") from None
    except (OSError, ValueError) as error:
        raise _unwritable(path, error) from None


def _behind_links(path: Path) -> Path:
    """Return the target of `path` if that is a link; any other path unchanged.

    `InputError` for links that lead back to themselves.
    """
    try:
        linked = path.is_symlink()
    except (OSError, ValueError):  # no file can have this name
        linked = False
    if not linked:
        return path
    matches = Path(os.path.realpath(path))
    if matches.is_symlink():
        raise InputError(f"{called(path)} is a link that leads back to itself; name a file")
    return matches


def _mode(path: Path) -> int:
    """Return the permission bits of the file `path`, or the default ones of a new file."""
    if path.exists():
        return stat.S_IMODE(path.stat().st_mode)
    mask = os.umask(0)  # it can only be read by setting it
    os.umask(mask)
    return 0o666 & ~mask


def _check_ordinary(path: Path) -> None:
    """Raise `InputError` if `path` is a device or pipe, which may never end, but standard input."""
    if not exists(path) or path.is_file() or path.is_dir():
        return
    try:
        if os.path.samestat(path.stat(), os.fstat(0)):
            return
    except OSError:  # there is no standard input
        pass
    raise InputError(
        f"{called(path)} is not an ordinary file; name one, or /dev/stdin for what is piped in"
    )


def _check_lines(text: str, name: str) -> None:
    """Raise `InputError` for a line of `text` above a million characters; `name`: of the file."""
    begin = 0
    while len(text) - begin > _MAX_LINE_CHARACTERS:
        last = begin + _MAX_LINE_CHARACTERS + 1
        end = max(text.rfind("\n", begin, last), text.rfind("\r", begin, last))
        if end < 0:
            line = text.count("\n", 0, begin) + 1
            raise InputError(
                f"{name}, line {line}: it has more than {_MAX_LINE_CHARACTERS} letters"
            )
        begin = end + 1


def _unwritable(path: Path, error: Exception) -> InputError:
    """Return the error that `path` cannot be written, with the reason of the system."""
    return InputError(f"{called(path)} cannot be written: {reason(error)}")


def _check_text(text: str, name: str) -> None:
    """Raise `InputError` for a TOML `text` of a file `name` that is too long or too nested.

    Nested are keys with many dots, whose parsing would take the square of their number.
    """
    if len(text) > _MAX_TABLE_CHARACTERS:
        raise InputError(
            f"{name} has more than {_MAX_TABLE_CHARACTERS // 1_000_000} million letters"
        )
    for piece in re.split(r"[\n,=\[\]{}]", _QUOTED.sub("quoted", text)):
        if piece.count(".") > _MAX_DOTS and not piece.lstrip().startswith("#"):
            key = shown(piece.rsplit(".", 1)[1].strip())
            raise InputError(f"{name}: {key} is nested more than {_MAX_DEPTH} levels deep")


def _check(document: dict[str, Any], name: str) -> None:
    """Raise `InputError` for a TOML `document` of a file `name` that is too deep or large.

    Large is a whole number beyond all floats. Messages name the key.
    """
    queue: list[tuple[object, str, int]] = [(document, "", 0)]
    while queue:
        value, key, depth = queue.pop()
        if depth > _MAX_DEPTH:
            raise InputError(f"{name}: {key} is nested more than {_MAX_DEPTH} levels deep")
        if isinstance(value, dict):
            queue += [(item, shown(inner), depth + 1) for inner, item in value.items()]
        elif isinstance(value, list):
            queue += [(item, key, depth + 1) for item in value]
        elif isinstance(value, int) and abs(value) > sys.float_info.max:
            raise InputError(f"{name}: {key} holds a whole number beyond {sys.float_info.max:.2g}")
