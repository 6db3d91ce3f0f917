"""The workers that simulate trials: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import os
import platform
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any, TypeVar

from wbc.errors import MissingExtra
from wbc.trials.errors import TrialError
from wbc.trials.provenance import Provenance

T = TypeVar("T")

_CONNECT = 10  # s to wait for a Dask scheduler


@dataclass(frozen=True)
class Workers:
    """Workers of a grid.

    Attributes:
        executor: runs functions on them.
        count: number of functions that run at the same time.
        name: what they are, in words.
    """

    executor: Executor
    count: int
    name: str


@contextlib.contextmanager
def local_workers(count: int | None = None) -> Iterator[Workers]:
    """Start processes on this machine; they end with the block.

    Args:
        count: number of processes; by default one per core that this process may use.
    """
    count = count or len(os.sched_getaffinity(0))
    context = multiprocessing.get_context("spawn")
    executor = ProcessPoolExecutor(count, mp_context=context, initializer=_prepare_process)
    try:
        yield Workers(executor, count, f"{count} process{'es' if count > 1 else ''}")
    finally:
        executor.shutdown(wait=True, cancel_futures=True)


@contextlib.contextmanager
def dask_workers(address: str) -> Iterator[Workers]:
    """Use the workers of a running Dask cluster, with one thread each.

    Args:
        address: address of the scheduler, e.g. `tcp://10.0.0.1:8786`.

    Raises:
        TrialError: there is no scheduler at the address, or it has no workers.
        MissingExtra: `distributed` is not installed.
    """
    try:
        import distributed
    except ImportError as error:
        raise MissingExtra("distributed", "trials") from error
    try:
        client = distributed.Client(address, timeout=_CONNECT)
    except (OSError, ValueError, TimeoutError) as error:
        raise TrialError(
            f"no Dask scheduler answers at '{address}'; start one with  dask scheduler  and "
            f"workers with  dask worker {address} --nthreads 1"
        ) from error
    with client:
        count = sum(client.nthreads().values())
        if count == 0:
            raise TrialError(f"the Dask cluster at '{address}' has no workers")
        yield Workers(client.get_executor(pure=False), count, f"{count} Dask workers")


def run_task(provenance: Provenance, function: Callable[..., T], *arguments: Any) -> T:
    """Call a function on a worker, if the worker has the same software as who asks.

    Args:
        provenance: the versions that the results are to come from.
        function: the function.
        arguments: its arguments.

    Raises:
        TrialError: the worker has other software: results would depend on who computed them.
    """
    differences = _software().differences(provenance)
    if differences:
        raise TrialError(
            f"a worker on {platform.node()} has other software than who asks it: "
            f"{', '.join(differences)}; install the same everywhere, and do not edit it meanwhile"
        )
    return function(*arguments)


@functools.cache
def _software() -> Provenance:
    return Provenance.current()


def _prepare_process() -> None:
    """Leave signals, which may reach the whole process group, to the parent, and end with it."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def end_with_parent() -> None:
        if parent is not None:
            parent.join()
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()
