"""One source for every kernel: plain Python and machine code of it say the same."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.turns import usual
from tvclin.kernels import choice, source
from tvclin.kernels.source import kernel, machine_code

pytestmark = pytest.mark.usefixtures("as_users_have_it")

GROWTH = 1.5


@kernel
def term(rate, u):
    return GROWTH * u * np.sqrt(rate) + u * u * u


@kernel
def total(values, rate):
    result = 0.0
    for i in range(values.size):
        result += term(rate, values[i])
    return result


def test_machine_code_rounds_like_plain_python():
    pytest.importorskip("numba")
    values = np.random.default_rng(3).normal(size=1000)
    assert machine_code(total)(values, 0.3) == total(values, 0.3)


def test_what_is_cached_has_another_name_when_a_constant_of_a_called_function_changes(monkeypatch):
    before = source.digest.__wrapped__(total)
    monkeypatch.setitem(term.__globals__, "GROWTH", 2.5)
    assert source.digest.__wrapped__(total) != before
    monkeypatch.setitem(term.__globals__, "GROWTH", 1.5)
    assert source.digest.__wrapped__(total) == before


def test_what_is_cached_has_another_name_when_a_called_function_changes(monkeypatch):
    before = source.digest.__wrapped__(total)
    monkeypatch.setitem(total.__globals__, "term", kernel(lambda rate, u: u - rate))
    assert source.digest.__wrapped__(total) != before


@pytest.mark.thorough
@pytest.mark.parametrize(
    "place", usual(["beside the source", "by NUMBA_CACHE_DIR", "with the user"], 0)
)
def test_machine_code_is_found_where_numba_keeps_it(tmp_path, place):
    pytest.importorskip("numba")
    rooms = tmp_path / "rooms"
    rooms.mkdir()
    (rooms / "kept.py").write_text(
        "from tvclin.kernels.source import kernel\n@kernel\ndef twice(x):\n    return x + x\n"
    )
    folders = {"XDG_CACHE_HOME": str(tmp_path / "mine"), "LOCALAPPDATA": str(tmp_path / "mine")}
    if place == "by NUMBA_CACHE_DIR":
        folders["NUMBA_CACHE_DIR"] = str(tmp_path / "numba")
    if place == "with the user":  # a file in its way keeps even an administrator out of the folder
        (rooms / "__pycache__").write_text("")
    code = (
        "import sys; sys.path.insert(0, sys.argv[1]); sys.dont_write_bytecode = True\n"
        "import kept\nfrom tvclin.kernels import choice\n"
        "before = choice._is_cached(kept.twice)\nassert 'numba' not in sys.modules\n"
        "choice.machine_code(kept.twice)(1.0)\n"
        "folder = choice.cache_folder(choice.Path(sys.argv[1]))\n"
        "print(before, choice._is_cached(kept.twice), folder)"
    )
    environment = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
    done = subprocess.run(
        [sys.executable, "-c", code, str(rooms)],
        env=environment | folders,
        capture_output=True,
        text=True,
        check=True,
    )
    before, after, folder = done.stdout.split(maxsplit=2)
    assert (before, after) == ("False", "True")
    inside = {"beside the source": rooms, "by NUMBA_CACHE_DIR": tmp_path / "numba"}
    if sys.platform != "darwin":
        assert folder.startswith(str(inside.get(place, tmp_path / "mine")))


_CACHED_FIRST = """
import sys, numpy as np
from tests.kernels.test_source import total
from tvclin.kernels.source import machine_code
values = np.random.default_rng(3).normal(size=100)
compiled = machine_code(total)
print(compiled(values, 0.3), "numba.np.arraymath" in sys.modules, len(compiled.stats.cache_hits))
print(compiled(values, 1), "numba.np.arraymath" in sys.modules, len(compiled.stats.cache_misses))
"""


@pytest.mark.thorough
def test_cached_machine_code_loads_no_compiler_and_another_signature_is_compiled(tmp_path):
    pytest.importorskip("numba")
    values = np.random.default_rng(3).normal(size=100)
    wanted = [str(total(values, rate)) for rate in (0.3, 1)]
    for cached in (False, True):
        done = subprocess.run(
            [sys.executable, "-c", _CACHED_FIRST],
            env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
            capture_output=True,
            text=True,
            check=True,
        )
        lines = [line.split() for line in done.stdout.splitlines()]
        assert [line[0] for line in lines] == wanted
        assert lines[0][1:] == [str(not cached), str(int(cached))]
        if not cached:  # only the first signature stays, so that the other is compiled anew
            _, second = sorted(tmp_path.rglob("*.nbc"), key=lambda file: file.stat().st_mtime)
            second.unlink()
        else:
            assert lines[1][1:] == ["True", "1"]


def test_a_process_with_the_code_in_another_place_pays_the_small_threshold(monkeypatch, tmp_path):
    """What was compiled before is taken for little work, wherever it is kept."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(choice, "available", lambda: True)
    monkeypatch.setattr(choice, "machine_code", lambda function: "machine code")
    assert choice.fastest(total, 1.0) is total
    folder = choice.cache_folder(Path(__file__).parent)
    folder.mkdir()
    (folder / f"{Path(__file__).stem}.total_{source.digest(total)}-18.py311.0.nbc").write_text("")
    assert choice.fastest(total, 1.0) == "machine code"


def test_machine_code_is_loaded_for_the_work_of_one_call(monkeypatch):
    monkeypatch.setattr(choice, "available", lambda: True)
    monkeypatch.setattr(choice, "machine_code", lambda function: "machine code")
    monkeypatch.setattr(choice, "_is_cached", lambda function: True)
    for _ in range(100):
        assert choice.fastest(total, 0.01) is total
    assert choice.fastest(total, 0.1) == "machine code"
