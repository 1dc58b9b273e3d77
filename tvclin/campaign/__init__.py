"""Many dispersed cases: drawn by their own index, computed together, judged with confidence.

The rooms inside: `draws` gives each case its random numbers, `dispersions` makes vehicles and
winds of them, `statistics` says what a sample proves, and `quick` answers for one study.
"""

from tvclin.campaign.dispersions import (
    DEFAULT_DISPERSIONS,
    Dispersed,
    Dispersion,
    Dispersions,
)
from tvclin.campaign.draws import draw
from tvclin.campaign.quick import DispersedStudy, disperse_study
from tvclin.campaign.statistics import (
    Quantile,
    Success,
    quantile_bound,
    sensitivities,
    success_probability,
    zero_failure_size,
)

__all__ = [
    "DEFAULT_DISPERSIONS",
    "Dispersed",
    "DispersedStudy",
    "Dispersion",
    "Dispersions",
    "Quantile",
    "Success",
    "disperse_study",
    "draw",
    "quantile_bound",
    "sensitivities",
    "success_probability",
    "zero_failure_size",
]
