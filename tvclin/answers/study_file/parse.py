"""The tables of a study file: from a document to its plan."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tvclin.answers.campaign.file import parse_campaign
from tvclin.answers.campaign.tables import (
    design_of,
    dispersions_of,
    nozzle_of,
    question_of,
    subject_of,
)
from tvclin.answers.document import Document
from tvclin.answers.load import LOAD_TABLE, LoadBound
from tvclin.answers.study_file.plan import StudyPlan
from tvclin.answers.study_file.read_sizing import availability_of, sizing_of
from tvclin.answers.trials import LAWS_TABLE, LawsAsked
from tvclin.base.errors import one_of
from tvclin.control.margins.criteria import CRITERIA, CRITERIA_TABLE, Criteria
from tvclin.winds.file import winds_of, with_gust


def parse_study(document: Mapping[str, Any], folder: Path = Path()) -> StudyPlan:
    """Return the plan of a document; see `load_study`.

    A campaign that stands in it as well is checked too.
    """
    subject = subject_of(document, folder)
    if "cases" in document.get("campaign", {}):
        parse_campaign(document, folder)
    head, drawn = document.get("study", {}), document.get("campaign", {})
    given = {key: head[key] for key in ("dead_band", "switch") if key in head}
    given |= {key: drawn[key] for key in ("cases", "seed") if key in drawn}
    if "dispersion" in document:
        given["dispersions"] = dispersions_of(document)
    plane = subject.get("plane", "pitch")
    wind: Any = with_gust(document, winds_of(document, folder)[0], subject["vehicle"], plane)
    question = question_of(document)
    return StudyPlan(
        **subject,
        wind=wind,
        sizing=sizing_of(document, folder),
        availability=availability_of(document, folder),
        laws=LawsAsked(**LAWS_TABLE.read(document["laws"])) if "laws" in document else None,
        nozzle=nozzle_of(document),
        load=LoadBound(**LOAD_TABLE.read(document["load"])) if "load" in document else None,
        design=design_of(document),
        criteria=_criteria(document["criteria"]) if "criteria" in document else None,
        document=Document.from_table(document["document"]) if "document" in document else None,
        **question,
        **given,
    )


def _criteria(table: dict[str, Any]) -> Criteria:
    limits = CRITERIA_TABLE.read(table)
    name = limits.pop("name", None)
    if name is None:
        return Criteria.own("own", "the study file", **limits)
    named = CRITERIA[one_of("name in [criteria]", name, CRITERIA)]
    return named.changed("the study file", **limits)
