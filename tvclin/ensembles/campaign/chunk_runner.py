"""Run of a campaign: its chunks with any executor, or one after the other.

A chunk is a pure function of the folder and its number, and it is finished when its file exists.
Executors are processes of this machine, or a running Dask cluster.
"""

import asyncio
import os
import re
import signal
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent import futures
from contextlib import contextmanager
from itertools import islice, pairwise
from multiprocessing import get_context, parent_process, resource_tracker
from os import PathLike
from pathlib import Path
from threading import Event, Thread
from typing import Any

from tvclin.base.errors import (
    InputError,
    callable_for,
    flag,
    imported,
    instance,
    path,
    shown,
    whole_number,
)
from tvclin.base.package_warnings import MachineWarning
from tvclin.ensembles.campaign.campaign_plan import Campaign, checkpoints
from tvclin.ensembles.campaign.cases import evaluate, nominal
from tvclin.ensembles.campaign.folder import (
    Manifest,
    arrow,
    begin,
    check_versions,
    chunk_fault,
    chunk_file,
    read_manifest,
    remove_stale_files,
    run_chunk,
)
from tvclin.ensembles.campaign.results import CampaignResults
from tvclin.kernels.choice import VARIABLE, available, pinned, repeated

_TIMEOUT = 5.0
"""Seconds in which a scheduler must answer."""
_MAX_WORKERS = 4096
"""Largest number of worker processes."""
_STDERR = 2
"""File descriptor of the standard error stream."""
_interrupted = Event()
"""Set in a worker after Ctrl-C."""


@contextmanager
def processes(workers: int) -> Iterator[futures.Executor]:
    """Yield an executor of `workers` processes of this machine with a single thread each.

    On an exception no further task begins.
    """
    if not 1 <= whole_number("workers", workers) <= _MAX_WORKERS:
        raise InputError(f"workers must be from 1 to {_MAX_WORKERS}; got {workers}")
    context = get_context("spawn")
    # multiprocessing's tracker of semaphores is started first: its start unblocks SIGINT (Ctrl-C),
    # which `submit` blocks while it starts a process
    resource_tracker.ensure_running()
    with _Processes(workers, mp_context=context, initializer=_begin_worker) as pool:
        try:
            yield pool
        except BaseException:
            _quiet_tracker()
            pool.shutdown(wait=True, cancel_futures=True)
            raise


@contextmanager
def cluster(address: str) -> Iterator[futures.Executor]:
    """Yield an executor of the workers of a Dask scheduler.

    `address`: of the scheduler, such as "tcp://10.0.0.1:8786". `InputError` when no scheduler
    answers there within five seconds, or it or its workers are lost for good.
    """
    distributed = imported("distributed", "a scheduler needs distributed", "campaign")
    try:
        with futures.ThreadPoolExecutor(1) as thread:  # a notebook has its own event loop
            thread.submit(asyncio.run, _connect(distributed, address)).result()
        client = distributed.Client(address, timeout=_TIMEOUT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split()) or f"no answer after {_TIMEOUT:g} s"
        raise InputError(f"there is no Dask scheduler at {address}: {reason}") from None
    with client:
        try:
            yield client.get_executor(pure=False)
        except (distributed.KilledWorker, futures.CancelledError):
            raise InputError(
                f"the workers or the scheduler at {address} were lost; what was finished is kept,"
                " run it again into the same folder"
            ) from None


class _Processes(futures.ProcessPoolExecutor):
    """Processes that Ctrl-C (SIGINT) interrupts only in their tasks.

    A process that is interrupted while it starts or waits for a task would print a traceback.
    """

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> futures.Future[Any]:
        """Return the future of a call of a function in a worker, where SIGINT interrupts it."""
        with _interrupts("SIG_BLOCK"):  # a process inherits the mask of the one that spawns it
            return super().submit(_interruptible, fn, *args, **kwargs)


