"""Campaigns of dispersed cases, drawing and files included, beside a loop over the cases."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np
import pytest
from peers import PROCESSOR, ratio

import tvclin as tv
from tvclin.ensembles.dispersions import draw

CASES, FEW = 20 * 1024, 40


def plan(model: str) -> tv.Campaign:
    """The default campaign: two dead bands and the minimum."""
    return tv.Campaign(
        vehicle=tv.load_vehicle("configuration-i"),
        wind=tv.ShapedWind("triangular", peak=np.radians(5), duration=7.5),
        model=model,
        outputs=("required", "minimum"),
        dead_bands=(1.0, 0.5),
        cases=CASES,
    )


def one_by_one(campaign: tv.Campaign) -> Any:
    """What a user would write: draw, and ask for each case."""
    drawn = draw(campaign.seed, 0, FEW, len(campaign.dispersions.distributions))
    every = campaign.dispersions.apply(campaign.nominal, drawn).values
    found = []
    for k in range(FEW):
        given = {name: float(values[k]) for name, values in every.items()}
        wind = tv.TriangularWind(
            peak=given.pop("wind_peak", campaign.wind.peak),
            duration=given.pop("wind_duration", campaign.wind.duration),
        )
        plant = tv.Plant.from_vehicle(campaign.vehicle.replace(**given), campaign.model)
        limits = [tv.required_deflection(plant, wind, K).deflection for K in campaign.dead_bands]
        found.append((*limits, tv.optimum_deflection(plant, wind).certificate.dual))
    return found


@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
def test_the_default_campaign(benchmark: Any, tmp_path: Any, model: str) -> None:
    number = count()
    campaign = plan(model)
    ratio(
        benchmark,
        lambda: tv.run_campaign(campaign, tmp_path / str(next(number))),
        lambda: one_by_one(campaign),
        peer_name="required_deflection, called in a loop",
        per=CASES,
        peer_per=FEW,
        floor="boundaries; with drift a flight of the trim law",
    )


@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
def test_a_campaign_with_a_dead_band(benchmark: Any, tmp_path: Any, model: str) -> None:
    """10,000 cases of K = 0.5, each in its own wind angle and dynamic pressure."""
    number = count()
    campaign = replace(plan(model), cases=10_000, dead_bands=(0.5,), outputs=("required",))
    ratio(
        benchmark,
        lambda: tv.run_campaign(campaign, tmp_path / str(next(number))),
        lambda: one_by_one(campaign),
        peer_name="required_deflection and the minimum, called in a loop",
        per=10_000,
        peer_per=FEW,
        floor="both marches of each case in head and tail wind, and its dual",
        clock=PROCESSOR,
    )


def test_two_processes_beside_one(benchmark: Any, tmp_path: Any) -> None:
    """Each loads its own libraries and machine code, which the first round has done."""
    number = count()
    campaign = plan("fixed-path")

    def run(executor: Any) -> None:
        tv.run_campaign(campaign, tmp_path / str(next(number)), executor=executor)

    with ProcessPoolExecutor(2) as pool:
        ratio(
            benchmark,
            lambda: run(pool),
            lambda: run(None),
            peer_name="one process",
            per=CASES,
            peer_per=CASES,
            floor="files, and what the folder says",
        )
