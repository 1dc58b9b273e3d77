"""One source for every kernel: plain Python and machine code of it say the same."""

import numpy as np
import pytest

from tvclin.kernels import source
from tvclin.kernels.source import kernel, machine_code

GROWTH = 1.5


@kernel
def term(rate, u):
    return GROWTH * u * np.sqrt(rate) + u * u * u


@kernel
def total(values, rate):
    found = 0.0
    for i in range(values.size):
        found += term(rate, values[i])
    return found


def test_machine_code_rounds_like_plain_python():
    pytest.importorskip("numba")
    values = np.random.default_rng(3).normal(size=1000)
    assert machine_code(total)(values, 0.3) == total(values, 0.3)


def test_what_is_kept_has_another_name_when_a_constant_of_a_called_function_changes(monkeypatch):
    before = source._digest(total)
    monkeypatch.setitem(term.__globals__, "GROWTH", 2.5)
    assert source._digest(total) != before
    monkeypatch.setitem(term.__globals__, "GROWTH", 1.5)
    assert source._digest(total) == before


def test_what_is_kept_has_another_name_when_a_called_function_changes(monkeypatch):
    before = source._digest(total)
    monkeypatch.setitem(total.__globals__, "term", kernel(lambda rate, u: u - rate))
    assert source._digest(total) != before
