"""What pytest may not collect where something is not installed."""

from importlib.util import find_spec

_NEEDED = {
    "jsbsim": ["tvclin/flights/sixdof/*", "docs/six-*"],
    "jinja2": ["tvclin/show/report/page.py", "docs/report.md"],
    "latex2mathml": ["tvclin/show/report/page.py", "docs/report.md"],
    "pyarrow": ["docs/campaigns.md", "tvclin/answers/campaign/engine.py"],
}

collect_ignore_glob = [
    "docs/*.py",
    "docs/_*",
    *(pattern for module, some in _NEEDED.items() if not find_spec(module) for pattern in some),
]
