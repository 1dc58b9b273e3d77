"""Campaign files: TOML in, a `Campaign` out, and back into the document that a manifest keeps."""

from collections.abc import Mapping
from dataclasses import replace
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.answers.campaign.dispersions import Dispersions
from tvclin.answers.campaign.plan import CAMPAIGN_TABLE, OUTPUTS_TABLE, Campaign
from tvclin.answers.campaign.structures import gust_record, record_of, recorded_gust
from tvclin.answers.campaign.tables import (
    design_of,
    dispersions_of,
    nozzle_of,
    question_of,
    read_tables,
    subject_of,
)
from tvclin.base.errors import InputError, naming
from tvclin.base.errors import path as a_path
from tvclin.base.files import called
from tvclin.winds.file import winds_of, with_gust
from tvclin.winds.shaped import ShapedWind, WindEnsemble

_DRAWN = ("cases", "seed", "method", "chunk")
_FIELDS = {"names": "outputs"}
"""Fields of `Campaign` of another name than their keys."""


def load_campaign(path: str | PathLike[str]) -> Campaign:
    """Return the campaign that a TOML file describes.

    Parameters
    ----------
    path : str or path
        The file; the paths in it are relative to its folder. `template` shows one.

    Raises
    ------
    InputError
        For a file that cannot be read, is not TOML, or has an unknown key (the near ones are
        offered), and as `Campaign`. One sentence says which and how to mend it. Also for a stop of
        both planes.
    """
    file = a_path("path", path)
    document = read_tables(file, "write a campaign file with: tvclin campaign init")
    with naming(called(file)):
        if nozzle_of(document).stop is not None:
            raise InputError(
                "a campaign judges one plane: leave stop out of [nozzle], or ask tvclin study,"
                " which judges both with one stop"
            )
        return parse_campaign(document, file.parent)


def template() -> str:
    """Return a commented campaign file to fill in."""
    return files("tvclin.answers.campaign").joinpath("template.txt").read_text(encoding="utf-8")


def parse_campaign(document: Mapping[str, Any], folder: Path = Path()) -> Campaign:
    """Return the campaign of a document; see `load_campaign`."""
    subject = subject_of(document, folder)
    head = CAMPAIGN_TABLE.read(CAMPAIGN_TABLE.one(document))
    outputs = OUTPUTS_TABLE.read(OUTPUTS_TABLE.one(document))
    CAMPAIGN_TABLE.need(head, ["cases"])
    wind = winds_of(document, folder)[0]
    vehicle, plane = subject["vehicle"], subject.get("plane", "pitch")
    if kept := recorded_gust(document):
        wind = replace(wind, **kept)
    else:
        wind = with_gust(document, wind, vehicle, plane)
    if isinstance(wind, ShapedWind):
        wind = wind.in_plane(plane, float(np.mean(vehicle.attitude)))
    return Campaign(
        nozzle=replace(nozzle_of(document), stop=None),
        design=design_of(document),
        wind=wind,
        dispersions=dispersions_of(document),
        **(head | subject),
        **{_FIELDS.get(key, key): value for key, value in outputs.items()},
        **question_of(document),
    )


def document_of(campaign: Campaign) -> dict[str, Any]:
    """Return the document of a campaign, in SI units and complete in itself.

    `parse_campaign` makes the same campaign of it.
    """
    vehicle, until = campaign.vehicle, campaign.until
    head = {key: getattr(campaign, key) for key in ("model", "plane", *_DRAWN)} | {
        "vehicle": {k: v for k, v in record_of(vehicle).items() if v is not None}
    }
    wind = campaign.wind
    design = {} if campaign.design is None else {"autopilot": record_of(campaign.design)}
    head |= {} if campaign.sign is None else {"sign": campaign.sign}
    return design | {
        "nozzle": record_of(campaign.nozzle),
        "campaign": head | ({} if until is None else {"until_part": until}),
        "wind": {"time_s": wind.time.tolist(), "angle_rad": wind.angle.tolist()}
        if isinstance(wind, WindEnsemble)
        else {"shape": wind.shape, "peak_rad": wind.peak, "duration_s": wind.duration},
        **gust_record(wind),
        "outputs": {
            "names": list(campaign.outputs),
            "dead_bands": list(campaign.dead_bands),
            "law": campaign.law,
        },
        "question": {"probability": campaign.probability, "confidence": campaign.confidence},
        "dispersion": [
            {
                "parameter": one.parameter,
                "shape": one.shape,
                ("part" if one.relative else "spread"): one.spread,
            }
            for one in campaign.dispersions.each
        ],
        "correlation": _pairs(campaign.dispersions),
    }


def _pairs(dispersions: Dispersions) -> list[dict[str, Any]]:
    matrix, names = dispersions.correlation or (), dispersions.parameters
    return [
        {"between": [names[i], names[j]], "coefficient": row[j]}
        for i, row in enumerate(matrix)
        for j in range(i)
        if row[j]
    ]
