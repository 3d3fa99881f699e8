"""Many files: one run of the command line per file, each in a child process with a deadline and a memory cap.

>>> from carreau import batch
>>> summary = batch.run("parts.csv", "rows.parquet", verb="segment", deadline=60, memory=2000)  # doctest: +SKIP
>>> summary = batch.run("parts.csv", "rows.parquet", verb="segment", engine="dask", workers=8)  # doctest: +SKIP

A job that crashes, hangs or eats memory loses its own row only, and says so there. Finished jobs are skipped when the
same call is made again.
"""

from ._child import run_one
from ._job import Job
from ._run import Summary, run
from ._table import read_manifest, read_rows, write_rows

__all__ = ["Job", "Summary", "read_manifest", "read_rows", "run", "run_one", "write_rows"]
