"""Manifests and tables of rows: CSV, JSON lines, Parquet (needs pyarrow)."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ._job import Job

#: Columns whose cells are words, whatever they look like.
_WORDS = frozenset({"hash", "file", "verb", "options", "output", "message", "version"})

__all__ = ["Journal", "Name", "name_of", "read_manifest", "read_rows", "write_rows"]

Row = dict[str, Any]
#: What tells a row from others: hash, file, output. Two files may have the same bytes.
Name = tuple[str, str, str]


def read_manifest(manifest: str | os.PathLike[str] | Iterable[Any], **defaults: Any) -> Iterator[Job]:
    """The jobs of a manifest.

    Parameters
    ----------
    manifest : path or iterable
        A table (.csv, .jsonl, .parquet) with a job per row, or jobs, mappings or names of files. Columns are ``file``,
        ``verb``, ``output``, ``deadline``, ``memory``; all others are options of the verb, as is a mapping ``options``.
    **defaults
        What rows leave open.
    """
    rows = read_rows(manifest) if isinstance(manifest, (str, os.PathLike)) else manifest
    for row in rows:
        if isinstance(row, Job):
            yield row
        elif isinstance(row, Mapping):
            yield Job.of(row, defaults)
        else:
            yield Job.of({"file": os.fspath(row)}, defaults)


def read_rows(path: str | os.PathLike[str]) -> Iterator[Row]:
    """The rows of a table."""
    path = Path(path)
    if path.suffix == ".csv":
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                yield {name: value if name in _WORDS else _number(value) for name, value in row.items() if value}
    elif path.suffix in (".jsonl", ".ndjson"):
        with open(path, encoding="utf-8") as file:
            yield from (json.loads(line) for line in file if line.strip())
    elif path.suffix == ".parquet":
        yield from _parquet().read_table(path).to_pylist()
    else:
        raise ValueError(f"{path}: a table ends in .csv, .jsonl or .parquet")


def write_rows(path: str | os.PathLike[str], rows: list[Row]) -> None:
    """Write a table, whole or not at all."""
    path = Path(path)
    names = list(dict.fromkeys(name for row in rows for name in row))
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    if path.suffix == ".csv":
        with open(part, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, names)
            writer.writeheader()
            writer.writerows(rows)
    elif path.suffix in (".jsonl", ".ndjson"):
        part.write_text("".join(f"{json.dumps(row)}\n" for row in rows), "utf-8")
    elif path.suffix == ".parquet":
        import pyarrow

        columns = {name: _column([row.get(name) for row in rows]) for name in names}
        _parquet().write_table(pyarrow.table(columns), part)
    else:
        raise ValueError(f"{path}: a table ends in .csv, .jsonl or .parquet")
    os.replace(part, path)


def name_of(row: Mapping[str, Any]) -> Name:
    """What tells a row from others."""
    return row["hash"], row["file"], row.get("output") or ""


class Journal:
    """Rows as they come, a line each: what a run that was stopped has finished.

    The journal stands beside the table and is removed once that is written.
    """

    def __init__(self, table: str | os.PathLike[str]) -> None:
        self._table = Path(table)
        self._path = self._table.with_name(f"{self._table.name}.journal")
        if self._table.suffix not in (".csv", ".jsonl", ".ndjson", ".parquet"):
            raise ValueError(f"{table}: a table ends in .csv, .jsonl or .parquet")
        if self._table.suffix == ".parquet":
            _parquet()
        self.rows = self._earlier()
        self._file = open(self._path, "a", encoding="utf-8")  # noqa: SIM115 - closed by `finish` or `close`

    def _earlier(self) -> dict[Name, Row]:
        rows = {name_of(row): row for row in read_rows(self._table)} if self._table.exists() else {}
        if self._path.exists():
            for line in self._path.read_text("utf-8").splitlines():
                try:
                    row = json.loads(line)
                except ValueError:
                    # The machine stopped in the middle of a line.
                    continue
                rows[name_of(row)] = row
            # A half line must not swallow the next one.
            self._path.write_text("".join(f"{json.dumps(row)}\n" for row in rows.values()), "utf-8")
        return rows

    def add(self, row: Row) -> None:
        """Keep a row."""
        self.rows[name_of(row)] = row
        self._file.write(json.dumps(row) + "\n")
        self._file.flush()

    def finish(self, order: Iterable[Name]) -> None:
        """Write the table: the rows of these jobs, in their order, and earlier ones behind them."""
        names = dict.fromkeys([*order, *self.rows])
        write_rows(self._table, [self.rows[name] for name in names if name in self.rows])
        self.close()
        self._path.unlink(missing_ok=True)

    def close(self) -> None:
        """Stop keeping rows."""
        self._file.close()


def _parquet() -> Any:
    try:
        import pyarrow.parquet
    except ImportError as error:
        raise ImportError("Parquet needs pyarrow: pip install 'carreau[batch]'") from error
    return pyarrow.parquet


def _column(values: list[Any]) -> list[Any]:
    """One type per column: words where numbers and words are mixed."""
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int, float} or len(kinds) <= 1:
        return [float(v) if v is not None and float in kinds else v for v in values]
    return [None if value is None else str(value) for value in values]


def _number(text: str) -> Any:
    """A cell of CSV as JSON would have it: numbers, true, false, lists; other words as they are."""
    if text in ("True", "False"):
        return text == "True"
    try:
        return json.loads(text)
    except ValueError:
        return text
