"""How a keyword call becomes a run: names are checked, values turned into the command line's words."""

from __future__ import annotations

import contextlib
import difflib
import json
import numbers
import os
import re
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

import numpy as np

from . import _core
from ._errors import CarreauWarning, OptionsError
from ._frozen import thaw
from ._mesh import Mesh, Skeleton, as_edges
from ._results import Result

__all__ = ["run"]

#: Seconds after which a run that goes on shows its progress.
_SILENT = 1.0
R = TypeVar("R", bound=Result)
#: Called with the name of a stage and the share of it that is done.
Watch = Callable[[str, float], None]


def run(verb: str, kind: type[R], inputs: tuple[Any, ...], options: dict[str, Any], progress: bool | Watch | None) -> R:
    """Run a verb.

    `inputs` are meshes, skeletons or files; `options` are its keyword arguments, None where not given.
    """
    job = _Job(verb, inputs, options)
    with _replay(job.options), _watch(progress, job.quiet) as watch:
        try:
            found = _core.call(verb, job.names, list(job.options.items()), job.hosted, watch)
        except OptionsError as error:
            raise OptionsError(_as_keywords(str(error))) from None
    result = kind(found, job.source, job.mesh)
    if not job.quiet:
        for warning in result.warnings:
            warnings.warn(warning, CarreauWarning, stacklevel=3)
    return result


class _Job:
    """The arguments of a native call."""

    def __init__(self, verb: str, inputs: tuple[Any, ...], options: dict[str, Any]) -> None:
        self.verb = verb
        self.hosted: dict[str, Any] = {}
        #: The first input, where it is a mesh.
        self.mesh: Mesh | None = None
        self.quiet = bool(options.get("quiet"))
        given = {name: value for name, value in options.items() if value is not None}
        _check_names(verb, given)
        main = self._with_attributes(inputs[0], given) if inputs else None
        self.names = [self._input(item) for item in (main, *inputs[1:])]
        self.source = self.names[0]
        self.options = {name.replace("_", "-"): self._value(name, value) for name, value in given.items()}

    def _with_attributes(self, mesh: Any, given: dict[str, Any]) -> Any:
        """Labels and sizes given as arrays become attributes of the mesh, which options name."""
        for option, kind in (("labels", "face"), ("sizes", "vertex")):
            value = given.get(option)
            if value is None or isinstance(value, (str, os.PathLike)):
                continue
            name = f"{option} of the call"
            mesh = _as_mesh(mesh).with_attributes(**{kind: {name: value}})
            given[option] = name
        return mesh

    def _input(self, item: Any) -> str:
        """The name of an input: a file's own, or that under which it is hosted."""
        if isinstance(item, (str, os.PathLike)):
            return os.fspath(item)
        if isinstance(item, Skeleton):
            return self._host("skeleton", item._native)
        mesh = _as_mesh(item)
        self.mesh = self.mesh or mesh
        return self._host(mesh.source, mesh._native)

    def _host(self, name: str, what: Any) -> str:
        while name in self.hosted:
            name += "'"
        self.hosted[name] = what
        return name

    def _value(self, name: str, value: Any) -> str | bool:
        if name == "features" and not isinstance(value, (str, os.PathLike)):
            return self._host("<features>", as_edges(value))
        if isinstance(value, Skeleton):
            return self._host(f"<{name}>", value._native)
        if isinstance(value, Mesh):
            return self._host(f"<{name}>", value._native)
        if name == "options" and not isinstance(value, (str, os.PathLike)):
            return _options_text(value)
        return _word(name, value)


def _as_mesh(item: Any) -> Mesh:
    if isinstance(item, Mesh):
        return item
    if isinstance(item, (str, os.PathLike)):
        from ._mesh import read

        mesh = read(item)
        if isinstance(mesh, Mesh):
            return mesh
    if isinstance(item, tuple) and len(item) == 2:
        return Mesh(*item)
    kind = type(item).__module__.split(".")[0]
    hint = f": convert it by cr.from_{kind}" if kind in ("trimesh", "meshio", "pyvista") else ""
    raise TypeError(f"a Mesh, a file or a pair (points, faces) is expected, not {type(item).__name__}{hint}")


def _check_names(verb: str, given: Mapping[str, Any]) -> None:
    known = [name.replace("-", "_") for name in _core.option_names(verb)]
    for name in given:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=3)
            hint = f"; did you mean {' or '.join(map(repr, near))}?" if near else ""
            raise TypeError(f"{verb}() got an unexpected keyword argument '{name}'{hint}")


def _word(name: str, value: Any) -> str | bool:
    """A value as the command line spells it."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    raise TypeError(f"{name} is a number, a word or a path, not {type(value).__name__}")


def _options_text(value: Any) -> str:
    """Options of an earlier run, as text: a result, its record or a mapping of options."""
    if isinstance(value, Result):
        return value.to_json()
    if isinstance(value, Mapping):
        return json.dumps(thaw(value))
    raise TypeError(f"options is a file, a result or a mapping, not {type(value).__name__}")


@contextlib.contextmanager
def _replay(options: dict[str, str | bool]) -> Iterator[None]:
    """The command line replays files: options given as text are put into one for the time of the call."""
    text = options.get("options")
    if not isinstance(text, str) or not text.lstrip().startswith("{"):
        yield
        return
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "options.json")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        options["options"] = path
        yield


def _as_keywords(message: str) -> str:
    """Options named as keyword arguments."""
    return re.sub(r"--([a-z][a-z-]*[a-z])(?: <[^>]*>)?", lambda m: m[1].replace("-", "_"), message)


@contextlib.contextmanager
def _watch(progress: bool | Watch | None, quiet: bool) -> Iterator[Watch | None]:
    """Who is told of the progress: a function, a bar of tqdm, or nobody."""
    if callable(progress):
        yield progress
        return
    wanted = progress is True or (progress is None and not quiet and _is_watched())
    bar = _bar() if wanted else None
    if bar is None:
        yield None
        return

    start, shown = time.monotonic(), ("", 0)

    def show(stage: str, share: float) -> None:
        nonlocal shown
        now = stage, round(100 * share)
        # Short runs show none.
        if now != shown and time.monotonic() - start > _SILENT:
            shown = now
            bar.set_description(stage, refresh=False)
            bar.n = now[1]
            bar.refresh()

    with bar:
        yield show


def _is_watched() -> bool:
    """Whether somebody looks: a terminal or a notebook."""
    return "ipykernel" in sys.modules or (sys.stderr is not None and sys.stderr.isatty())


def _bar() -> Any:
    try:
        with warnings.catch_warnings():
            # It says that a notebook without widgets gets a bar of text.
            warnings.simplefilter("ignore")
            from tqdm.auto import tqdm
    except ImportError:
        return None
    # The delay keeps it from showing itself before it is told anything.
    return tqdm(total=100, leave=False, delay=_SILENT, bar_format="{desc} {bar} {percentage:.0f} % {elapsed}")
