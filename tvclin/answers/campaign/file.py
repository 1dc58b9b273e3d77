"""Campaign files: TOML in, a `Campaign` out, and back into the document that a manifest keeps."""

from collections.abc import Mapping
from dataclasses import fields
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.answers.campaign.dispersions import Dispersions
from tvclin.answers.campaign.flights import Flight
from tvclin.answers.campaign.keys import PERCENT, SUBJECT, Units, known, quantity, spellings
from tvclin.answers.campaign.plan import Campaign
from tvclin.answers.campaign.tables import (
    dispersions_of,
    question_of,
    read_tables,
    subject_of,
    winds_of,
)
from tvclin.answers.campaign.winds import WindEnsemble
from tvclin.base.errors import InputError, number, shown
from tvclin.base.errors import path as a_path
from tvclin.base.files import called
from tvclin.base.units import UNITS
from tvclin.vehicle.vehicle import Vehicle

_DRAWN = ("cases", "seed", "method", "chunk")
_FLIGHT: Units = {
    "deflection_limit": UNITS["angle"],
    "rate_limit": {f"{unit}_per_s": factor for unit, factor in UNITS["angle"].items()},
    "sample_rate": {"Hz": 1.0},
    "attitude_gain": {"": 1.0},
    "rate_gain": {"s": 1.0},
    "alpha_gain": {"": 1.0},
    "integral_gain": {"per_s": 1.0},
    "natural_frequency": {"rad_per_s": 1.0},
    "damping": {"": 1.0},
}


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
    try:
        return parse_campaign(document, file.parent)
    except InputError as error:
        raise InputError(f"{called(file)}: {error}") from None


def template() -> str:
    """Return a commented campaign file to fill in."""
    return files("tvclin.answers.campaign").joinpath("template.txt").read_text(encoding="utf-8")


def parse_campaign(document: Mapping[str, Any], folder: Path = Path()) -> Campaign:
    """Return the campaign of a document; see `load_campaign`."""
    subject = subject_of(document, folder)
    head, outputs = dict(document.get("campaign", {})), dict(document.get("outputs", {}))
    known("key in [campaign]", head, (*SUBJECT, *_DRAWN, "until_percent", "until_part"))
    known("key in [outputs]", outputs, ("names", "dead_bands"))
    if "gust" in document:
        raise InputError("a campaign has no gust; leave [gust] out")
    if "cases" not in head:
        raise InputError("a key is missing in [campaign]: cases")
    until = head.get("until_part")
    if "until_percent" in head:
        until = number("until_percent", head["until_percent"]) / PERCENT
    given: dict[str, Any] = {key: head[key] for key in _DRAWN if key in head}
    for key, field in (("names", "outputs"), ("dead_bands", "dead_bands")):
        if key in outputs:
            if not isinstance(outputs[key], list):
                raise InputError(f"{key} in [outputs] must be a list; got {shown(outputs[key])}")
            given[field] = tuple(outputs[key])
    return Campaign(
        wind=winds_of(document, folder)[0],
        dispersions=dispersions_of(document.get("dispersion", []), document.get("correlation", [])),
        flight=_flight(dict(document["flight"])) if "flight" in document else None,
        until=until,
        **subject,
        **given,
        **question_of(document),
    )


def document_of(campaign: Campaign) -> dict[str, Any]:
    """Return the document of a campaign, in SI units and complete in itself.

    `parse_campaign` makes the same campaign of it.
    """
    vehicle, until = campaign.vehicle, campaign.until
    head = {key: getattr(campaign, key) for key in ("model", "plane", *_DRAWN)} | {
        "vehicle": {
            f.name: getattr(vehicle, f.name)
            for f in fields(Vehicle)
            if getattr(vehicle, f.name) is not None
        }
    }
    wind = campaign.wind
    question = {"probability": campaign.probability, "confidence": campaign.confidence}
    flown = {} if campaign.flight is None else {"flight": _flight_table(campaign.flight)}
    return flown | {
        "campaign": head | ({} if until is None else {"until_part": until}),
        "wind": {"time_s": wind.time.tolist(), "angle_rad": wind.angle.tolist()}
        if isinstance(wind, WindEnsemble)
        else {"shape": wind.shape, "peak_rad": wind.peak, "duration_s": wind.duration},
        "outputs": {"names": list(campaign.outputs), "dead_bands": list(campaign.dead_bands)},
        "question": question | ({} if campaign.limit is None else {"limit_rad": campaign.limit}),
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


def _flight(table: dict[str, Any]) -> Flight:
    law = table.pop("law", "autopilot")
    given: dict[str, Any] = {}
    for name, units in _FLIGHT.items():
        value = quantity("[flight]", table, name, units, required=name == "deflection_limit")
        if value is not None:
            given[name] = value
    known("key in [flight]", table, ("law", *spellings(_FLIGHT)))
    return Flight(law=law, **given)


def _flight_table(flight: Flight) -> dict[str, Any]:
    return {"law": flight.law} | {
        key: getattr(flight, name)
        for name, units in _FLIGHT.items()
        for key in spellings({name: units})[:1]
        if getattr(flight, name) is not None and np.isfinite(getattr(flight, name))
    }


def _pairs(dispersions: Dispersions) -> list[dict[str, Any]]:
    matrix, names = dispersions.correlation or (), dispersions.parameters
    return [
        {"between": [names[i], names[j]], "coefficient": row[j]}
        for i, row in enumerate(matrix)
        for j in range(i)
        if row[j]
    ]
