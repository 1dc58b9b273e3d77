"""Campaign files: TOML in, a `Campaign` out."""

from collections.abc import Mapping
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.answers.campaign.plan import CAMPAIGN_TABLE, OUTPUTS_TABLE, Campaign
from tvclin.answers.campaign.tables import (
    design_of,
    dispersions_of,
    nozzle_of,
    question_of,
    read_tables,
    subject_of,
)
from tvclin.base.errors import naming
from tvclin.base.errors import path as a_path
from tvclin.base.files import called
from tvclin.winds.file import winds_of, with_gust
from tvclin.winds.shaped import ShapedWind

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
        offered), and as `Campaign`. One sentence says which and how to mend it.
    """
    file = a_path("path", path)
    document = read_tables(file, "write a campaign file with: tvclin campaign init")
    with naming(called(file)):
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
    wind = with_gust(document, wind, vehicle, plane)
    nozzle = nozzle_of(document)
    if isinstance(wind, ShapedWind) and nozzle.stop is None:
        wind = wind.in_plane(plane, float(np.mean(vehicle.attitude)))
    return Campaign(
        nozzle=nozzle,
        design=design_of(document),
        wind=wind,
        dispersions=dispersions_of(document),
        **(head | subject),
        **{_FIELDS.get(key, key): value for key, value in outputs.items()},
        **question_of(document),
    )
