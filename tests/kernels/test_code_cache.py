"""Machine code on disk: nothing runs but what was written, and no answer waits for a disk."""

import pickle
from contextlib import contextmanager

import numpy as np
import pytest

from tests.kernels.test_source import total
from tests.turns import usual
from tvclin.kernels import source

numba = pytest.importorskip("numba")

VALUES = np.random.default_rng(3).normal(size=100)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Keep machine code in an empty folder."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    return tmp_path


def as_another_process():
    """Return the machine code of a kernel as a process gets it that has none yet."""
    return source.machine_code.__wrapped__(total)


def compiled_anew(kernel):
    return sum(kernel.stats.cache_misses.values()) > 0 or not kernel.stats.cache_hits


def kept(folder):
    (file,) = folder.rglob("*.nbc")
    return file


def flip(content, at):
    flipped = bytes(255 - one for one in content[at : at + 32])
    return content[:at] + flipped + content[at + 32 :]


DAMAGE = {
    "empty": lambda content: b"",
    "cut in its hash": lambda content: content[:20],
    "without its last byte": lambda content: content[:-1],
    "cut in the middle": lambda content: content[: len(content) // 2],
    "another hash": lambda content: flip(content, 0),
    "bits in the middle": lambda content: flip(content, len(content) // 2),
    "bits at the end": lambda content: flip(content, len(content) - 32),
    "zeros": lambda content: bytes(len(content)),
}


@pytest.mark.thorough
@pytest.mark.parametrize("damage", usual(DAMAGE, 0, 3))
def test_damaged_machine_code_is_told_of_once_and_compiled_anew(folder, damage):
    wanted = as_another_process()(VALUES, 0.3)
    whole = kept(folder).read_bytes()
    kept(folder).write_bytes(DAMAGE[damage](whole))
    with pytest.warns(UserWarning, match=r"\.nbc is damaged; this machine code is compiled anew"):
        assert as_another_process()(VALUES, 0.3) == wanted
    mended = as_another_process()
    assert mended(VALUES, 0.3) == wanted
    assert not compiled_anew(mended)


def test_what_is_cached_is_one_file_for_each_signature(folder):
    first = as_another_process()
    first(VALUES, 0.3)
    first(VALUES, 1)
    assert len(list(folder.rglob("*"))) == 3  # with the folder of the sources
    second = as_another_process()
    assert (first(VALUES, 0.3), first(VALUES, 1)) == (second(VALUES, 0.3), second(VALUES, 1))
    assert not compiled_anew(second)


def test_of_the_bitcode_only_the_names_of_functions_are_written(folder):
    """Their bodies, and environments of called functions, serve to compile further ones alone."""
    kernel = as_another_process()
    kernel(VALUES, 0.3)
    digest = 32
    (_, _, (_, bitcode)), *_, environments = pickle.loads(kept(folder).read_bytes()[digest:])
    functions = list(pytest.importorskip("llvmlite.binding").parse_bitcode(bitcode).functions)
    assert any("total" in function.name for function in functions)
    assert all(sum(1 for block in f.blocks for _ in block.instructions) == 1 for f in functions)
    assert environments == ()


@contextmanager
def full_disk():
    """Let no file grow beyond 64 bytes: what is written fails, as on a disk that is full."""
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (64, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_loses_no_answer_and_leaves_nothing_half_written(folder):
    kernel = as_another_process()
    said = "cannot be written: .*; this machine code is compiled anew in each process"
    with full_disk(), pytest.warns(UserWarning, match=said):
        result = kernel(VALUES, 0.3)
    assert result == total(VALUES, 0.3)
    assert not [file for file in folder.rglob("*") if file.is_file()]


def test_where_a_file_is_a_folder_machine_code_stays_in_memory(folder):
    wanted = as_another_process()(VALUES, 0.3)
    file = kept(folder)
    file.unlink()
    file.mkdir()
    with pytest.warns(UserWarning, match="is a directory.*compiled anew in each process"):
        assert as_another_process()(VALUES, 0.3) == wanted
