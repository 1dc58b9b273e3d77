"""Many dispersed cases: drawn by their own index, computed together, judged with confidence.

The rooms inside: `draws` gives each case its random numbers, `dispersions` makes vehicles and
winds of them, `statistics` says what a sample proves, and `quick` answers for one study.

For many cases: `file` reads a `plan`, with its `winds`, from `tables` with their `keys`; `cases`
makes vehicles of random numbers and `outputs` (with `forecast` and `flights`) the answers;
`manifest` seals the plan, `chunks` are its files, `engine` runs them on `executors`, `results`
reads them, and `replay` shows one case.
"""

from tvclin.campaign.chunks import run_chunk
from tvclin.campaign.dispersions import (
    DEFAULT_DISPERSIONS,
    Dispersed,
    Dispersion,
    Dispersions,
)
from tvclin.campaign.draws import draw
from tvclin.campaign.engine import open_campaign, resume_campaign, run_campaign
from tvclin.campaign.file import load_campaign
from tvclin.campaign.flights import Flight
from tvclin.campaign.plan import Campaign
from tvclin.campaign.quick import DispersedStudy, disperse_study
from tvclin.campaign.replay import Replay, replay_case
from tvclin.campaign.results import CampaignResults
from tvclin.campaign.statistics import (
    Driver,
    Quantile,
    Success,
    loss_drivers,
    quantile_bound,
    sensitivities,
    success_probability,
    zero_failure_size,
)
from tvclin.campaign.winds import ShapedWind, WindEnsemble

__all__ = [
    "DEFAULT_DISPERSIONS",
    "Campaign",
    "CampaignResults",
    "Dispersed",
    "DispersedStudy",
    "Dispersion",
    "Dispersions",
    "Driver",
    "Flight",
    "Quantile",
    "Replay",
    "ShapedWind",
    "Success",
    "WindEnsemble",
    "disperse_study",
    "draw",
    "load_campaign",
    "loss_drivers",
    "open_campaign",
    "quantile_bound",
    "replay_case",
    "resume_campaign",
    "run_campaign",
    "run_chunk",
    "sensitivities",
    "success_probability",
    "zero_failure_size",
]
