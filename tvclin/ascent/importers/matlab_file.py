"""Numbers of a .mat file of version 5, read within its bytes and a bound on what they unpack to.

`scipy.io.loadmat` trusts the types and sizes that a file states: one changed byte ends the
interpreter, and some kilobytes unpack to gigabytes. Only arrays of numbers are needed here. The
format is that of MathWorks' "MAT-File Format", level 5.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tvclin.base.arrays import AnyArray
from tvclin.base.errors import InputError
from tvclin.base.files import MAX_BYTES, called, read_bytes

Value = AnyArray | dict[str, AnyArray] | None
"""Real numbers without axes of length one, a structure's fields of such numbers, or neither."""

MAX_NUMBERS = MAX_BYTES // 20
"""Largest count of numbers, as many as a text of the largest size holds with all digits."""
_HEADER, _TAG = 128, 8
"""Bytes of the header of a file, and of the tag of an element."""
_MATRIX, _COMPRESSED = 14, 15
_NUMBER_TYPES = {
    **{1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4"},
    **{7: "f4", 9: "f8", 12: "i8", 13: "u8"},
}
_TEXT_TYPES = (1, 2, 16)
"""Data types of elements."""
_STRUCTURE, _OPAQUE, _NUMBERS = 2, 17, range(6, 16)
"""Classes of matrices; numbers are double, single and integers."""
_COMPLEX = 0x800
"""Flag of a matrix with an imaginary part."""


class _DamagedError(Exception):
    """Types or sizes that do not fit the bytes."""


def read_matlab(path: Path) -> dict[str, Value]:
    """Return the variables of the .mat file of version 5 at a path, by name.

    `InputError` for a file that cannot be read, is of another version, is damaged, or holds more
    than `MAX_BYTES` bytes or `MAX_NUMBERS` numbers when it is unpacked.
    """
    name, content = called(path), read_bytes(path, "the log of a simulation")
    # the header ends with the version, in two bytes, and two letters in the order of the bytes
    order = {b"IM": "<", b"MI": ">"}.get(content[126:_HEADER])
    version = content[125:126] if order == "<" else content[124:125]  # its upper byte
    if order is not None and version == b"\2":
        raise InputError(f"{name} is a .mat file of version 7.3; save it in MATLAB with -v7")
    try:
        if order is None or version != b"\1":
            raise _DamagedError
        return dict(_variables(memoryview(content), order, name))
    except (_DamagedError, zlib.error):
        raise InputError(
            f"{name} is not a .mat file of version 5 that can be read; save it in MATLAB with -v7"
        ) from None


def too_large(name: str, what: str) -> InputError:
    """Return the error about a file, by its name, that holds more than it may.

    `what`: the largest permitted amount, in words.
    """
    return InputError(f"{name} holds more than {what}; save the columns of the log, in fewer rows")


def _variables(content: memoryview, order: str, name: str) -> Iterator[tuple[str, Value]]:
    """Yield names and values of the variables of a file.

    `content`: its bytes. `order`: byte order, "<" or ">". `name`: name of the file, for errors.
    """
    # index of the next element, bytes that may yet be unpacked, and numbers read so far
    at, remaining, count = _HEADER, MAX_BYTES, 0
    while at < len(content):
        kind, size = _tag(content, at, order)
        end = at + _TAG + size
        if end > len(content):
            raise _DamagedError
        element = content[at + _TAG : end]
        if kind == _COMPRESSED:
            kind, element = _unpacked(element, order, remaining, name)
        if kind != _MATRIX:
            raise _DamagedError
        matrix = _Matrix.of(element, order)
        value = matrix.structure() if matrix.kind == _STRUCTURE else matrix.numbers()
        arrays = value.values() if isinstance(value, dict) else [] if value is None else [value]
        remaining, count = remaining - len(element), count + sum(entry.size for entry in arrays)
        if count > MAX_NUMBERS:
            raise too_large(name, f"{MAX_NUMBERS // 1_000_000} million numbers")
        if matrix.name:
            yield matrix.name, value
        at = end


def _unpacked(packed: memoryview, order: str, max_bytes: int, name: str) -> tuple[int, memoryview]:
    """Return type and bytes of a compressed element, no more bytes than its tag states.

    `packed`: its compressed bytes. `order`: byte order, "<" or ">". `max_bytes`: largest size, and
    `name`: name of the file, for the error.
    """
    stream = zlib.decompressobj()
    kind, size = _tag(memoryview(stream.decompress(packed, _TAG)), 0, order)
    if size > max_bytes:
        raise too_large(name, f"{MAX_BYTES // 1_000_000} MB when it is unpacked")
    body = stream.decompress(stream.unconsumed_tail, size) if size else b""
    beyond = stream.decompress(stream.unconsumed_tail, 1)  # reads the checksum at the end
    if len(body) != size or beyond or not stream.eof:
        raise _DamagedError
    return kind, memoryview(body)


def _tag(data: memoryview, at: int, order: str) -> tuple[int, int]:
    """Return data type and size [bytes] of the element whose tag is at a position in `data`.

    `at`: index of its first byte. `order`: byte order, "<" or ">".
    """
    if at + _TAG > len(data):
        raise _DamagedError
    kind, size = np.frombuffer(data, f"{order}u4", 2, at).tolist()
    return kind, size


@dataclass
class _Elements:
    """The elements of a matrix, read one after the other.

    `data`: bytes of the matrix. `order`: byte order, "<" or ">". `at`: index of the next element.
    """

    data: memoryview
    order: str
    at: int = 0

    def next(self) -> tuple[int, memoryview]:
        """Return data type and bytes of the next element, and move past it.

        Up to four bytes stand in the tag itself, whose upper half is then their number; elements
        other than matrices are padded to whole tags.
        """
        kind, size = _tag(self.data, self.at, self.order)
        begin, small = self.at + _TAG, kind >> 16
        if small:
            kind, size, begin = kind & 0xFFFF, small, begin - 4
        end = begin + size
        if small > 4 or end > len(self.data):
            raise _DamagedError
        padding = 4 - size if small else -size % _TAG
        self.at = end + (0 if kind == _MATRIX else padding)
        return kind, self.data[begin:end]

    def next_numbers(self) -> AnyArray:
        """Return the numbers of the next element, as they are stored."""
        kind, raw = self.next()
        if kind not in _NUMBER_TYPES:
            raise _DamagedError
        stored = np.dtype(self.order + _NUMBER_TYPES[kind])
        if len(raw) % stored.itemsize:
            raise _DamagedError
        return np.frombuffer(raw, stored)

    def next_integers(self) -> list[int]:
        """Return the next element as whole numbers; `_DamagedError` for a negative one."""
        integers = self.next_numbers()
        if integers.dtype.kind not in "iu" or np.any(integers < 0):
            raise _DamagedError
        return [int(entry) for entry in integers]

    def next_text(self) -> str:
        """Return the next element as a text."""
        kind, raw = self.next()
        if kind not in _TEXT_TYPES:
            raise _DamagedError
        return bytes(raw).decode("latin-1")


@dataclass(frozen=True)
class _Matrix:
    """A matrix: its class, shape and name, whether it is complex, and its further elements."""

    kind: int
    is_complex: bool
    shape: tuple[int, ...]
    name: str
    elements: _Elements

    @classmethod
    def of(cls, data: memoryview, order: str) -> _Matrix:
        """Return the matrix in the bytes of an element; `order`: byte order, "<" or ">".

        Its elements are the flags, the shape, the name, and further ones, which are not read here.
        """
        elements = _Elements(data, order)
        flags = elements.next_integers()
        if len(flags) != 2:
            raise _DamagedError
        kind = flags[0] & 0xFF  # the class of the matrix is in the lowest byte
        shape = () if kind == _OPAQUE else tuple(elements.next_integers())
        return cls(kind, bool(flags[0] & _COMPLEX), shape, _name(elements.next_text()), elements)

    def numbers(self) -> AnyArray | None:
        """Return its real numbers without axes of length one; None for any other class.

        They are stored by columns.
        """
        if self.kind not in _NUMBERS or self.is_complex:
            return None
        values = self.elements.next_numbers()
        if values.size != math.prod(self.shape):
            raise _DamagedError
        return values.reshape([n for n in self.shape if n != 1], order="F")

    def structure(self) -> dict[str, AnyArray] | None:
        """Return the fields of a single structure that are numbers; None for several in one."""
        if math.prod(self.shape) != 1:
            return None
        # the elements are the length of a name, all names, filled with zeros, and a matrix of each
        length, names = self.elements.next_integers(), self.elements.next_text()
        if len(length) != 1 or not length[0] or len(names) % length[0]:
            raise _DamagedError
        numeric = {}
        for at in range(0, len(names), length[0]):
            kind, data = self.elements.next()
            if kind != _MATRIX:
                raise _DamagedError
            numbers = _Matrix.of(data, self.elements.order).numbers() if len(data) else None
            if numbers is not None:
                numeric[_name(names[at : at + length[0]])] = numbers
        return numeric


def _name(text: str) -> str:
    """Return a text up to the zero that ends it, without what cannot be printed."""
    return "".join(letter for letter in text.partition("\0")[0] if letter.isprintable())
