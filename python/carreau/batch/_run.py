"""A manifest in, a table out."""

from __future__ import annotations

import dataclasses
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from typing import Any, Literal

from ._engines import ENGINES
from ._job import Job
from ._table import Journal, Name, name_of, read_manifest

__all__ = ["Summary", "run"]

Row = dict[str, Any]


@dataclasses.dataclass(frozen=True)
class Summary:
    """What became of a manifest.

    Attributes
    ----------
    jobs : int
        Jobs of the manifest.
    skipped : int
        Those that an earlier run had finished.
    done : int
        Those that ended with exit code 0 now.
    failed : int
        Those that did not; their rows say why.
    seconds : float
        Time of the run.
    """

    jobs: int
    skipped: int
    done: int
    failed: int
    seconds: float


def run(
    manifest: str | os.PathLike[str] | Iterable[Job | Mapping[str, Any] | str | os.PathLike[str]],
    out: str | os.PathLike[str],
    *,
    engine: Literal["local", "dask", "ray"] = "local",
    workers: int | None = None,
    verb: str | None = None,
    options: Mapping[str, Any] | None = None,
    deadline: float | None = None,
    memory: float | None = None,
    command: Iterable[str] | None = None,
    retry: bool = False,
    watch: Callable[[Row], None] | None = None,
    **settings: Any,
) -> Summary:
    """Run the jobs of a manifest, each in a child process, and write a row for each.

    Jobs that a run into the same table has finished before are not run again: those whose file has the same bytes, with
    the same verb, options and version of carreau, and whose output is still there. A run that is stopped loses the jobs
    in flight only.

    Parameters
    ----------
    manifest : path or iterable
        A table (.csv, .jsonl, .parquet) with the columns ``file``, ``verb``, ``output``, ``deadline``, ``memory``,
        others being options; or jobs, mappings, names of files.
    out : path
        The table to write: .csv, .jsonl or .parquet (needs pyarrow).
    engine : {"local", "dask", "ray"}
        Where jobs run. "dask" and "ray" start a cluster on this machine unless ``address`` names one.
    workers : int, optional
        Jobs at a time; the number of processors. Give ``options={"threads": 1}`` to let each have one thread.
    verb, options, deadline, memory, command
        What rows of the manifest leave open; see `Job`. Seconds and megabytes.
    retry : bool
        Run jobs again that failed before.
    watch : callable, optional
        Called with every row as it comes.
    **settings
        For the engine: ``address``, ``client``, and what its local cluster takes.

    Returns
    -------
    Summary
        Counts and time.
    """
    start = time.monotonic()
    if engine not in ENGINES:
        raise ValueError(f"there is no engine '{engine}'; known are {', '.join(ENGINES)}")
    defaults = {"verb": verb, "options": dict(options or {}), "deadline": deadline, "memory": memory}
    jobs = read_manifest(manifest, **defaults, command=tuple(command) if command else None)
    journal = Journal(out)
    order: list[Name] = []
    fresh: list[bool] = []
    try:
        todo = _unfinished(jobs, journal, order, retry)
        with closing(ENGINES[engine](todo, workers or os.cpu_count() or 1, **settings)) as rows:
            for row in rows:
                journal.add(row)
                fresh.append(row["exit_code"] == 0)
                if watch is not None:
                    watch(row)
        journal.finish(order)
    finally:
        journal.close()
    done = sum(fresh)
    return Summary(len(order), len(order) - len(fresh), done, len(fresh) - done, time.monotonic() - start)


def _unfinished(jobs: Iterable[Job], journal: Journal, order: list[Name], retry: bool) -> Iterator[Job]:
    """The jobs that have to run; `order` gets the names of all."""
    for job in jobs:
        name = name_of({"hash": job.key(), "file": job.file, "output": job.output})
        order.append(name)
        earlier = journal.rows.get(name)
        if earlier is None or (retry and earlier.get("exit_code") != 0) or _is_gone(earlier):
            yield job


def _is_gone(row: Mapping[str, Any]) -> bool:
    """Whether a finished job has lost its output."""
    return row.get("exit_code") == 0 and bool(row.get("output")) and not os.path.exists(row["output"])
