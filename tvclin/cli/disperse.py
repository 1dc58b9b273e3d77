"""`tvclin disperse`: the deflection that covers dispersed cases, in memory or in a folder."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from math import degrees
from pathlib import Path
from typing import Annotated, Any

import typer

from tvclin.ascent.measured_wind import MeasuredWind, fly_through
from tvclin.base.errors import InputError, naming
from tvclin.base.files import called, exists
from tvclin.case.case import DEFAULT_WIND
from tvclin.cli.inputs import note_omissions, only_with
from tvclin.cli.options import (
    CAMPAIGN,
    GROUP,
    LIMIT,
    MODEL_AND_PLANE,
    SOURCE_HELP,
    STUDY,
    AsJson,
    At,
    More,
    Options,
    option,
    to_write,
)
from tvclin.cli.output import answer, bar, print_answer, print_tables, say
from tvclin.cli.wind import DIRECTED, WindOptions, note_one_sign, note_sounding
from tvclin.ensembles.campaign.campaign_plan import Campaign, SoundingEnsemble
from tvclin.ensembles.campaign.chunk_runner import (
    cluster,
    damaged,
    open_campaign,
    processes,
    run_campaign,
)
from tvclin.ensembles.campaign.folder import NAME, read_manifest
from tvclin.ensembles.campaign.results import CampaignResults, ResultsInMemory
from tvclin.ensembles.campaign.summary import CampaignSummary
from tvclin.ensembles.dispersions import DEFAULT_DISPERSIONS, WIND, Dispersions
from tvclin.requirement.flight.request import SIZE_TABLE
from tvclin.studyfile.campaign_file import CASES, load_campaign
from tvclin.studyfile.settings import with_settings
from tvclin.vehicle.vehicle_file import source_tables
from tvclin.winds.shaped import FixedWind
from tvclin.winds.wind_file import SOUNDING, directed_winds, wind_tables

_OF_THE_VEHICLE = Dispersions(
    tuple(d for d in DEFAULT_DISPERSIONS.distributions if d.parameter not in WIND)
)
"""Default dispersions in a wind that is not dispersed."""


@dataclass(frozen=True)
class FolderOptions:
    """Options of a folder of results and of the workers; `grouped` gives them to a command."""

    folder: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--folder",
            help="Compute into this folder, in chunks; the same command again continues.",
        ),
    ] = None
    workers: int | None = option("Number of worker processes; with --folder.")
    scheduler: str | None = option("A Dask scheduler, as tcp://10.0.0.1:8786; with --folder.")
    shard: str | None = option("Compute part i of n of the chunks, i/n; with --folder.")

    panel = "Folder"

    def run(self, campaign: Campaign) -> CampaignResults:
        """Return the results of a campaign, computed in memory or into the folder.

        An interrupted run into a folder prints how to continue.
        """
        if self.folder is None:
            only_with("--folder", workers=self.workers, scheduler=self.scheduler, shard=self.shard)
            with bar("cases") as progress:
                return ResultsInMemory.of(campaign, progress)
        if exists(self.folder / NAME):
            for fault in damaged(self.folder, read_manifest(self.folder)).values():
                say(f"Warning: {fault}", err=True)
        try:
            with self._executor() as executor, bar("cases") as progress:
                return run_campaign(
                    campaign, self.folder, executor=executor, shard=self.shard, progress=progress
                )
        except KeyboardInterrupt:
            say(
                f"Stopped; finished chunks are kept in {called(self.folder)}. The same command"
                " again continues.",
                err=True,
            )
            raise typer.Exit(130) from None

    def _executor(self) -> AbstractContextManager[Executor | None]:
        """Return the executor of --scheduler or --workers; None without either."""
        if self.workers is not None and self.scheduler is not None:
            raise InputError("give --workers or --scheduler, not both")
        if self.scheduler is not None:
            return cluster(self.scheduler)
        return nullcontext() if self.workers is None else processes(self.workers)


@dataclass(frozen=True)
class AnswerOptions:
    """Options of the statistics that are printed; `grouped` gives them to a command."""

    case: int | None = option("Compute one case again, and print it in full with its response.")
    output: str | None = option(
        "Number of each case whose statistics are printed, as required_K1; a wrong one lists all.",
        shown="the first of the file",
    )

    panel = "Answer"


def disperse(
    source: Annotated[
        str,
        typer.Argument(
            metavar="VEHICLE|STUDY|FOLDER",
            help=f"{SOURCE_HELP} A campaign file is one (see: tvclin init --campaign). Or a folder"
            " of results, to print what is there.",
        ),
    ] = "configuration-i",
    time: At = None,
    winds: WindOptions = GROUP,
    limit: Options = LIMIT,
    model: Options = MODEL_AND_PLANE,
    dead_band: Options = Options(STUDY, ("dead_band",)),
    drawn: Options = Options(STUDY, ("cases",)),
    work: FolderOptions = GROUP,
    shown: AnswerOptions = GROUP,
    level: Options = Options(CAMPAIGN, ("probability", "confidence")),
    as_json: AsJson = False,
    csv: Annotated[
        Path | None, typer.Option(help="Also write all cases into this file.", callback=to_write)
    ] = None,
    more: More = False,
) -> None:
    """Print the deflection that covers dispersed vehicles and winds, and its confidence.

    tvclin study is of the nominal case, tvclin availability of measured winds. A file without
    dispersions has assumed ones. A few thousand cases take seconds; with --folder there may be
    millions, stopped and continued at will. With --set campaign.along true each case flies along
    the whole flight, in one of the soundings of --winds (a file, a station file or a folder) or in
    a pulse.

    Exit code 0: the limit is SUFFICIENT for the probability, or none was given; 1: it is NOT
    SUFFICIENT, or that is NOT KNOWN; 2: bad input.
    """
    if Path(source).is_dir():
        options = {"at": time, **vars(work), **vars(winds), **model.values, **drawn.values}
        only_with("a vehicle or a file, not a folder of results", **options)
        results = open_campaign(source)
    else:
        results = work.run(_campaign(source, time, winds, (limit, model, dead_band, drawn)))
        if work.shard is not None:  # "i/n", a part of the cases alone: no answer yet
            done = f"{results.cases} of {results.campaign.cases} cases are done"
            say(f"{done}. Print what is there: tvclin disperse {called(results.folder)}")
            return
    if csv is not None:
        results.to_csv(csv)
    if shown.case is not None:
        replayed = results.replay(shown.case)
        answer(as_json, lambda: replayed, lambda: print_tables(*replayed.tables()))
        return
    summary = CampaignSummary.of(results, shown.output, limit.values.get("limit"), **level.values)
    good = summary.success is None or bool(summary.sufficient)
    answer(as_json, lambda: summary, lambda: _print(summary, more), good)


def _campaign(
    source: str, time: float | None, winds: WindOptions, changes: Sequence[Options]
) -> Campaign:
    """Return the campaign of a file or a vehicle, with the keys of options set.

    `source`: the file, or name of a vehicle. `time`: flight time [s] of a schedule. `winds`:
    options of the wind. `changes`: groups of options whose fields are keys of a campaign. Messages
    name the option, not the key that it sets. In a sounding the default dispersions leave the wind
    out.
    """
    values = {name: value for change in changes for name, value in change.values.items()}
    keys = _keys(source_tables(source), {"time": time, **vars(winds), **values})
    try:
        campaign = load_campaign(with_settings(source, keys.values()))
    except InputError as error:
        words = str(error)
        for option, (key, _) in keys.items():
            words = words.replace(f"--set {key}", option)
        if not {"study", "campaign"} & source_tables(source).keys():  # no file has these keys
            words = words.removeprefix(f"{called(source)}: ")
        raise InputError(words) from None
    if winds.winds is None and not directed_winds(source_tables(source)):
        only_with(DIRECTED, azimuth_deg=winds.azimuth_deg)
    assumed = campaign.dispersions == DEFAULT_DISPERSIONS
    if winds.winds is not None:
        if assumed:
            campaign = replace(campaign, dispersions=_OF_THE_VEHICLE)
        frozen = campaign.along is None
        campaign = (_in_a_sounding if frozen else _in_soundings)(campaign, winds, source)
    outputs, questions = set(campaign.outputs), ["disperse"]
    if not outputs & {"flight", "flown"}:
        questions.append(
            f"disperse without flights{'' if 'margins' in outputs else ' and margins'}"
        )
    note_omissions(campaign, *questions, tables=source_tables(source))
    return campaign


def _in_a_sounding(campaign: Campaign, winds: WindOptions, source: str) -> Campaign:
    """Return a campaign at one flight time in the sounding of the options, and print its notes.

    `winds`: options of the wind. `source`: file of the campaign, with the keys of soundings.
    """
    sounding = winds.sounding_of(campaign, source)
    assert sounding is not None
    in_plane = campaign.vehicle, campaign.plane
    wind = FixedWind(sounding.of_one_sign(*in_plane), sounding.unknown(*in_plane))
    note_sounding(sounding, campaign, source_tables(source).get("sounding", {}).get("window_s"))
    note_one_sign(sounding, campaign, "a campaign")
    return replace(campaign, wind=wind)


def _in_soundings(campaign: Campaign, winds: WindOptions, source: str) -> Campaign:
    """Return a campaign along a flight in the soundings of --winds, from size.from_s to to_s.

    `source`: file of the campaign, which may have these keys. Each case flies in one of the
    soundings. `InputError` for a gust on them.
    """
    plan = campaign.along
    assert plan is not None
    if getattr(campaign.wind, "gust", None) is not None:
        raise InputError("a gust on soundings is of one flight time; leave out [gust]")
    soundings = []
    for name, request in winds.soundings_along(source).items():
        with naming(name):
            wind = fly_through(
                request.profile,
                plan.flight,
                azimuth=request.azimuth,
                plane=campaign.plane,
                bias=request.bias,
            )
            assert isinstance(wind, MeasuredWind)  # of one plane
            soundings.append(wind)
    size = SIZE_TABLE.read(SIZE_TABLE.one(source_tables(source)))  # the table [size] of the file
    plan = replace(plan, start=size.get("start"), stop=size.get("stop"))
    return replace(campaign, wind=SoundingEnsemble.of(soundings), along=plan)


def _keys(tables: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Return the keys of a file with tables, and their values, by the options that give them.

    `tables`: tables of the file. `values`: values of options by field, None where not given. A key
    stands where the file has it: in [study] or in [campaign]; options of a pulse are of the first
    wind that is no sounding. Without campaign.cases in the file its default is set, so that a
    vehicle becomes a file of a campaign; so is a pulse with --winds and no wind in the file.
    """
    rows = wind_tables(tables)
    shaped = next((k for k, row in enumerate(rows) if SOUNDING not in row), 0)
    wind = f"wind.{shaped + 1}" if isinstance(tables.get("wind"), list) else "wind"
    campaign = tables.get("campaign", {})
    table = "study" if "study" in tables or not campaign else "campaign"
    keys_of_vehicle = {
        key: f"{'campaign' if key in campaign else table}.{key}"
        for key in ("time_s", "model", "plane")
    }
    band = values.get("dead_band")
    if values["winds"] is not None and not {"wind", "gust"} & tables.keys():
        pulse = {"duration": DEFAULT_WIND.duration, "peak_deg": degrees(DEFAULT_WIND.peak)}
        values = {**values, "wind": DEFAULT_WIND.shape, **pulse}  # the sounding replaces it
    values = {
        "--at": (keys_of_vehicle["time_s"], values["time"]),
        "--wind": (f"{wind}.shape", values["wind"]),
        "--duration": (f"{wind}.duration_s", values["duration"]),
        "--peak-deg": (f"{wind}.peak_deg", values["peak_deg"]),
        "--peak-speed": (f"{wind}.peak_speed_m_per_s", values["peak_speed"]),
        "--limit-deg": ("nozzle.limit_rad", values.get("limit")),
        "--model": (keys_of_vehicle["model"], values.get("model")),
        "--plane": (keys_of_vehicle["plane"], values.get("plane")),
        "--dead-band": ("outputs.dead_bands", None if band is None else f"[{band}]"),
        "--cases": ("campaign.cases", values.get("cases", campaign.get("cases", CASES))),
    }
    return {
        option: (key, str(value)) for option, (key, value) in values.items() if value is not None
    }


def _print(summary: CampaignSummary, more: bool) -> None:
    """Print the verdict, what it depends on most, and with `more` the convergence."""
    table, convergence = summary.tables()
    dispersions = summary.results.campaign.dispersions
    # by default, with or without dispersions of the wind
    assumed = dispersions in (DEFAULT_DISPERSIONS, _OF_THE_VEHICLE)
    notes = [f"these dispersions are assumed: {dispersions.words}"] * assumed
    print_answer(
        summary.verdict, table, notes=notes, more=more, details=lambda: print_tables(convergence)
    )