def _interruptible(function: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
    """Call a function in a worker, where Ctrl-C interrupts it and all later calls."""
    if _interrupted.is_set():
        raise KeyboardInterrupt
    try:
        with _interrupts("SIG_UNBLOCK"):
            return function(*arguments, **options)
    except KeyboardInterrupt:
        _interrupted.set()
        raise


@contextmanager
def _interrupts(change: str) -> Iterator[None]:
    """Block SIGINT, or unblock it, in this thread; on Windows there is no such mask.

    `change`: "SIG_BLOCK" or "SIG_UNBLOCK". The mask is restored afterwards.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(getattr(signal, change), {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


async def _connect(distributed: Any, address: str) -> None:
    """Connect to a scheduler and close the connection; a `Client` that fails hangs when deleted.

    `distributed`: the module of Dask. `address`: such as "tcp://10.0.0.1:8786".
    """

    async def connect() -> None:
        """Connect and close."""
        connection = await distributed.comm.connect(address, timeout=_TIMEOUT)
        await connection.close()

    await asyncio.wait_for(connect(), _TIMEOUT)  # also where another server says nothing


def _begin_worker() -> None:
    """Give a worker a single thread, no warning of slow kernels, and the life of its parent."""
    os.environ[VARIABLE] = "1"
    warnings.filterwarnings("ignore", "this takes about .* without numba", MachineWarning)
    Thread(target=_exit_with_parent, daemon=True).start()


def _exit_with_parent() -> None:
    """End this worker when its parent process was killed: it would get no more work."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _quiet_tracker() -> None:
    """Restart multiprocessing's tracker of semaphores without its messages, if it was killed.

    The new one has no record of semaphores that are released later, and prints a KeyError for each.
    """
    errors, nowhere = os.dup(_STDERR), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, _STDERR)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            resource_tracker.ensure_running()
    finally:
        os.dup2(errors, _STDERR)
        os.close(errors)
        os.close(nowhere)


Progress = Callable[[int, int], None]

_MAX_SUBMITTED = 256
"""Largest number of chunks that an executor has at a time."""


