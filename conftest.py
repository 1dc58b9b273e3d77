"""What pytest may not collect where something is not installed, and what it runs first."""

from importlib.util import find_spec

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


def pytest_collection_modifyitems(items):
    """Run first what compiles; with a file to a worker nothing is compiled twice."""
    items.sort(key=lambda item: item.path.name not in COMPILING)
