"""What a run wrote becomes objects of the document, at the placement and in the group of the mesh."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import Any

import FreeCAD as App

from . import ply
from .child import Failure
from .meshes import read_medit, step_face_names

__all__ = ["Source", "cad", "hexes", "hide", "mesh", "quads", "segment"]

#: Colours of faces by the kind of their surface: a set that colour-blind people tell apart (Okabe and Ito).
COLOURS = {
    "plane": (0.60, 0.60, 0.60),
    "cylinder": (0.00, 0.45, 0.70),
    "cone": (0.00, 0.62, 0.45),
    "sphere": (0.90, 0.62, 0.00),
    "torus": (0.80, 0.47, 0.65),
    "extrusion": (0.34, 0.71, 0.91),
    "revolution": (0.94, 0.89, 0.26),
    "bspline": (0.84, 0.37, 0.00),
}
OTHER = (0.84, 0.37, 0.00)
#: The face property `primitive` of `carreau segment`.
PRIMITIVES = ("plane", "sphere", "cylinder", "cone", "torus", "freeform")


@dataclass(frozen=True)
class Source:
    """The mesh that a run is about, by name: it may be gone when the run ends."""

    document_name: str
    name: str
    label: str
    placement: Any

    @classmethod
    def of(cls, feature: Any) -> Source:
        return cls(feature.Document.Name, feature.Name, feature.Label, feature.Placement.copy())

    def document(self) -> Any:
        """The document, if it is still open."""
        if self.document_name not in App.listDocuments():
            raise Failure("the document of the mesh was closed", remedy="open it and run the command again", code=3)
        return App.getDocument(self.document_name)

    def feature(self) -> Any:
        """The mesh, or None where it was removed."""
        return self.document().getObject(self.name)

    def add(self, kind: str, name: str, label: str) -> Any:
        """A new object at the place of the mesh, in the same container."""
        made = self.document().addObject(kind, name)
        made.Label = label
        feature = self.feature()
        parents = [] if feature is None else [p for p in feature.InList if feature in getattr(p, "Group", ())]
        for parent in parents[:1]:
            # Some containers refuse some kinds, such as a body one that is no feature of it.
            with contextlib.suppress(Exception):
                parent.addObject(made)
        return made


def hide(source: Source) -> None:
    """Hides the mesh behind its result."""
    feature = source.feature()
    if App.GuiUp and feature is not None:
        feature.ViewObject.Visibility = False


def cad(source: Source, record: dict[str, Any], path: str, own: dict[str, Any]) -> list[Any]:
    """One `Part::Feature` for every body."""
    import Part

    shape = Part.Shape()
    shape.read(path)
    bodies = list(shape.Solids)
    bodies += [shell for shell in shape.Shells if not any(shell.isPartner(s) for solid in bodies for s in solid.Shells)]
    names = step_face_names(path)
    if len(names) != sum(len(body.Faces) for body in bodies):
        names = [f"face_{n}" for n in range(sum(len(body.Faces) for body in bodies))]
    made = []
    for body in bodies:
        mine, names = names[: len(body.Faces)], names[len(body.Faces) :]
        made.append(_part(source, body, mine))
    return made


def _part(source: Source, body: Any, names: list[str]) -> Any:
    part = source.add("Part::Feature", "CAD", f"{source.label} CAD")
    part.Shape = body
    part.Placement = source.placement
    colours = [COLOURS.get(name.rsplit("_", 1)[0], OTHER) for name in names]
    for kind, name, tip, value in (
        ("App::PropertyStringList", "FaceNames", "The name of every face: the kind of its surface and a number", names),
        ("App::PropertyColorList", "FaceColors", "The colour of every face", colours),
    ):
        part.addProperty(kind, name, "carreau", tip)
        setattr(part, name, value)
    if App.GuiUp:
        part.ViewObject.DiffuseColor = [(*colour, 0.0) for colour in colours]
    return part


def mesh(source: Source, record: dict[str, Any], path: str, own: dict[str, Any]) -> list[Any]:
    """A `Mesh::Feature`."""
    surface = ply.read(path)
    suffix = {"repair": "prepared", "simplify": "remeshed", "quad": "quads"}[record["verb"]]
    return [_mesh(source, surface.points, surface.faces, f"{source.label} {suffix}")]


def _mesh(source: Source, points: list[Any], faces: list[Any], label: str) -> Any:
    import Mesh

    made = source.add("Mesh::Feature", "Mesh", label)
    triangles = [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]
    made.Mesh = Mesh.Mesh(([App.Vector(*point) for point in points], triangles))
    made.Placement = source.placement
    return made


def quads(source: Source, record: dict[str, Any], path: str, own: dict[str, Any]) -> list[Any]:
    """A FEM mesh of shell elements: meshes of FreeCAD have triangles alone."""
    if own.get("as_triangles"):
        return mesh(source, record, path, own)
    surface = ply.read(path)
    made = _fem(source, surface.points, f"{source.label} quads")
    elements = made.FemMesh.copy()
    for number, face in enumerate(surface.faces, start=1):
        elements.addFace([v + 1 for v in face], number)
    made.FemMesh = elements
    return [made]


def _fem(source: Source, points: list[Any], label: str) -> Any:
    import Fem

    elements = Fem.FemMesh()
    for number, point in enumerate(points, start=1):
        elements.addNode(*point, number)
    made = source.add("Fem::FemMeshObject", "FEMMesh", label)
    made.FemMesh = elements
    made.Placement = source.placement
    return made


def segment(source: Source, record: dict[str, Any], path: str, own: dict[str, Any]) -> list[Any]:
    """A group with a mesh for every region; all lie where the mesh lies."""
    surface = ply.read(path)
    group = source.add("App::DocumentObjectGroup", "Faces", f"{source.label} faces")
    faces: dict[int, list[tuple[int, ...]]] = {}
    kinds: dict[int, str] = {}
    of_faces = surface.of_faces
    for face, region, kind in zip(surface.faces, of_faces["region"], of_faces["primitive"], strict=True):
        faces.setdefault(region, []).append(face)
        kinds[region] = PRIMITIVES[kind]
    for region in sorted(faces):
        used = sorted({v for face in faces[region] for v in face})
        number = {v: n for n, v in enumerate(used)}
        triangles = [tuple(number[v] for v in face) for face in faces[region]]
        piece = _mesh(source, [surface.points[v] for v in used], triangles, f"{kinds[region]}_{region}")
        group.addObject(piece)
        if App.GuiUp:
            piece.ViewObject.ShapeColor = COLOURS.get(kinds[region], OTHER)
    return [group]


def hexes(source: Source, record: dict[str, Any], path: str, own: dict[str, Any]) -> list[Any]:
    """A FEM mesh of hexahedra with its boundary in groups by their tags; in the active analysis if there is one."""
    sections = read_medit(path)
    made = _fem(source, [row[:3] for row in sections["Vertices"]], f"{source.label} hexes")
    elements = made.FemMesh.copy()
    number = 0
    tags: dict[int, list[int]] = {}
    for row in sections.get("Quadrilaterals", []):
        number += 1
        elements.addFace([int(v) for v in row[:4]], number)
        tags.setdefault(int(row[4]), []).append(number)
    for row in sections["Hexahedra"]:
        number += 1
        v = [int(v) for v in row[:8]]
        # FreeCAD's first four corners are the ones that VTK has last, and both go round the same way.
        elements.addVolume([*v[4:], *v[:4]], number)
    for tag in sorted(tags):
        group = elements.addGroup("wall" if tag == 1 else f"cap_{tag - 1}", "Face")
        elements.addGroupElements(group, tags[tag])
    made.FemMesh = elements
    if App.GuiUp:
        import FemGui

        if (analysis := FemGui.getActiveAnalysis()) is not None:
            analysis.addObject(made)
    return [made]