def run_campaign(
    campaign: Campaign,
    folder: str | PathLike[str],
    *,
    executor: futures.Executor | None = None,
    shard: str | None = None,
    compiled: bool | None = None,
    progress: Progress | None = None,
) -> CampaignResults:
    """Run a campaign into a folder, or continue the campaign in the folder.

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
        All finished chunks of the campaign; with a shard perhaps not all.

    Raises
    ------
    InputError
        When not even the nominal case can be answered, the folder holds another campaign or
        cannot be written, and when a worker has another version or was killed. Finished chunks
        are kept.

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
    target = _checked(folder, executor, progress)
    instance("campaign", campaign, Campaign, "see load_campaign")
    if compiled is not None:
        flag("compiled", compiled)
    arrow()  # raises where pyarrow is not installed
    nominal(campaign)  # raises where not even the nominal case has an answer
    return _work(begin(campaign, target, compiled), target, executor, shard, progress)


def resume_campaign(
    folder: str | PathLike[str],
    *,
    executor: futures.Executor | None = None,
    shard: str | None = None,
    progress: Progress | None = None,
) -> CampaignResults:
    """Continue the campaign in a folder; a damaged or foreign chunk is computed again.

    Parameters
    ----------
    folder : str or path
        Holds its manifest and its chunks.
    executor, shard, progress : optional
        Runner of the chunks, "i/n" for every n-th chunk from the i-th on, and function of finished
        and of all cases; see `run_campaign`.

    Raises
    ------
    InputError
        Same exceptions as `run_campaign`; also when the folder holds no campaign or its manifest
        was changed.
    """
    target = _checked(folder, executor, progress)
    return _work(read_manifest(target), target, executor, shard, progress)


def open_campaign(folder: str | PathLike[str]) -> CampaignResults:
    """Return the results of the campaign in a folder, of all chunks that are finished.

    Parameters
    ----------
    folder : str or path
        Folder of `run_campaign`.

    Raises
    ------
    InputError
        When the folder holds no campaign or its manifest was changed.
    """
    return CampaignResults.read(path("folder", folder))


def damaged(folder: Path, manifest: Manifest) -> dict[int, str]:
    """Return the faults, in words, of chunk files that exist but cannot be used, by chunk.

    `folder`, `manifest`: folder of a campaign, and the manifest in it.
    """
    chunks = (k for k in range(manifest.campaign.chunks) if chunk_file(folder, k).exists())
    return {k: fault for k in chunks if (fault := chunk_fault(folder, manifest, k)) is not None}


def _checked(folder: object, executor: object, progress: object) -> Path:
    """Return the folder of a run as a path; `InputError` for arguments that a run cannot use.

    `executor` and `progress` are checked too: an `Executor` and a callable, or None.
    """
    if executor is not None:
        instance("executor", executor, futures.Executor, "such as ProcessPoolExecutor")
    if progress is not None:
        callable_for("progress", progress, "of the cases done and of all cases")
    return path("folder", folder)


def _work(
    manifest: Manifest,
    folder: Path,
    executor: futures.Executor | None,
    shard: str | None,
    progress: Progress | None,
) -> CampaignResults:
    """Compute the chunks of a shard that are not finished, and return the results of the folder.

    `manifest`: manifest of the folder. `executor`: runs the chunks, or None for this process.
    `shard`: "i/n" for every n-th chunk from the i-th on, or None. `progress`: called with the
    numbers of finished and of all cases, or None.
    """
    campaign = manifest.campaign
    if shard is not None and campaign.until is not None:
        raise InputError(
            "a shard does not know when the whole campaign has converged; give one of the two"
        )
    check_versions(manifest)
    remove_stale_files(folder)
    first, step = _shard(shard)
    chunks = range(first, campaign.chunks, step)
    spans = {k: campaign.span(k) for k in chunks}
    sizes = {k: count for k, (_, count) in spans.items()}  # number of cases by chunk
    total, done = sum(sizes.values()), 0
    if executor is not None and not available():
        # workers without numba do not warn that they are slow: a case here warns of all cases
        with pinned(False), repeated(total):
            evaluate(campaign, 0, 1)
    # ranges of chunks after which convergence is checked, if it ends the campaign
    ends = [0, *checkpoints(campaign.chunks)] if campaign.until is not None else [0, len(chunks)]
    for start, end in pairwise(ends):
        group = chunks[start:end]
        unfinished = []
        for k in group:
            if chunk_fault(folder, manifest, k) is None:
                done += sizes[k]
            else:
                unfinished.append(k)
        for k in _finished(unfinished, str(folder.absolute()), manifest.seal, executor):
            done += sizes[k]
            if progress is not None:
                progress(done, total)
        if campaign.until is not None and CampaignResults.read(folder).converged:
            break
    return CampaignResults.read(folder)


def _finished(
    chunks: list[int], folder: str, seal: str, executor: futures.Executor | None
) -> Iterator[int]:
    """Run chunks and yield their numbers as they are finished.

    `chunks`: numbers of the chunks. `folder`, `seal`: of the campaign, and hash of its manifest.
    `executor`: runs the chunks; None for this process.
    """
    if executor is None:
        yield from (run_chunk(folder, seal, k) for k in chunks)
        return
    remaining = iter(chunks)

    def submit(count: int) -> Iterable[futures.Future[int]]:
        """Return the futures of the next `count` chunks, given to the executor."""
        return [executor.submit(run_chunk, folder, seal, k) for k in islice(remaining, count)]

    running: set[futures.Future[Any]] = set()
    try:
        running.update(submit(_MAX_SUBMITTED))
        while running:
            finished, running = futures.wait(running, return_when=futures.FIRST_COMPLETED)
            for future in finished:
                yield future.result()
            running.update(submit(len(finished)))
    except futures.BrokenExecutor:
        raise InputError(
            "a worker process has died (killed, or out of memory); what was finished is kept: run"
            f" it again into {folder}"
        ) from None
    finally:
        for future in running:
            future.cancel()


def _shard(text: str | None) -> tuple[int, int]:
    """Return the first chunk of a shard, from zero, and the step from chunk to chunk.

    `text`: "i/n", i from 1 to n, for every n-th chunk from the i-th on; None for all chunks.
    """
    if text is None:
        return 0, 1
    match = re.fullmatch(r"(\d{1,12})/(\d{1,12})", text) if isinstance(text, str) else None
    index, count = map(int, match.groups()) if match else (0, 0)  # zeros are refused
    if not 1 <= index <= count:
        raise InputError(f"shard must be i/n with i from 1 to n, such as 3/16; got {shown(text)}")
    return index - 1, count
