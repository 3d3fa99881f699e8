"""One job in a child process, watched: what crashes, hangs or eats memory there takes nothing else along."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ._job import Job

__all__ = ["end_child", "lost", "run_one"]

#: Seconds between two looks at the child.
_POLL = 0.02
#: Seconds that the child is given to keep its own deadline.
_GRACE = 5.0
#: Letters of a message that are kept.
_MESSAGE = 1000
#: The exit code of a job whose worker died.
_LOST = 70
_DEADLINE, _KILLED = 124, 137
Row = dict[str, Any]


def run_one(job: Job | Mapping[str, Any], children: set[int] | None = None) -> Row:
    """Run a job in a child process and tell what came of it.

    Never raises: what goes wrong is in the row.

    Parameters
    ----------
    job : Job or mapping
        The job, or its attributes.
    children : set of int, optional
        Holds the child's id while it runs, for who wants to end it.

    Returns
    -------
    dict
        ``hash``, ``file``, ``verb``, ``options`` (JSON), ``exit_code`` (the command line's; 128 + n for signal n, 124
        beyond the deadline, 137 beyond the memory), ``seconds``, ``peak_memory_mb``, ``output``, ``message``, and every
        number and word of the result record, such as ``input.faces``, ``output.faces`` and ``quality.shape_min``.
    """
    start = time.monotonic()
    row: Row = {}
    try:
        job = job if isinstance(job, Job) else Job.of(job, {})
        row = _head(job)
        with tempfile.TemporaryDirectory(prefix="carreau-") as folder:
            row |= _run(job, Path(folder), set() if children is None else children)
    except Exception as error:
        row |= {
            "exit_code": getattr(error, "exit_code", _LOST),
            "message": f"{type(error).__name__}: {error}"[:_MESSAGE],
        }
    row["seconds"] = round(time.monotonic() - start, 4)
    return row


def end_child(child: int) -> None:
    """End a child and all processes that it started."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(child, signal.SIGKILL)


def lost(job: Job, why: str) -> Row:
    """The row of a job whose worker died."""
    return _head(job) | {"exit_code": _LOST, "message": why[:_MESSAGE]}


def _head(job: Job) -> Row:
    head = {"hash": job.key(), "file": job.file, "verb": job.verb, "options": job.options_text()}
    rest = {"exit_code": None, "seconds": None, "peak_memory_mb": None, "output": job.output, "message": ""}
    return head | rest


def _run(job: Job, folder: Path, children: set[int]) -> Row:
    record, messages, told = folder / "record.json", folder / "stderr", folder / "peak"
    environment = os.environ | ({"CARREAU_PEAK_FILE": str(told)} if sys.platform == "linux" else {})
    command = list(job.command or (sys.executable, "-I", str(Path(__file__).with_name("_launch.py"))))
    words = job.arguments()
    written = ["--json", str(record), *(["--output", job.output] if job.output else [])]
    limit = ["--deadline", repr(job.deadline)] if job.deadline else []
    # Options come before the input, which stands behind a double dash.
    command += [words[0], *written, *limit, *words[1:]]
    with open(messages, "wb") as stderr, open(os.devnull, "r+b") as null:
        child = subprocess.Popen(
            command, stdin=null, stdout=null, stderr=stderr, env=environment, start_new_session=True
        )
        with _ended(child, children):
            code, peak, reason = _watch(child, job)
    if told.exists():
        peak = round(int(told.read_text()) / 1024, 1)
    message = reason or _last_words(messages, code)
    row = {"exit_code": code, "peak_memory_mb": peak, "message": message}
    return row | (_flat(json.loads(record.read_text("utf-8"))) if code == 0 and record.exists() else {})


@contextlib.contextmanager
def _ended(child: subprocess.Popen[bytes], children: set[int]) -> Iterator[None]:
    """Whatever happens to us, the child does not outlive the job, nor do processes that it started."""
    children.add(child.pid)
    try:
        yield
    finally:
        children.discard(child.pid)
        end_child(child.pid)
        if child.returncode is None:
            child.wait()


def _watch(child: subprocess.Popen[bytes], job: Job) -> tuple[int, float | None, str]:
    """Exit code, peak memory in megabytes, and why the child was ended, if it was."""
    before = _memory("self", "VmHWM")
    end = time.monotonic() + job.deadline + _GRACE if job.deadline else None
    reason, forced, peak, pause = "", None, None, 0.001
    while True:
        pid, status, usage = os.wait4(child.pid, os.WNOHANG)
        if pid:
            break
        peak = _memory(child.pid, "VmHWM") or peak
        if forced is None and job.memory and (peak or 0.0) > job.memory:
            reason, forced = f"ended: more than {job.memory:g} MB of memory", _KILLED
        if forced is None and end is not None and time.monotonic() > end:
            reason, forced = f"ended: no end {_GRACE:g} s after the deadline of {job.deadline:g} s", _DEADLINE
        if forced is not None:
            end_child(child.pid)
        time.sleep(pause)
        # Small jobs are not made to wait, long ones cost nothing.
        pause = min(1.5 * pause, _POLL)
    child.returncode = os.waitstatus_to_exitcode(status)
    code = child.returncode if child.returncode >= 0 else 128 - child.returncode
    # The system's figure includes what this process held when it started the child: it is the child's own only above
    # that.
    total = usage.ru_maxrss / (1 << 10 if sys.platform != "darwin" else 1 << 20)
    if peak is None or before is None or total > before:
        peak = total
    return (code if forced is None else forced), round(peak, 1), reason


def _memory(pid: int | str, field: str) -> float | None:
    """A figure of the system about a process, in megabytes; None where it has none."""
    try:
        with open(f"/proc/{pid}/status", encoding="ascii", errors="replace") as file:
            line = next((line for line in file if line.startswith(field)), None)
    except OSError:
        return None
    return int(line.split()[1]) / 1024 if line else None


def _last_words(messages: Path, code: int) -> str:
    if code == 0:
        return ""
    said = messages.read_text("utf-8", "replace").strip()[-_MESSAGE:]
    if code > 128:
        with contextlib.suppress(ValueError):
            name = signal.Signals(code - 128).name
            return f"killed by {name}: {said}" if said else f"killed by {name}"
    return said.removeprefix("carreau: ")


def _flat(record: Mapping[str, Any]) -> Row:
    """Numbers and words of a record, by their path; lists are left out."""
    row: Row = {}

    def add(prefix: str, value: Any) -> None:
        if isinstance(value, Mapping):
            for name, item in value.items():
                add(f"{prefix}.{name}" if prefix else name, item)
        elif isinstance(value, (bool, int, float, str)):
            row[prefix] = value

    add("", {name: value for name, value in record.items() if name not in ("options", "seconds", "verb", "warnings")})
    row["warnings"] = len(record.get("warnings", ()))
    row.pop("input.file", None)
    row.pop("output.file", None)
    row["version"] = row.pop("carreau", None)
    return row
