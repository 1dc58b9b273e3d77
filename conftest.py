"""What pytest may not collect where something is missing, what is run first, what is thorough."""

import gc
from collections import defaultdict
from importlib.util import find_spec

import pytest

_NEEDED = {
    "numba": ["tvclin/kernels/code_cache.py"],
    "jsbsim": ["tvclin/flights/sixdof/*", "docs/six-*"],
    "jinja2": ["tvclin/show/report/page.py", "docs/report.md"],
    "latex2mathml": ["tvclin/show/report/page.py", "docs/report.md"],
    "pyarrow": ["docs/campaigns.md", "tvclin/ensembles/campaign/chunk_runner.py"],
}

collect_ignore_glob = [
    "docs/*.py",
    "docs/_*",
    *(pattern for module, some in _NEEDED.items() if not find_spec(module) for pattern in some),
]

COMPILING = ("test_response_cases.py", "test_flights.py", "test_switches.py")
"""Of tests/kernels: these compile most of the kernels, which all others then find compiled."""


QUICK_PAGES = ("README.md", "start.md", "how-a-number-is-made.md")
"""Of these a usual run runs the examples; other pages, whose claims have tests, are thorough."""


LONG_EXAMPLES = (
    *("gain_designs.py", "minimum_gains.py", "fly_planes.py", "flown_margins.py"),
    *("flown_trade_off.py", "dispersed_study.py", "page.py"),
)
"""Of tvclin: examples of these take more than half a second, and are thorough."""


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Collect without looking for garbage, of which there is next to none."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


def pytest_collection_modifyitems(items):
    """Run first what compiles; with a file to a worker nothing is compiled twice."""
    items.sort(key=lambda item: item.path.name not in COMPILING)
    for item in items:
        page = item.path.suffix == ".md" and item.path.name not in QUICK_PAGES
        if page or item.path.name in LONG_EXAMPLES:
            item.add_marker(pytest.mark.thorough)
    claims = defaultdict(list)
    for item in items:
        if hasattr(item, "callspec") and not item.get_closest_marker("thorough"):
            claims[item.parent, item.originalname].append(item)
    for cases in claims.values():
        for item in _repetitions(cases):
            item.add_marker(pytest.mark.thorough)


def _repetitions(cases):
    """Return those of all cases of a claim without which each value of each list is still shown.

    Of a product of lists about as many cases are left as the longest list has values.
    """
    values = {item: set(enumerate(item.callspec._idlist)) for item in cases}
    shown = set()
    while new := max(values.values(), key=lambda value: len(value - shown)) - shown:
        item = next(item for item, value in values.items() if value - shown == new)
        shown |= values.pop(item)
        if not values:
            break
    return values
