"""Which cases of a product a usual run takes, and which only a thorough one."""

from itertools import product
from typing import Any

import pytest


def by_turns(names: str, *values: Any, each: int) -> pytest.MarkDecorator:
    """Parametrize with every combination; of `each` in turn, all but the first are thorough.

    Those are left whose places in the lists add up to a multiple of `each`: with two lists of at
    least so many values, every value of every list is among them.
    """
    cases = []
    for places in product(*(range(len(list_)) for list_ in values)):
        marks = [pytest.mark.thorough] if sum(places) % each else []
        case = [list_[place] for list_, place in zip(values, places, strict=True)]
        cases.append(pytest.param(*case, marks=marks))
    return pytest.mark.parametrize(names, cases)
