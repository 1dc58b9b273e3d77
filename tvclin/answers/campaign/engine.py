"""Run the chunks of a campaign with any executor, or one after the other.

A chunk is a pure function of the folder and its number, and it is finished when its file exists.
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

_MAX_SUBMITTED = 256
"""Largest number of chunks that an executor has at a time."""


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
        Called with the number of finished cases and the number of all cases.

    Returns
    -------
    CampaignResults
        All finished chunks: those of the whole campaign, or with a shard perhaps fewer.

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
    ...     results = tv.run_campaign(campaign, folder)
    ...     covered = float(np.degrees(results.quantile().estimate))
    ...     results.cases, results.complete, round(covered, 3)
    (300, True, 0.433)
    """
    place = _checked(folder, executor, progress)
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
    """Continue the campaign in a folder; a damaged or foreign chunk is computed again.

    Parameters
    ----------
    folder, executor, shard, progress
        As of `run_campaign`.

    Raises
    ------
    InputError
        As `run_campaign`, and when the folder holds no campaign or its manifest was changed.
    """
    place = _checked(folder, executor, progress)
    return _work(read_manifest(place), place, executor, shard, progress)


def open_campaign(folder: str | PathLike[str]) -> CampaignResults:
    """Return the results of the campaign in a folder, of all chunks that are finished.

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
    """Return the faults, in words, of chunk files that exist but cannot be used, by chunk."""
    chunks = (k for k in range(manifest.campaign.chunks) if chunk_file(folder, k).exists())
    return {k: fault for k in chunks if (fault := flaw(folder, manifest, k)) is not None}


def _checked(folder: object, executor: object, progress: object) -> Path:
    """Return the folder as a path; `InputError` for arguments that a run cannot use."""
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
    """Compute the chunks of a shard that are not finished, and return the results of the folder."""
    campaign = manifest.campaign
    if shard is not None and campaign.until is not None:
        raise InputError(
            "a shard does not know when the whole campaign has converged; give one of the two"
        )
    check_versions(manifest)
    sweep(folder)
    first, step = _shard(shard)
    chunks = range(first, campaign.chunks, step)
    total, done = sum(campaign.span(k)[1] for k in chunks), 0
    if executor is not None and not available():
        _count_work(campaign, total)
    for group in _groups(campaign, chunks):
        todo = []
        for k in group:
            if flaw(folder, manifest, k) is None:
                done += campaign.span(k)[1]
            else:
                todo.append(k)
        for k in _finished(todo, str(folder.absolute()), manifest.seal, executor):
            done += campaign.span(k)[1]
            if progress is not None:
                progress(done, total)
        if campaign.until is not None and CampaignResults.read(folder).converged:
            break
    return CampaignResults.read(folder)


def _count_work(campaign: Campaign, cases: int) -> None:
    """Count the work of workers without numba in this process, as `cases` times that of one case.

    The workers themselves print no warning.
    """
    with pinned(False), repeated(cases):
        evaluate(campaign, 0, 1)


def _groups(campaign: Campaign, chunks: range) -> Iterator[range]:
    """Yield all chunks, or with `until` the chunks between two checkpoints of convergence."""
    if campaign.until is None:
        yield chunks
        return
    begin = 0
    for end in checkpoints(campaign.chunks):
        yield range(begin, end)
        begin = end


def _finished(
    chunks: list[int], folder: str, seal: str, executor: Executor | None
) -> Iterator[int]:
    """Run chunks and yield their numbers as they are finished."""
    if executor is None:
        yield from (run_chunk(folder, seal, k) for k in chunks)
        return
    remaining = iter(chunks)

    def submit(count: int) -> Iterable[Future[int]]:
        return [executor.submit(run_chunk, folder, seal, k) for k in islice(remaining, count)]

    running: set[Future[Any]] = set()
    try:
        running.update(submit(_MAX_SUBMITTED))
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
    """Return the first chunk of a shard, from zero, and the step from chunk to chunk."""
    if text is None:
        return 0, 1
    match = re.fullmatch(r"(\d{1,12})/(\d{1,12})", text) if isinstance(text, str) else None
    index, count = map(int, match.groups()) if match else (0, 0)
    if not 1 <= index <= count:
        raise InputError(f"shard must be i/n with i from 1 to n, such as 3/16; got {shown(text)}")
    return index - 1, count
