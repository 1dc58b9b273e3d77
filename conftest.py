"""What pytest may not collect: compiled kernels without a compiler, flights without an engine."""

from importlib.util import find_spec

collect_ignore_glob = [
    *([] if find_spec("numba") else ["tvclin/kernels/compiled/*"]),
    *([] if find_spec("jsbsim") else ["tvclin/flight/sixdof/*", "docs/six-*"]),
]
