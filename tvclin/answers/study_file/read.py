"""Study files: TOML in, a `StudyPlan` out."""

from collections.abc import Mapping
from dataclasses import replace
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any

from tvclin.answers.campaign.file import parse_campaign
from tvclin.answers.campaign.keys import quantities_of
from tvclin.answers.campaign.tables import dispersions_of, question_of, subject_of, winds_of
from tvclin.answers.sizing.schedule_file import load_schedule
from tvclin.answers.study_file.plan import DEFAULT_WIND, GainsAsked, LawsAsked, StudyPlan
from tvclin.answers.study_file.read_sizing import gust_of, sizing_of
from tvclin.answers.study_file.sizing import SizingAsked, SoundingAsked
from tvclin.base.errors import InputError, instance, one_of, path, shown
from tvclin.base.files import called, tables_of
from tvclin.control.margins.criteria import CRITERIA, Criteria
from tvclin.vehicle.file import parse_vehicle, vehicle_text

_ALSO_OF_A_FLIGHT = ("model", "plane")


def load_study(source: str | PathLike[str]) -> StudyPlan:
    """Return what a study file asks for, or a plan with nothing but a vehicle.

    Parameters
    ----------
    source : str or path
        A study file, a campaign file, a vehicle file, or the name of a vehicle of the package.
        The paths in a study file are relative to its folder; `tvclin init --study` writes one.

    Raises
    ------
    InputError
        For a file that cannot be read, is not TOML, or has an unknown key (the near ones are
        offered), and as `StudyPlan`. One sentence says which and how to mend it.

    Examples
    --------
    >>> import tvclin as tv
    >>> plan = tv.load_study("configuration-i")
    >>> plan.wind.shape, plan.limit
    ('triangular', None)
    """
    text, name = vehicle_text(source)
    document = tables_of(text, name)
    if "vehicle" in document and not {"study", "campaign"} & document.keys():
        return StudyPlan(vehicle=parse_vehicle(text, name))
    try:
        return parse_study(document, Path(name).parent)
    except InputError as error:
        raise InputError(f"{called(name)}: {error}") from None


def load_sizing(
    source: str | PathLike[str], soundings: Mapping[str, SoundingAsked] | None = None
) -> SizingAsked:
    """Return what is asked of a flight: by a study file, or a schedule or vehicle with defaults.

    Parameters
    ----------
    source : str or path
        A study file with [schedule], or what `load_schedule` makes a schedule of.
    soundings : dict of str to SoundingAsked, optional
        Winds over height, beside those of a study file. Where neither gives a wind it is a triangle
        of 5 degrees for 7.5 seconds.

    Raises
    ------
    InputError
        For a study file without [schedule], and as `load_study` and `load_schedule`.

    Examples
    --------
    >>> import tvclin as tv
    >>> tv.load_sizing("configuration-i").times[[0, 1, -1]]
    array([ 44.75,  45.  , 112.25])
    """
    if soundings is not None:
        instance("soundings", soundings, Mapping, "of names to SoundingAsked")
    more = dict(soundings or {})
    if _is_study(source):
        asked = load_study(source).sizing
        if asked is None:
            raise InputError(
                f"{called(source)} has no flight; add [schedule], see tvclin init --study"
            )
        return replace(asked, soundings={**asked.soundings, **more})
    pulses = () if more else (DEFAULT_WIND,)
    schedule = load_schedule(source)
    return SizingAsked(schedule=schedule, source=str(source), pulses=pulses, soundings=more)


def _is_study(source: str | PathLike[str]) -> bool:
    """Whether a file is a study, or neither that nor anything that has a flight."""
    if str(path("source", source, "a name or a path")).lower().endswith(".csv"):
        return False
    headings = tables_of(*vehicle_text(source)).keys()
    return bool({"study", "campaign"} & headings) or not {"vehicle", "schedule"} & headings


def example() -> str:
    """Return the study file of the package, which is commented."""
    return files("tvclin.answers.study_file").joinpath("example.toml").read_text(encoding="utf-8")


def example_plan() -> StudyPlan:
    """Return the plan of the study file of the package."""
    return parse_study(tables_of(example(), "the example"))


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
