"""The tables of a study file: from a document to its plan."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tvclin.answers.campaign.file import parse_campaign
from tvclin.answers.campaign.keys import quantities_of
from tvclin.answers.campaign.tables import dispersions_of, question_of, subject_of, winds_of
from tvclin.answers.study_file.plan import GainsAsked, LawsAsked, StudyPlan
from tvclin.answers.study_file.read_sizing import gust_of, sizing_of
from tvclin.base.errors import InputError, one_of, shown
from tvclin.control.margins.criteria import CRITERIA, Criteria

_ALSO_OF_A_FLIGHT = ("model", "plane")


def parse_study(document: Mapping[str, Any], folder: Path = Path()) -> StudyPlan:
    """Return the plan of a document; see `load_study`.

    A campaign that stands in it as well is checked too.
    """
    subject = subject_of(document, folder)
    if "cases" in document.get("campaign", {}):
        parse_campaign({k: v for k, v in document.items() if k != "gust"}, folder)
    head, drawn = document.get("study", {}), document.get("campaign", {})
    given = {key: head[key] for key in ("dead_band", "switch") if key in head}
    given |= {key: drawn[key] for key in ("cases", "seed") if key in drawn}
    if "dispersion" in document:
        rows = document["dispersion"], document.get("correlation", [])
        given["dispersions"] = dispersions_of(*rows)
    wind: Any = winds_of(document, folder)[0]
    gust = gust_of(document, float(getattr(wind, "duration", 0.0)))
    question = question_of(document)
    study = {key: value for key, value in (subject | given).items() if key in _ALSO_OF_A_FLIGHT}
    return StudyPlan(
        **subject,
        wind=wind,
        gust=gust,
        sizing=sizing_of(document, folder, gust, limit=question["limit"], **study),
        laws=_laws(dict(document["laws"])) if "laws" in document else None,
        gains=_gains(dict(document["autopilot"])) if "autopilot" in document else None,
        criteria=_criteria(dict(document["criteria"])) if "criteria" in document else None,
        **question,
        **given,
    )


def _laws(table: dict[str, Any]) -> LawsAsked:
    given: dict[str, Any] = quantities_of("laws", table) | table
    for key in ("names", "winds"):
        if key in given:
            if not isinstance(given[key], list):
                raise InputError(f"{key} in [laws] must be a list; got {shown(given[key])}")
            given[key] = tuple(given[key])
    return LawsAsked(**given)


def _gains(table: dict[str, Any]) -> GainsAsked:
    given: dict[str, Any] = quantities_of("autopilot", table) | table
    return GainsAsked(**given)


def _criteria(table: dict[str, Any]) -> Criteria:
    limits = quantities_of("criteria", table)
    if "name" in table:
        named = CRITERIA[one_of("name in [criteria]", table["name"], CRITERIA)]
        if not limits:
            return named
        limits = {one.margin: one.limit for one in named.requirements} | limits
    name = f"{table['name']} as changed" if "name" in table else "own"
    return Criteria.own(name, "the study file", **limits)
