"""carreau as a child process: what the add-ons for FreeCAD and Blender have in common.

The child works on files in a temporary folder. It cannot take the host with it when it fails, is ended within half a
second, and the host goes on meanwhile. This module needs the standard library alone and knows no host.

Two programs do the same work: the executable `carreau`, and the Python package of that name, run by this very file in a
process of its own (`serve`). The executable tells which stage it has finished, the package the share of each, too.
"""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

__all__ = ["CANCELLED", "Cancelled", "Child", "Failure", "attend", "find"]

#: Exit codes of the contract that the add-ons tell apart.
CANCELLED = 130
BUG = 70
#: Seconds between two looks at a child: the host's display keeps up with it.
POLL = 0.05
#: Seconds that a child has to end itself after it was asked to; a child that listens needs a tenth of that.
PATIENCE = 0.5
#: How `serve` marks what it tells on stderr.
PROGRESS, FAILURE = "@progress ", "@failure "
#: How warnings about the files that are exchanged begin.
EXCHANGED = ("OBJ", "PLY", "Medit")
#: Called with the stage and the share of it that is done (below 0 where that is unknown); an answer of False cancels.
Watch = Callable[[str, float], Any]


class Failure(Exception):
    """A run that came to nothing: what is wrong, where, and what can be done about it."""

    def __init__(self, what: str, where: str = "", remedy: str = "", code: int = BUG) -> None:
        super().__init__(what)
        self.what, self.where, self.remedy, self.code = what, where, remedy, code

    def lines(self) -> list[str]:
        """The message for a person, one line a part."""
        return [self.what] + [
            f"{name}: {text}" for name, text in (("Where", self.where), ("Remedy", self.remedy)) if text
        ]


class Cancelled(Failure):
    """The user ended the run."""

    def __init__(self) -> None:
        super().__init__("cancelled", code=CANCELLED)


def find(preferred: str = "") -> list[str]:
    """The beginning of carreau's command line.

    That is the executable `preferred` where it is given; else the Python package of this interpreter; else the
    executable on the path, or where cargo and pip put it.
    """
    if preferred:
        path = os.path.expanduser(preferred)
        if os.path.isdir(path):
            path = os.path.join(path, _executable("carreau"))
        if not os.access(path, os.X_OK) or not os.path.isfile(path):
            raise Failure(f"{preferred} is no program", remedy="correct the path of carreau in the preferences", code=5)
        return [path]
    if _package("carreau") and (python := interpreter()):
        return [python, os.path.abspath(__file__)]
    homes = [Path.home() / ".cargo" / "bin", Path.home() / ".local" / "bin"]
    for folder in (None, *map(str, homes)):
        if found := shutil.which("carreau", path=folder):
            return [found]
    raise Failure(
        "carreau is not installed",
        remedy="install its Python package, put the program on the PATH, or name it in the preferences",
        code=5,
    )


def _package(name: str) -> str:
    """The folder that a package lies in; empty: it is not installed. A mere folder of that name is none."""
    found = importlib.util.find_spec(name)
    return os.path.dirname(os.path.dirname(found.origin)) if found is not None and found.origin else ""


def interpreter() -> str | None:
    """A Python of the version that runs here: `sys.executable` is often the host itself."""
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    if os.path.basename(sys.executable or "").lower().startswith("python"):
        return sys.executable
    folders = [os.path.join(sys.prefix, "bin"), sys.prefix, os.path.dirname(sys.executable or "")]
    for folder in folders:
        for name in (version, "python3", "python"):
            path = os.path.join(folder, _executable(name))
            if os.path.isfile(path) and os.access(path, os.X_OK):
                return path
    return shutil.which(version)


def _executable(name: str) -> str:
    return f"{name}.exe" if os.name == "nt" else name


