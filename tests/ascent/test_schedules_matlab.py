"""Files of MATLAB: the numbers that scipy reads, and one sentence for whatever is damaged."""

import struct
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat, savemat
from scipy.sparse import csc_matrix

import tvclin as tv
from tests.turns import usual
from tvclin.ascent.importers.matlab_file import MAX_NUMBERS, read_matlab
from tvclin.base.files import MAX_BYTES

WHOLE = ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8")
VARIABLES = {
    **{name: np.array([1, 2, 100], dtype=name) for name in WHOLE},
    "double": np.linspace(-1.0, 1.0, 7),
    "single": np.array([0.5, 0.1], dtype=np.float32),
    "one": 3.25,
    "flags": np.array([True, False]),
    "matrix": np.arange(6.0).reshape(2, 3),
    "cube": np.arange(24.0).reshape(2, 3, 4),
    "a_name_longer_than_one_tag": np.arange(4.0),
    "record": {"time_s": np.arange(3.0), "a": 1, "called": "a text", "inner": {"n": 1.0}},
}
OTHERS = {
    "text": "a text",
    "cells": np.array(["a", 1.0], dtype=object),
    "complex": np.array([1.0 + 2.0j]),
    "sparse": csc_matrix(np.eye(3)),
}
"""Of classes that hold no column of a log."""


@pytest.mark.parametrize("packed", [False, True])
def test_numbers_are_those_that_scipy_reads(tmp_path: Path, packed: bool) -> None:
    savemat(file := tmp_path / "log.mat", VARIABLES | OTHERS, do_compression=packed)
    computed, theirs = read_matlab(file), loadmat(file, squeeze_me=True)
    assert list(computed) == [*VARIABLES, *OTHERS]
    assert all(computed[name] is None for name in OTHERS)
    record = computed.pop("record")
    assert sorted(record) == ["a", "time_s"]
    for name, values in record.items():
        np.testing.assert_array_equal(values, theirs["record"][name].item())
    for name in VARIABLES.keys() - {"record"}:
        np.testing.assert_array_equal(computed[name], np.asarray(theirs[name]), name, strict=True)


def element(order: str, kind: int, content: bytes) -> bytes:
    """An element with its tag, padded to eight bytes."""
    return struct.pack(f"{order}II", kind, len(content)) + content + bytes(-len(content) % 8)


def vector(order: str, name: str, values: list[float]) -> bytes:
    """The matrix of a vector of doubles."""
    flags = element(order, 6, struct.pack(f"{order}II", 6, 0))
    shape = element(order, 5, struct.pack(f"{order}ii", 1, len(values)))
    numbers = element(order, 9, struct.pack(f"{order}{len(values)}d", *values))
    return element(order, 14, flags + shape + element(order, 1, name.encode()) + numbers)


@pytest.mark.parametrize(("order", "mark"), [("<", b"\0\1IM"), (">", b"\1\0MI")])
def test_a_file_of_either_byte_order_is_read(tmp_path: Path, order: str, mark: bytes) -> None:
    file, values = tmp_path / "log.mat", [2.0, 3.5, -4.25]
    file.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + mark + vector(order, "time_s", values))
    assert read_matlab(file)["time_s"].tolist() == values


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("each", usual([61, 1], 0))
def test_any_flipped_bit_is_read_or_told_in_one_sentence(
    tmp_path: Path, packed: bool, each: int
) -> None:
    """Types and sizes among them, of which scipy believes each; what is packed has a checksum."""
    savemat(file := tmp_path / "log.mat", VARIABLES | OTHERS, do_compression=packed)
    good, begin, refused = file.read_bytes(), 128, 0
    before = {name: str(value) for name, value in read_matlab(file).items()}
    for at in range(8 * begin, 8 * len(good), each):
        bad = bytearray(good)
        bad[at // 8] ^= 1 << (at % 8)
        file.write_bytes(bad)
        try:
            result = read_matlab(file)
        except tv.InputError:
            refused += 1
            continue
        assert not packed or {name: str(value) for name, value in result.items()} == before
    assert refused > (0.95 if packed else 0.4) * 8 * (len(good) - begin) / each


@pytest.mark.parametrize("kind", [0, 8, 10, 11, 200, 0xFFFF])
def test_an_unknown_type_of_numbers_is_refused(tmp_path: Path, kind: int) -> None:
    """Such a byte ended the interpreter."""
    file, name = tmp_path / "log.mat", b"time_s"
    savemat(file, {"time_s": np.arange(7.0)})
    content = bytearray(file.read_bytes())
    at = content.index(name) + 8
    assert content[at] == 9  # double
    content[at : at + 4] = struct.pack("<I", kind)
    file.write_bytes(content)
    with pytest.raises(tv.InputError, match=r"log.mat is not a \.mat file of version 5 that can"):
        tv.ascent.read_log(file)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("count", "most", "words"),
    [
        (MAX_BYTES, 1e6, "more than 100 MB when it is unpacked"),
        (2 * MAX_NUMBERS, 4.5 * MAX_NUMBERS, "more than 5 million numbers"),
    ],
)
def test_what_unpacks_to_more_than_a_text_may_hold_is_not_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, count: int, most: float, words: str
) -> None:
    """The second is unpacked as it is stored, a byte for each, through a buffer of its size."""
    savemat(file := tmp_path / "log.mat", {"time_s": np.zeros(count, "u1")}, do_compression=True)
    packed = file.read_bytes()
    assert len(packed) < MAX_BYTES / 500
    monkeypatch.setattr("tvclin.ascent.importers.matlab_file.read_bytes", lambda *_: packed)
    tracemalloc.start()
    try:
        with pytest.raises(tv.InputError, match=words):
            tv.ascent.read_log(file)
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()


def test_numbers_that_stand_for_a_whole_column_count_as_one(tmp_path: Path) -> None:
    rows, columns = 10_000, MAX_NUMBERS // 10_000
    single = {f"x{k}": 1.0 for k in range(columns)}
    savemat(file := tmp_path / "log.mat", {"time_s": np.arange(rows)} | single)
    with pytest.raises(tv.InputError, match=r"log.mat holds more than 5 million numbers; save the"):
        tv.ascent.read_log(file)


def test_a_newer_version_says_how_to_save_it(tmp_path: Path) -> None:
    file = tmp_path / "log.mat"
    file.write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM" + b"\x89HDF")
    with pytest.raises(tv.InputError, match=r"of version 7\.3; save it in MATLAB with -v7$"):
        tv.ascent.read_log(file)


def test_no_file_is_told_as_of_a_text(tmp_path: Path) -> None:
    with pytest.raises(tv.InputError, match=r"log.mat does not exist$"):
        tv.ascent.read_log(tmp_path / "log.mat")
    (tmp_path / "log.mat").mkdir()
    with pytest.raises(tv.InputError, match=r"is a directory; name the log of a simulation in it"):
        tv.ascent.read_log(tmp_path / "log.mat")
