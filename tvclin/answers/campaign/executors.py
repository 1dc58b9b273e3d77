"""Executors to run a campaign with: processes of this machine, or a running Dask cluster."""

import asyncio
import os
import signal
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import (
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
)
from contextlib import contextmanager
from multiprocessing import get_context, parent_process, resource_tracker
from threading import Event, Thread
from typing import Any

from tvclin.base.errors import InputError, imported, whole_number
from tvclin.base.warned import MachineWarning
from tvclin.kernels.threads import VARIABLE

_TIMEOUT = 5.0
"""Seconds in which a scheduler must answer."""
_MAX_WORKERS = 4096
"""Largest number of worker processes."""
_STDERR = 2
"""File descriptor of the standard error stream."""
_interrupted = Event()
"""Set in a worker after Ctrl-C."""


@contextmanager
def processes(workers: int) -> Iterator[Executor]:
    """Yield an executor of `workers` processes of this machine with a single thread each."""
    if not 1 <= whole_number("workers", workers) <= _MAX_WORKERS:
        raise InputError(f"workers must be from 1 to {_MAX_WORKERS}; got {workers}")
    context = get_context("spawn")
    resource_tracker.ensure_running()  # its start would let Ctrl-C through again
    with _Processes(workers, mp_context=context, initializer=_begin_worker) as pool:
        try:
            yield pool
        except BaseException:
            _quiet_tracker()
            pool.shutdown(wait=True, cancel_futures=True)
            raise


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """Yield an executor of the workers of a Dask scheduler.

    `address`: of the scheduler, such as "tcp://10.0.0.1:8786". `InputError` when no scheduler
    answers there within five seconds, or it or its workers are lost for good.
    """
    distributed = imported("distributed", "a scheduler needs distributed", "campaign")
    try:
        with ThreadPoolExecutor(1) as thread:  # a notebook has its own event loop
            thread.submit(asyncio.run, _connect(distributed, address)).result()
        client = distributed.Client(address, timeout=_TIMEOUT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split()) or f"no answer after {_TIMEOUT:g} s"
        raise InputError(f"there is no Dask scheduler at {address}: {reason}") from None
    with client:
        try:
            yield client.get_executor(pure=False)
        except (distributed.KilledWorker, CancelledError):
            raise InputError(
                f"the workers or the scheduler at {address} were lost; what was finished is kept,"
                " go on with: tvclin campaign resume"
            ) from None


class _Processes(ProcessPoolExecutor):
    """Processes that Ctrl-C (SIGINT) interrupts only in their tasks.

    A process that is interrupted while it starts or waits for a task would print a traceback.
    """

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
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
    """Block SIGINT, or unblock it, in this thread; on Windows there is no such mask."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(getattr(signal, change), {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


async def _connect(distributed: Any, address: str) -> None:
    """Connect to a scheduler and close the connection; a `Client` that fails hangs when deleted."""

    async def connect() -> None:
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

    The new tracker has no record of the semaphores that are released afterwards, and would print a
    KeyError for each.
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