class Child:
    """A run of one verb.

    `options` are those of the command line, without dashes: True stands alone, None and False are left out. The input
    is written by the caller to `child.path(NAME)` before `start`, the output is there after `finish`.
    """

    def __init__(self, command: list[str], verb: str, options: Mapping[str, Any], label: str = "") -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="carreau-")
        self._command, self.verb, self._options, self._label = command, verb, dict(options), label
        self._process: subprocess.Popen[str] | None = None
        self._reader: threading.Thread | None = None
        self._said: list[str] = []
        self._failure: Failure | None = None
        self._asked: float | None = None
        self._input = ""
        #: The stage that is told, and the share of it that is done; below 0 where that is unknown.
        self.stage, self.share = "", -1.0

    def path(self, name: str) -> str:
        """A file in the folder of the run."""
        return os.path.join(self._folder.name, name)

    def option(self, name: str, value: Any) -> None:
        """One more option, such as a file in the folder of the run."""
        self._options[name] = value

    def start(self, source: str, output: str = "") -> None:
        """Starts the run on a file, both named as for `path`."""
        self._input = self.path(source)
        words = [self.verb, self._input, f"--json={self.path('record.json')}"]
        if output:
            words.append(f"--output={self.path(output)}")
        for name, value in self._options.items():
            if value is None or value is False:
                continue
            # In one word: a negative number would be taken for a flag.
            words.append(f"--{name}" if value is True else f"--{name}={_word(value)}")
        served = len(self._command) > 1
        with open(self.path("summary.txt"), "wb") as summary:
            self._process = subprocess.Popen(
                self._command + words + ([] if served else ["-v"]),
                stdin=subprocess.DEVNULL,
                stdout=summary,
                stderr=subprocess.PIPE,
                encoding="utf-8",
                errors="replace",
                env=_environment(served),
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        self._reader = threading.Thread(target=self._listen, daemon=True)
        self._reader.start()

    def _listen(self) -> None:
        assert self._process is not None and self._process.stderr is not None
        for line in self._process.stderr:
            line = line.strip()
            if line.startswith(PROGRESS):
                share, _, self.stage = line.removeprefix(PROGRESS).partition(" ")
                self.share = float(share)
            elif line.startswith(FAILURE):
                self._failure = Failure(**json.loads(line.removeprefix(FAILURE)))
            elif line.startswith("INFO ") and line.endswith(": close"):
                self.stage = line.rsplit('name="', 1)[-1].split('"', 1)[0]
            elif line:
                self._said.append(line)

    def done(self) -> bool:
        """Whether the run has ended; a child that was cancelled and does not listen is killed here."""
        if self._process is None or self._process.poll() is not None:
            return True
        if self._asked is not None and time.monotonic() - self._asked > PATIENCE:
            self._process.kill()
        return False

    def cancel(self) -> None:
        """Asks the child to end; see `done`."""
        if self._process is not None and self._asked is None:
            self._asked = time.monotonic()
            if self._process.poll() is None:
                self._process.send_signal(signal.SIGTERM)

    def finish(self) -> dict[str, Any]:
        """Waits for the end; the record of the run with the lines of its `summary` besides, or why there is none."""
        assert self._process is not None and self._reader is not None
        code = self._process.wait()
        # What the child started itself may hold its stderr for longer.
        self._reader.join(PATIENCE)
        if self._asked is not None or code == CANCELLED:
            raise Cancelled
        if code != 0:
            raise self._failed(code)
        with open(self.path("record.json"), encoding="utf-8") as file:
            record: dict[str, Any] = json.load(file)
        with open(self.path("summary.txt"), encoding="utf-8") as file:
            record["summary"] = [self._for_a_person(line) for line in file.read().splitlines()]
        # What the files between the host and carreau have no place for is the add-on's business.
        told = (text for text in record.get("warnings", []) if not text.startswith(EXCHANGED))
        record["warnings"] = [self._for_a_person(text) for text in told]
        return record

    def _failed(self, code: int) -> Failure:
        told = self._failure
        if told is None:
            # Its own words, those of the parser of its options, or whatever was said last.
            own = [line for line in self._said if line.startswith(("carreau: ", "error: "))]
            text = (own or self._said or [f"carreau ended with code {code}"])[-1]
            text = text.removeprefix("carreau: ").removeprefix("error: ")
            told = Failure(*_parts(self._for_a_person(text)), code=code if code > 0 else BUG)
        told.what = self._for_a_person(told.what)
        return told

    def _for_a_person(self, text: str) -> str:
        """The name of the object in place of that of its temporary file."""
        text = text.replace(self._input, self._label or os.path.basename(self._input))
        return text.replace(self._folder.name + os.sep, "")

    def close(self) -> None:
        """Ends the child if it goes on, and removes its folder."""
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        if self._reader is not None:
            self._reader.join(PATIENCE)
        self._folder.cleanup()

    def __enter__(self) -> Child:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def attend(child: Child, source: str, output: str = "", watch: Watch | None = None) -> None:
    """Starts a child and waits for its end; `watch` is called at every look, and may cancel."""
    child.start(source, output)
    while not child.done():
        if watch is not None and watch(child.stage, child.share) is False:
            child.cancel()
        time.sleep(POLL)


def _word(value: Any) -> str:
    return repr(value) if isinstance(value, float) else str(value)


def _parts(text: str) -> tuple[str, str, str]:
    """What, where and remedy of a message of the command line: `what; at where; remedy`."""
    what, _, rest = text.partition("; ")
    if not rest.startswith("at "):
        return what, "", rest
    where, _, remedy = rest.removeprefix("at ").partition("; ")
    return what, where, remedy


def _environment(served: bool) -> dict[str, str]:
    """The child's environment: the host's modules for the package, none of the host's own settings of Python for it."""
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONHOME", "PYTHONPATH")}
    if served:
        folders = dict.fromkeys(folder for name in ("carreau", "numpy") if (folder := _package(name)))
        environment["PYTHONPATH"] = os.pathsep.join(folders)
        environment["PYTHONIOENCODING"] = "utf-8"
    return environment


def serve(words: list[str]) -> int:
    """Runs a verb of the Python package and tells of it on stderr, as `Child` reads it."""
    import carreau

    verb, source, *rest = words
    options: dict[str, Any] = {}
    for word in rest:
        name, given, value = word.removeprefix("--").partition("=")
        options[name.replace("-", "_")] = value if given else True
    shown = ("", -1.0)

    def tell(stage: str, share: float) -> None:
        nonlocal shown
        now = stage, round(share, 2)
        if now != shown:
            shown = now
            print(f"{PROGRESS}{now[1]} {stage}", file=sys.stderr, flush=True)

    try:
        result = getattr(carreau, verb)(source, progress=tell, quiet=True, **options)
        print(*result.summary, sep="\n", flush=True)
    except carreau.Error as error:
        what = str(error)
        # The parts stand in the message, too.
        for part in (f"; {error.remedy}", f"; at {error.where}"):
            what = what.removesuffix(part)
        told = {"what": what, "where": error.where, "remedy": error.remedy, "code": error.exit_code}
        print(FAILURE + json.dumps(told), file=sys.stderr, flush=True)
        return int(error.exit_code)
    return 0


if __name__ == "__main__":
    sys.exit(serve(sys.argv[1:]))
