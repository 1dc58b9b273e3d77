"""What pytest may not collect: compiled kernels where there is no compiler."""

from importlib.util import find_spec

collect_ignore_glob = [] if find_spec("numba") else ["tvclin/kernels/compiled/*"]
