"""Meshes of FreeCAD as files, in their own coordinates."""

from __future__ import annotations

import re
from typing import Any

import FreeCAD as App

from . import ply

__all__ = ["read_medit", "step_face_names", "write_local"]


def write_local(feature: Any, path: str) -> None:
    """Writes the mesh of a feature without its placement."""
    mesh = feature.Mesh.copy()
    mesh.Placement = App.Placement()
    points, faces = mesh.Topology
    ply.write(path, points, faces)


def read_medit(path: str) -> dict[str, list[tuple[float, ...]]]:
    """The sections of a Medit text file: rows of numbers, ids counted from 1, the reference last."""
    with open(path, encoding="ascii") as file:
        words = file.read().split()
    sections: dict[str, list[tuple[float, ...]]] = {}
    widths = {"Vertices": 4, "Quadrilaterals": 5, "Hexahedra": 9}
    at = 0
    while at < len(words):
        width = widths.get(words[at])
        if width is None:
            at += 1
            continue
        count, start = int(words[at + 1]), at + 2
        numbers = [float(word) for word in words[start : start + count * width]]
        sections[words[at]] = list(zip(*[iter(numbers)] * width, strict=True))
        at = start + count * width
    return sections


_ENTITY = re.compile(r"^#(\d+)\s*=\s*([A-Z_0-9]+)\s*\((.*)\);\s*$")
_REFERENCE = re.compile(r"#(\d+)")


def step_face_names(path: str) -> list[str]:
    """The names of the faces of a STEP file, in the order in which its bodies and their shells list them."""
    entities: dict[str, tuple[str, str]] = {}
    with open(path, encoding="utf-8") as file:
        for line in file:
            if found := _ENTITY.match(line):
                entities[found[1]] = found[2], found[3]
    names = []
    for kind, arguments in entities.values():
        if kind in ("MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS", "SHELL_BASED_SURFACE_MODEL"):
            names += _below(arguments, entities)
    return names


def _below(arguments: str, entities: dict[str, tuple[str, str]]) -> list[str]:
    names = []
    for reference in _REFERENCE.findall(arguments):
        kind, inner = entities[reference]
        if kind == "ADVANCED_FACE":
            names.append(inner.split("'")[1])
        elif kind in ("CLOSED_SHELL", "OPEN_SHELL", "ORIENTED_CLOSED_SHELL"):
            names += _below(inner, entities)
    return names
