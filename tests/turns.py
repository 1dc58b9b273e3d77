"""Which cases of a claim a usual run takes, and which only a thorough one."""

import os
from collections.abc import Callable, Iterable
from itertools import product
from typing import Any

import pytest
from hypothesis import given, seed, settings

_THOROUGH = pytest.mark.thorough
_SEED = int(os.environ.get("TVCLIN_SEED", "0"))
"""Seed of fresh random cases; zero for the cases that are always the same."""


def seeds(*numbers: int) -> list[int]:
    """Return the seeds of a random case for numpy, with `TVCLIN_SEED` if that is set."""
    return [*numbers, _SEED] if _SEED else list(numbers)


def usual(cases: Iterable[Any], *places: int) -> list[Any]:
    """Return cases for `pytest.mark.parametrize`; those at other places are thorough."""
    return [
        pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=marks)
        for k, case in enumerate(cases)
        for marks in [() if k in places else _THOROUGH]
    ]


def by_turns(names: str, *values: Iterable[Any], each: int) -> pytest.MarkDecorator:
    """Parametrize with every combination, of which a usual run takes one in so many.

    It takes those whose places in the lists add up to a multiple of `each`: where two lists are at
    least so long, every value of every list is among them.
    """
    lists = [list(value) for value in values]
    places = list(product(*(range(len(one)) for one in lists)))
    taken = [k for k, at in enumerate(places) if sum(at) % each == 0]
    return pytest.mark.parametrize(names, usual(product(*lists), *taken))


def drawn(few: int, many: int, *strategies: Any, **options: Any) -> Callable[..., Any]:
    """Draw so many examples in a usual run, and so many in a thorough one.

    They are always the same, unless `TVCLIN_SEED` is set.
    """

    def draw(claim: Callable[..., None]) -> Callable[..., None]:
        @pytest.mark.parametrize("examples", usual([few, many], 0))
        def test(examples: int) -> None:
            request = {"max_examples": examples, "deadline": None, "derandomize": True} | options
            search = given(*strategies)(claim)
            settings(**request)(seed(_SEED)(search) if _SEED else search)()

        return test

    return draw
