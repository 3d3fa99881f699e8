"""carreau in FreeCAD, for macros as for the workbench's commands.

    import carreau_freecad

    (solid,) = carreau_freecad.cad(App.ActiveDocument.Mesh)
    carreau_freecad.quads(App.ActiveDocument.Mesh, quads=2000, deadline=60)

Every function takes a mesh of the document (`Mesh::Feature`) and the options of carreau's command of the same kind as
keywords, with underscores; it returns new objects of the document, at the placement of the mesh. Lengths are in
millimetres, or shares of the diagonal ("1%"). A run that comes to nothing raises `Failure` with `what`, `where` and
`remedy`, and changes nothing.
"""

from __future__ import annotations

from typing import Any

from .child import Cancelled, Failure
from .operations import OPERATIONS, run

__all__ = ["OPERATIONS", "Cancelled", "Failure", "cad", "hexes", "info", "prepare", "quads", "remesh", "segment"]


def cad(mesh: Any, **options: Any) -> list[Any]:
    """A CAD model: one `Part::Feature` for every body, with the kinds, names and colours of its faces."""
    return run("cad", mesh, options)


def quads(mesh: Any, *, triangles: bool = False, **options: Any) -> list[Any]:
    """A mesh of quads: a FEM mesh of shell elements, or with `triangles` a `Mesh::Feature` of its halves."""
    return run("quads", mesh, {**options, "as_triangles": triangles})


def remesh(mesh: Any, **options: Any) -> list[Any]:
    """A graded mesh: by an angle (`deviation`), a number of `triangles` or a `distance`."""
    return run("remesh", mesh, options)


def segment(mesh: Any, **options: Any) -> list[Any]:
    """The faces of a part: a group with a mesh for each, named after its surface."""
    return run("segment", mesh, options)


def hexes(mesh: Any, **options: Any) -> list[Any]:
    """A FEM mesh of hexahedra of a tubular surface, with groups for its wall and its ends."""
    return run("hexes", mesh, options)


def prepare(mesh: Any, **options: Any) -> list[Any]:
    """A sound mesh: welded, oriented, without faces that are degenerate or there twice; holes filled on request."""
    return run("prepare", mesh, options)


def info(mesh: Any) -> dict[str, Any]:
    """Counts, topology and defects of a mesh: the record of `carreau info`, with its `summary`."""
    return run("info", mesh, {})
