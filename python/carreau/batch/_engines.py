"""Where jobs run. An engine maps `run_one` over jobs and hands back rows as they come, whatever happens to its workers.

Jobs are drawn as they are needed: a manifest of a million files is never held as tasks.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice
from typing import Any

from ._child import end_child, lost, run_one
from ._job import Job

__all__ = ["ENGINES"]

Row = dict[str, Any]
Engine = Callable[..., Generator[Row, None, None]]
#: Files that a task of a cluster has at most: its scheduler is one process, and each task costs it about a millisecond.
_CHUNK = 50
#: Tasks in flight per worker: enough that none waits.
_AHEAD = 3


def local(jobs: Iterable[Job], workers: int, **_: Any) -> Generator[Row, None, None]:
    """Threads that each watch one child process."""
    jobs = iter(jobs)
    children: set[int] = set()
    pool = ThreadPoolExecutor(workers)
    try:
        waiting: set[Future[Row]] = {pool.submit(run_one, job, children) for job in islice(jobs, _AHEAD * workers)}
        while waiting:
            done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            waiting |= {pool.submit(run_one, job, children) for job in islice(jobs, len(done))}
            yield from (future.result() for future in done)
    finally:
        # Where the run was stopped, jobs may still be running.
        pool.shutdown(wait=False, cancel_futures=True)
        for child in tuple(children):
            end_child(child)


def dask(
    jobs: Iterable[Job], workers: int, *, address: str | None = None, client: Any = None, **cluster: Any
) -> Generator[Row, None, None]:
    """Dask distributed: the cluster at an address, that of a client, or one of this machine for the time of the run."""
    import dask as framework
    from distributed import Client, LocalCluster

    if client is not None:
        yield from _over_dask(client, jobs, workers)
    elif address is not None:
        with Client(address) as client:
            yield from _over_dask(client, jobs, workers)
    else:
        options = {"n_workers": workers, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
        # A task whose worker died is not handed to the next one: `_over_dask` sees to it.
        with (
            framework.config.set({"distributed.scheduler.allowed-failures": 0}),
            LocalCluster(**(options | cluster)) as machine,
            Client(machine) as client,
        ):
            yield from _over_dask(client, jobs, workers)


def _over_dask(client: Any, jobs: Iterable[Job], workers: int) -> Generator[Row, None, None]:
    """Chunks with a bounded number in flight. When a worker dies all its tasks are suspects; these run again in the
    end, one job at a time, so that only the job that did it is lost."""
    from distributed import as_completed

    chunks = _chunks(jobs, workers)
    chunk_of: dict[str, list[Job]] = {}
    suspects: list[Job] = []

    def submit(chunk: list[Job]) -> Any:
        future = client.submit(_run_all, chunk, pure=False)
        chunk_of[future.key] = chunk
        return future

    slots = _AHEAD * max(workers, sum(client.nthreads().values()))
    running = as_completed([submit(chunk) for chunk in islice(chunks, slots)])
    for future in running:
        chunk = chunk_of.pop(future.key)
        if future.status == "finished":
            yield from future.result()
        else:
            suspects += chunk
        for chunk in islice(chunks, 1):
            running.add(submit(chunk))
    for job in suspects:
        future = client.submit(run_one, job, pure=False)
        error = future.exception()
        yield future.result() if error is None else lost(job, f"the worker died: {error}")


def ray(jobs: Iterable[Job], workers: int, *, address: str | None = None, **init: Any) -> Generator[Row, None, None]:
    """Ray Data: the cluster at an address, the one that runs already, or one of this machine for the time of the
    run."""
    import ray as framework
    from ray.data import DataContext, TaskPoolStrategy

    started = not framework.is_initialized()
    if started:
        machine = {"num_cpus": workers, "include_dashboard": False, "log_to_driver": False, "logging_level": "ERROR"}
        framework.init(**({"address": address} if address else machine) | init)
    try:
        context = DataContext.get_current()
        # A block whose worker dies is tried once more, then given up: by default it is tried for ever.
        context.max_errored_blocks = -1
        context.enable_progress_bars = False
        known = list(jobs)
        missing = dict(enumerate(known))
        items = framework.data.from_items(
            [{"number": k} for k in missing], override_num_blocks=_blocks(len(known), workers)
        )
        rows = items.map(_numbered(known), compute=TaskPoolStrategy(size=workers), max_retries=1, num_cpus=1)
        for row in rows.iter_rows():
            missing.pop(row["number"], None)
            yield json.loads(row["row"])
        yield from (lost(job, "the worker died") for job in missing.values())
    finally:
        if started:
            framework.shutdown()


def _numbered(jobs: list[Job]) -> Callable[[Row], Row]:
    """Rows as text: those of different verbs have different columns, and a data set has one schema."""

    def run(item: Row) -> Row:
        return {"number": item["number"], "row": json.dumps(run_one(jobs[item["number"]]))}

    return run


def _run_all(jobs: list[Job]) -> list[Row]:
    return [run_one(job) for job in jobs]


def _blocks(count: int, workers: int) -> int:
    """Small blocks: a block whose worker dies loses all its rows."""
    return max(1, min(count, max(_AHEAD * workers, count // _CHUNK)))


def _chunks(jobs: Iterable[Job], workers: int) -> Iterator[list[Job]]:
    """Lists of jobs for one task: single ones at first, so that a short manifest is spread evenly, then longer ones."""
    jobs = iter(jobs)
    size, count = 1, 0
    while chunk := list(islice(jobs, size)):
        yield chunk
        count += 1
        if count % (_AHEAD * workers) == 0:
            size = min(2 * size, _CHUNK)


#: By name.
ENGINES: dict[str, Engine] = {"local": local, "dask": dask, "ray": ray}
