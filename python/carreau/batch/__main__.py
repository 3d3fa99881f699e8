"""``python -m carreau.batch MANIFEST OUT``: a batch from a terminal."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from ._engines import ENGINES
from ._run import run
from ._table import _number


def main() -> int:
    """Run a manifest; exit code 0 when every job ended well, 4 when some did not."""
    parser = argparse.ArgumentParser("python -m carreau.batch", description="Runs carreau on every file of a manifest.")
    parser.add_argument("manifest", help="table of jobs: .csv, .jsonl or .parquet with the column file")
    parser.add_argument("out", help="table of rows to write: .csv, .jsonl or .parquet")
    parser.add_argument("--engine", choices=list(ENGINES), default="local")
    parser.add_argument("--address", help="the cluster, for dask and ray")
    parser.add_argument("--workers", type=int, help="jobs at a time")
    parser.add_argument("--verb", help="verb of rows that name none")
    parser.add_argument("--deadline", type=float, help="seconds per job")
    parser.add_argument("--memory", type=float, help="megabytes per job")
    parser.add_argument("--retry", action="store_true", help="run jobs again that failed before")
    parser.add_argument(
        "-O", "--option", action="append", default=[], metavar="NAME=VALUE", help="an option of the verb"
    )
    given = vars(parser.parse_args())
    options = dict(pair.partition("=")[::2] for pair in given.pop("option"))
    given["options"] = {name: _number(value) for name, value in options.items()}
    if given["address"] is None:
        del given["address"]
    summary = run(given.pop("manifest"), given.pop("out"), watch=_tell, **given)
    sys.stderr.write(
        f"{summary.jobs} jobs: {summary.done} done, {summary.failed} failed, {summary.skipped} skipped, "
        f"{summary.seconds:.1f} s\n"
    )
    return 4 if summary.failed else 0


def _tell(row: dict[str, Any]) -> None:
    if row["exit_code"] != 0:
        sys.stderr.write(f"{row['file']}: exit code {row['exit_code']}: {row['message']}\n")


if __name__ == "__main__":
    sys.exit(main())
