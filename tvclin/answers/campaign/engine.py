"""Run the chunks of a campaign with any executor, or one after the other.

There is no engine here: a chunk is a pure function of the folder and its number, done when its
file is there, and whoever can call a function can run it.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from itertools import islice
from os import PathLike
from pathlib import Path
from typing import Any

from tvclin.answers.campaign.cases import evaluate, nominal
from tvclin.answers.campaign.chunks import arrow, chunk_file, flaw, run_chunk, sweep
from tvclin.answers.campaign.manifest import Manifest, begin, check_versions, read_manifest
from tvclin.answers.campaign.plan import Campaign, checkpoints
from tvclin.answers.campaign.results import CampaignResults
from tvclin.base.errors import InputError, callable_for, flag, instance, path, shown
from tvclin.kernels.choice import available, pinned, repeated

Progress = Callable[[int, int], None]
Shard = tuple[int, int]

_WAITING = 256
"""So many chunks are handed to an executor at a time."""


def run_campaign(
    campaign: Campaign,
    folder: str | PathLike[str],
    *,
    executor: Executor | None = None,
    shard: str | None = None,
    compiled: bool | None = None,
    progress: Progress | None = None,
) -> CampaignResults:
    """Run a campaign into a folder, or continue it there.

    Parameters
    ----------
    campaign : Campaign
        The campaign.
    folder : str or path
        Holds its manifest and its chunks.
    executor : concurrent.futures.Executor, optional
        Runs the chunks: a `ProcessPoolExecutor`, or `distributed.Client(...).get_executor()`;
        without one they run here, one after the other. Its workers must see the folder.
    shard : str, optional
        "i/n": only every n-th chunk, beginning with the i-th, i from 1 to n.
    compiled : bool, optional
        Whether compiled kernels are used; by default where there is a compiler. All chunks of a
        campaign use the same.
    progress : callable, optional
        Is told how many cases are done, and how many there are.

    Returns
    -------
    CampaignResults
        What is there now: all of the campaign, or with a shard perhaps only a part.

    Raises
    ------
    InputError
        When not even the nominal case can be answered, the folder holds another campaign or
        cannot be written, and when a worker has another version or was killed. What was finished
        is kept.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np, tvclin as tv
    >>> campaign = tv.Campaign(
    ...     vehicle=tv.load_vehicle("configuration-i"),
    ...     wind=tv.ShapedWind("triangular", peak=np.radians(5), duration=7.5),
    ...     dispersions=tv.Dispersions((tv.Dispersion("thrust", "truncated", 0.02),)),
    ...     cases=300,
    ...     chunk=256,
    ... )
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = tv.run_campaign(campaign, folder)
    ...     found.cases, found.complete, round(float(np.degrees(found.quantile().estimate)), 3)
    (300, True, 0.433)
    """
    place = _door(folder, executor, progress)
    instance("campaign", campaign, Campaign, "see load_campaign")
    if compiled is not None:
        flag("compiled", compiled)
    arrow()
    nominal(campaign)
    return _work(begin(campaign, place, compiled), place, executor, shard, progress)


def resume_campaign(
    folder: str | PathLike[str],
    *,
    executor: Executor | None = None,
    shard: str | None = None,
    progress: Progress | None = None,
) -> CampaignResults:
    """Continue the campaign in a folder; chunks damaged or of another one are computed again.

    Parameters
    ----------
    folder, executor, shard, progress
        As of `run_campaign`.

    Raises
    ------
    InputError
        As `run_campaign`, and when the folder holds no campaign or its manifest was changed.
    """
    place = _door(folder, executor, progress)
    return _work(read_manifest(place), place, executor, shard, progress)


def open_campaign(folder: str | PathLike[str]) -> CampaignResults:
    """Return what the campaign in a folder has found so far.

    Parameters
    ----------
    folder : str or path
        As of `run_campaign`.

    Raises
    ------
    InputError
        When the folder holds no campaign or its manifest was changed.
    """
    return CampaignResults.read(path("folder", folder))


def damaged(folder: Path, manifest: Manifest) -> dict[int, str]:
    """Return what is wrong with the chunks that are there but cannot be used."""
    there = (k for k in range(manifest.campaign.chunks) if chunk_file(folder, k).exists())
    return {k: said for k in there if (said := flaw(folder, manifest, k)) is not None}


def _door(folder: object, executor: object, progress: object) -> Path:
    """Return the folder as a path; `InputError` unless these are what a run can use."""
    if executor is not None:
        instance("executor", executor, Executor, "such as ProcessPoolExecutor")
    if progress is not None:
        callable_for("progress", progress, "of the cases done and of all cases")
    return path("folder", folder)


def _work(
    manifest: Manifest,
    folder: Path,
    executor: Executor | None,
    shard: str | None,
    progress: Progress | None,
) -> CampaignResults:
    campaign = manifest.campaign
    if shard is not None and campaign.until is not None:
        raise InputError(
            "a shard does not know when the whole campaign has converged; give one of the two"
        )
    check_versions(manifest)
    sweep(folder)
    first, step = _shard(shard)
    mine = range(first, campaign.chunks, step)
    total, done = sum(campaign.span(k)[1] for k in mine), 0
    if executor is not None and not available():
        _count_work(campaign, total)
    for group in _groups(campaign, mine):
        todo = []
        for k in group:
            if flaw(folder, manifest, k) is None:
                done += campaign.span(k)[1]
            else:
                todo.append(k)
        for k in _each(todo, str(folder.absolute()), manifest.seal, executor):
            done += campaign.span(k)[1]
            if progress is not None:
                progress(done, total)
        if campaign.until is not None and CampaignResults.read(folder).converged:
            break
    return CampaignResults.read(folder)


def _count_work(campaign: Campaign, cases: int) -> None:
    """Count the work of workers without numba here, by that of a case: they warn nobody."""
    with pinned(False), repeated(cases):
        evaluate(campaign, 0, 1)


def _groups(campaign: Campaign, mine: range) -> Iterator[range]:
    """All chunks, or those between two looks at whether the answer has converged."""
    if campaign.until is None:
        yield mine
        return
    begin = 0
    for end in checkpoints(campaign.chunks):
        yield range(begin, end)
        begin = end


def _each(chunks: list[int], folder: str, seal: str, executor: Executor | None) -> Iterator[int]:
    """Run chunks and yield their numbers as they are finished."""
    if executor is None:
        yield from (run_chunk(folder, seal, k) for k in chunks)
        return
    left = iter(chunks)

    def submit(count: int) -> Iterable[Future[int]]:
        return [executor.submit(run_chunk, folder, seal, k) for k in islice(left, count)]

    running: set[Future[Any]] = set()
    try:
        running.update(submit(_WAITING))
        while running:
            finished, running = wait(running, return_when=FIRST_COMPLETED)
            for future in finished:
                yield future.result()
            running.update(submit(len(finished)))
    except BrokenExecutor:
        raise InputError(
            "a worker process has died (killed, or out of memory); what was finished is kept, go on"
            f" with: tvclin campaign resume {folder}"
        ) from None
    finally:
        for future in running:
            future.cancel()


def _shard(text: str | None) -> Shard:
    """Which chunk is the first, and how many further each next one lies."""
    if text is None:
        return 0, 1
    found = re.fullmatch(r"(\d{1,12})/(\d{1,12})", text) if isinstance(text, str) else None
    index, count = (int(part) for part in found.groups()) if found else (0, 0)
    if not 1 <= index <= count:
        raise InputError(f"shard must be i/n with i from 1 to n, such as 3/16; got {shown(text)}")
    return index - 1, count
