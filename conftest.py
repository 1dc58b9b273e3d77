"""What pytest may not collect where something is missing, what is run first, what is thorough."""

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


def pytest_collection_modifyitems(items):
    """Run first what compiles; with a file to a worker nothing is compiled twice."""
    items.sort(key=lambda item: item.path.name not in COMPILING)
    for item in items:
        if item.path.suffix == ".md" and item.path.name not in QUICK_PAGES:
            item.add_marker(pytest.mark.thorough)
