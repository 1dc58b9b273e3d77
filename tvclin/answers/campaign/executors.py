"""Executors to run a campaign with: processes of this machine, or a Dask cluster that is there."""

import os
import warnings
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context, parent_process, resource_tracker
from threading import Thread

from tvclin.base.errors import InputError, imported, whole_number
from tvclin.kernels.threads import VARIABLE

_TIMEOUT = 5.0
"""Seconds in which a scheduler must answer."""
_MOST_WORKERS = 4096
_STDERR = 2


@contextmanager
def processes(workers: int) -> Iterator[Executor]:
    """Lend so many processes of this machine, each with one thread."""
    if not 1 <= whole_number("workers", workers) <= _MOST_WORKERS:
        raise InputError(f"workers must be from 1 to {_MOST_WORKERS}; got {workers}")
    context = get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_begin_worker) as pool:
        try:
            yield pool
        except BaseException:
            _quiet_tracker()
            pool.shutdown(wait=True, cancel_futures=True)
            raise


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """Lend the workers of a Dask scheduler.

    `address`: of the scheduler, such as "tcp://10.0.0.1:8786". `InputError` when no scheduler
    answers there within five seconds, or it or its workers are lost for good.
    """
    distributed = imported("distributed", "a scheduler needs distributed", "campaign")
    try:
        client = distributed.Client(address, timeout=_TIMEOUT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"there is no Dask scheduler at {address}: {reason}") from None
    with client:
        try:
            yield client.get_executor(pure=False)
        except (distributed.KilledWorker, CancelledError):
            raise InputError(
                f"the workers or the scheduler at {address} were lost; what was finished is kept,"
                " go on with: tvclin campaign resume"
            ) from None


def _begin_worker() -> None:
    os.environ[VARIABLE] = "1"
    Thread(target=_leave_with_parent, daemon=True).start()


def _leave_with_parent() -> None:
    """End this worker when the process that lent it was killed: nobody would hand it work."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _quiet_tracker() -> None:
    """Start multiprocessing's tracker of semaphores anew, unheard, if it was killed as well.

    It does not know those that it is told to forget now, and would print a KeyError for each.
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
