"""What pytest may not collect where something is not installed."""

from importlib.util import find_spec

_NEEDED = {
    "numba": ["tvclin/kernels/compiled/*"],
    "jsbsim": ["tvclin/flight/sixdof/*", "docs/six-*"],
    "jinja2": ["tvclin/report/page.py", "docs/report.md"],
    "pyarrow": ["docs/campaigns.md", "tvclin/campaign/engine.py"],
}

collect_ignore_glob = [
    "docs/*.py",
    "docs/_*",
    *(pattern for module, some in _NEEDED.items() if not find_spec(module) for pattern in some),
]
