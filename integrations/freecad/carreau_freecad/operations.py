"""What the workbench does: a verb of carreau, the options that matter, and what becomes of the result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import FreeCAD as App

from . import insert, settings
from .child import Child, Failure, attend, find
from .meshes import write_local
from .resources import translated

__all__ = ["OPERATIONS", "Job", "Operation", "Option", "run"]


def _noop(text: str) -> str:
    """Marks a text for the translators; it is translated where it is shown."""
    return text


@dataclass(frozen=True)
class Option:
    """An option of the task panel.

    A choice has `choices`, a switch a default of True or False, a number one that is a number, a length or an angle a
    text; an empty text and the number 0 mean what carreau does by itself.
    """

    name: str
    label: str
    default: Any
    tip: str
    choices: tuple[str, ...] = ()


@dataclass(frozen=True)
class Operation:
    """A command: title and tip for a person, the verb, the file that it writes, what takes that into the document."""

    verb: str
    title: str
    tip: str
    output: str
    insert: Callable[[insert.Source, dict[str, Any], str, dict[str, Any]], list[Any]] | None
    options: tuple[Option, ...] = ()


_KEEP = Option(
    "keep",
    _noop("Pieces"),
    "all",
    _noop("all: every piece; largest: the largest body and its cavities"),
    ("all", "largest"),
)
_ANGLE = Option(
    "feature_angle",
    _noop("Sharp edges above"),
    "",
    _noop("Degrees; empty: creases at the size of the result; 180: none"),
)

OPERATIONS: dict[str, Operation] = {
    "cad": Operation(
        "cad",
        _noop("CAD model"),
        _noop("A solid with exact faces, named and coloured by their kind"),
        "result.step",
        insert.cad,
        (
            Option(
                "tolerance",
                _noop("Tolerance"),
                "",
                _noop("Largest distance of a vertex from its face; empty: from the data"),
            ),
            _KEEP,
        ),
    ),
    "quads": Operation(
        "quad",
        _noop("Quads"),
        _noop("A mesh of quads that keeps every sharp edge"),
        "result.ply",
        insert.quads,
        (
            Option("quads", _noop("Number of quads"), 3000, _noop("Met within 10 % where the sharp edges allow it")),
            _ANGLE,
            Option(
                "symmetry",
                _noop("Symmetry"),
                "off",
                _noop("x, y, z: across that axis; auto: across the planes of symmetry that the mesh has"),
                ("off", "x", "y", "z", "auto"),
            ),
            Option("adaptive", _noop("Adaptive sizes"), False, _noop("Smaller quads where the surface bends")),
            Option(
                "as_triangles",
                _noop("As a mesh of triangles"),
                False,
                _noop("Each quad cut in two, for the Mesh workbench"),
            ),
        ),
    ),
    "remesh": Operation(
        "simplify",
        _noop("Remesh"),
        _noop("A graded mesh of fewer triangles that keeps every sharp edge"),
        "result.ply",
        insert.mesh,
        (
            Option(
                "deviation",
                _noop("Angle to the surface"),
                "",
                _noop("Degrees between edges and the surface; empty: 14"),
            ),
            Option(
                "triangles",
                _noop("Number of triangles"),
                0,
                _noop("In place of the angle; 0: as many as the angle takes"),
            ),
            _ANGLE,
        ),
    ),
    "segment": Operation(
        "segment",
        _noop("Segment"),
        _noop("The faces of a part as a group of meshes, each with its surface"),
        "result.ply",
        insert.segment,
        (
            Option(
                "regions", _noop("Number of faces"), 0, _noop("Faces are merged down to this number; 0: from the data")
            ),
        ),
    ),
    "hexes": Operation(
        "hex",
        _noop("Hexes"),
        _noop("A FEM mesh of hexahedra along the branches of a tubular part"),
        "result.mesh",
        insert.hexes,
        (
            Option("hexes", _noop("Number of cells"), 0, _noop("About this many, at most; 0: from the shape")),
            Option(
                "padding",
                _noop("Layer on the boundary"),
                "all",
                _noop("Where one more layer of cells goes"),
                ("all", "sides", "none"),
            ),
        ),
    ),
    "prepare": Operation(
        "repair",
        _noop("Prepare"),
        _noop("Welds, orients and drops what is degenerate or there twice"),
        "result.ply",
        insert.mesh,
        (
            Option(
                "weld",
                _noop("Weld below"),
                "",
                _noop("Vertices nearer than this become one; empty: those at equal positions"),
            ),
            _KEEP,
            Option(
                "fill_holes",
                _noop("Fill holes"),
                False,
                _noop("All of them, by the least area, smoothed like the surroundings"),
            ),
        ),
    ),
    "info": Operation("info", _noop("Info"), _noop("Counts, topology and defects with their places"), "", None),
}


class Job:
    """A run of an operation on a mesh of the document: `child` is to be started; `finish` makes the objects."""

    def __init__(self, name: str, mesh: Any, options: Mapping[str, Any]) -> None:
        if not getattr(mesh, "isDerivedFrom", lambda _: False)("Mesh::Feature"):
            raise Failure(
                f"{getattr(mesh, 'Label', mesh)} is no mesh",
                remedy="select a mesh; the Mesh workbench makes one of a shape",
                code=3,
            )
        if mesh.Mesh.CountFacets == 0:
            raise Failure(f"{mesh.Label} has no triangles", remedy="select a mesh that has some", code=3)
        self.operation = OPERATIONS[name]
        self.source = insert.Source.of(mesh)
        self.own = {name: value for name, value in options.items() if name in ("as_triangles",)}
        given = {**settings.common(), **options}
        words = {name.replace("_", "-"): value for name, value in given.items() if name not in self.own}
        self.child = Child(find(settings.path()), self.operation.verb, words, mesh.Label)
        write_local(mesh, self.child.path("source.ply"))
        self.files = "source.ply", self.operation.output

    def finish(self) -> Any:
        """The new objects, as one step for Undo; of an operation that makes none the record."""
        try:
            record = self.child.finish()
        except Failure as failure:
            # The verb's name in the window.
            failure.remedy = failure.remedy.replace("`carreau repair`", translated(OPERATIONS["prepare"].title))
            raise
        for text in record["warnings"]:
            App.Console.PrintWarning(f"carreau: {text}\n")
        for text in record["summary"]:
            App.Console.PrintMessage(f"carreau: {text}\n")
        if self.operation.insert is None:
            return record
        document = self.source.document()
        document.openTransaction(f"carreau {self.operation.verb}")
        try:
            made = self.operation.insert(self.source, record, self.child.path(self.operation.output), self.own)
            insert.hide(self.source)
        except BaseException:
            document.abortTransaction()
            raise
        document.commitTransaction()
        document.recompute()
        return made


def run(name: str, mesh: Any, options: Mapping[str, Any]) -> Any:
    """Runs an operation to its end; in the window with FreeCAD's progress bar, and Esc ends it."""
    job = Job(name, mesh, options)
    with job.child, _Bar(job.operation.title) as bar:
        attend(job.child, *job.files, watch=bar)
        return job.finish()


class _Bar:
    """FreeCAD's progress bar, where there is a window; called as `child.Watch`."""

    STEPS = 100

    def __init__(self, title: str) -> None:
        self._title, self._at = title, 0
        self._indicator: Any = None

    def __enter__(self) -> _Bar:
        if App.GuiUp:
            self._indicator = App.Base.ProgressIndicator()
            self._indicator.start(f"carreau: {self._title}", self.STEPS)
        return self

    def __exit__(self, *_: object) -> None:
        if self._indicator is not None:
            self._indicator.stop()

    def __call__(self, stage: str, share: float) -> bool:
        if self._indicator is None:
            return True
        # Each stage starts again; the bar only grows. A step at every look keeps the window alive and listens to Esc.
        wanted = max(self._at + 1, round(share * self.STEPS))
        try:
            while self._at < wanted:
                self._at += 1
                if self._at >= self.STEPS:
                    self._indicator.stop()
                    self._indicator.start(f"carreau: {self._title}: {stage}", self.STEPS)
                    self._at, wanted = 0, 0
                self._indicator.next(True)
        except Exception:  # its own kind, which has no name in Python
            return False
        return True
