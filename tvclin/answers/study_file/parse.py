"""The tables of a study file: from a document to its plan."""

from collections.abc import Callable, Mapping
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
from tvclin.answers.document import DOCUMENT_TABLE, Document
from tvclin.answers.load import LOAD_TABLE, LoadBound
from tvclin.answers.study_file.plan import StudyPlan
from tvclin.answers.study_file.read_sizing import availability_of, sizing_of
from tvclin.answers.trials import LAWS_TABLE, LawsAsked
from tvclin.base.errors import Faults, one_of
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
    parts: dict[str, Callable[[], Any]] = {
        "wind": lambda: _wind(document, folder, subject),
        "sizing": lambda: sizing_of(document, folder),
        "availability": lambda: availability_of(document, folder),
        "laws": lambda: LAWS_TABLE.made(document, lambda one: LawsAsked(**LAWS_TABLE.read(one))),
        "nozzle": lambda: nozzle_of(document),
        "load": lambda: LOAD_TABLE.made(document, lambda one: LoadBound(**LOAD_TABLE.read(one))),
        "design": lambda: design_of(document),
        "criteria": lambda: CRITERIA_TABLE.made(document, _criteria),
        "document": lambda: DOCUMENT_TABLE.made(document, Document.from_table),
    }
    if "dispersion" in document:
        parts["dispersions"] = lambda: dispersions_of(document)
    faults, found = Faults(), {}
    for name, make in parts.items():
        with faults.kept():
            found[name] = make()
    faults.tell()
    return StudyPlan(**subject, **found, **question_of(document), **given)


def _wind(document: Mapping[str, Any], folder: Path, subject: Mapping[str, Any]) -> Any:
    """Return the wind of a study, with its gust."""
    wind, plane = winds_of(document, folder)[0], subject.get("plane", "pitch")
    return with_gust(document, wind, subject["vehicle"], plane)


def _criteria(table: dict[str, Any]) -> Criteria:
    limits = CRITERIA_TABLE.read(table)
    name = limits.pop("name", None)
    if name is None:
        return Criteria.own("own", "the study file", **limits)
    named = CRITERIA[one_of("name in [criteria]", name, CRITERIA)]
    return named.changed("the study file", **limits)
