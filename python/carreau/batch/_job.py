"""A job: one run of the command line on one file."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Mapping
from typing import Any

from .. import _core

__all__ = ["Job"]

#: Bytes that are read at once.
_BLOCK = 1 << 20


@dataclasses.dataclass(frozen=True)
class Job:
    """One run of the command line on one file.

    Attributes
    ----------
    file : str
        The input.
    verb : str
        What is done with it.
    output : str, optional
        The file to write.
    options : mapping
        Options of the verb, as keyword arguments of its function.
    deadline : float, optional
        Seconds after which the child process is ended.
    memory : float, optional
        Megabytes above which the child process is ended (Linux).
    command : tuple of str, optional
        The program to run instead of carreau's own command line.
    """

    file: str
    verb: str
    output: str | None = None
    options: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    deadline: float | None = None
    memory: float | None = None
    command: tuple[str, ...] | None = None

    def options_text(self) -> str:
        """The options as JSON, always in the same order."""
        return json.dumps(dict(self.options), sort_keys=True)

    def key(self) -> str:
        """What makes a job the same job: the file's bytes, the verb, its options, and carreau's version.

        A file that cannot be read counts by its name.
        """
        digest = hashlib.sha256()
        try:
            with open(self.file, "rb") as file:
                while block := file.read(_BLOCK):
                    digest.update(block)
        except OSError:
            digest.update(b"\0unreadable\0" + os.fsencode(self.file))
        digest.update(b"\0".join(part.encode() for part in ("", self.verb, self.options_text(), _core.__version__)))
        return digest.hexdigest()

    def arguments(self) -> list[str]:
        """The words of the command line, without files for the record and the result.

        Raises
        ------
        OptionsError
            For a verb or an option that does not exist.
        """
        from .._call import _word

        words = [(name.replace("_", "-"), _word(name, value)) for name, value in self.options.items()]
        return _core.arguments(self.verb, [os.path.abspath(self.file)], words)

    @classmethod
    def of(cls, row: Mapping[str, Any], defaults: Mapping[str, Any]) -> Job:
        """A job of a manifest's row; what the row leaves open is taken from the defaults.

        Columns that are no attributes of a job are options; empty cells are left out.
        """
        given = {name: value for name, value in row.items() if value is not None and value != "" and value == value}
        merged = {name: value for name, value in defaults.items() if value is not None} | given
        attributes = {field.name for field in dataclasses.fields(cls)}
        options = _mapping(defaults.get("options")) | _mapping(given.get("options"))
        options |= {name: value for name, value in given.items() if name not in attributes}
        if missing := {"file", "verb"} - merged.keys():
            raise ValueError(f"a job has no {' and no '.join(sorted(missing))}: {dict(row)}")
        job = {name: merged[name] for name in attributes if name in merged}
        job["options"] = options
        for name in ("file", "output"):
            if name in job:
                job[name] = os.path.abspath(os.fspath(job[name]))
        for name in ("deadline", "memory"):
            if name in job:
                job[name] = float(job[name])
        if job.get("command") is not None:
            job["command"] = tuple(os.fspath(word) for word in job["command"])
        return cls(**job)


def _mapping(options: Any) -> dict[str, Any]:
    """Options as a mapping; tables have them as JSON."""
    return dict(json.loads(options) if isinstance(options, str) else options or {})
