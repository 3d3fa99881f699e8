"""Meshes of Blender as arrays, and back.

What a run needs of an object is taken at its start, because the object may be gone at its end.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

__all__ = ["Frame", "Source", "new_mesh"]


@dataclass(frozen=True)
class Frame:
    """How an object is stretched: sizes are those that are seen; axes and the origin are the object's own."""

    linear: np.ndarray
    inverse: np.ndarray

    @classmethod
    def of(cls, matrix: Any) -> Frame:
        linear = np.array(matrix, dtype=float)[:3, :3]
        # An object squeezed flat has no way back: its own coordinates are used.
        if (
            not np.all(np.isfinite(linear))
            or abs(np.linalg.det(linear)) < 1e-12 * max(np.abs(linear).max(), 1e-30) ** 3
        ):
            linear = np.eye(3)
        # Without the turn and the mirror of it: what is left of a placement that is a turn times a stretch.
        _, sizes, axes = np.linalg.svd(linear)
        stretch = axes.T @ np.diag(sizes) @ axes
        return cls(stretch, np.linalg.inv(stretch))

    def out(self, points: np.ndarray) -> np.ndarray:
        return points @ self.linear.T

    def back(self, points: np.ndarray) -> np.ndarray:
        return points @ self.inverse.T


@dataclass
class Source:
    """An object's mesh at the start of a run."""

    name: str
    frame: Frame
    points: np.ndarray  # (n, 3), the object's own coordinates
    corners: np.ndarray  # vertex of every corner
    starts: np.ndarray  # the first corner of every face, and their number at the end
    materials: np.ndarray  # of every face
    slots: list[Any] = field(default_factory=list)  # names of materials
    uv_name: str = ""
    uv: np.ndarray | None = None  # of every corner
    marked: np.ndarray | None = None  # edges that shall stay, as pairs of vertices
    triangles: np.ndarray | None = None  # corners of every triangle of the display
    triangle_faces: np.ndarray | None = None
    smooth: bool = False
    groups: dict[str, np.ndarray] = field(default_factory=dict)  # weights of vertices
    keys: dict[str, np.ndarray] = field(default_factory=dict)  # offsets of vertices
    layers: list[tuple[str, str, str, np.ndarray]] = field(default_factory=list)  # kind, name, domain, values

    @classmethod
    def of(cls, obj: Any, depsgraph: Any = None) -> Source:
        """Of the object with its modifiers where a depsgraph is given, else of its own mesh."""
        if depsgraph is None:
            return cls._of_mesh(obj, obj.data)
        evaluated = obj.evaluated_get(depsgraph)
        mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
        try:
            return cls._of_mesh(obj, mesh)
        finally:
            evaluated.to_mesh_clear()

    @classmethod
    def _of_mesh(cls, obj: Any, mesh: Any) -> Source:
        mesh.calc_loop_triangles()
        source = cls(
            name=obj.name,
            frame=Frame.of(obj.matrix_world),
            points=_get(mesh.vertices, "co", float, 3),
            corners=_get(mesh.loops, "vertex_index", np.int32),
            starts=np.append(_get(mesh.polygons, "loop_start", np.int32), len(mesh.loops)).astype(np.int64),
            materials=_get(mesh.polygons, "material_index", np.int32),
            slots=[slot.material.name if slot.material is not None else None for slot in obj.material_slots],
            triangles=_get(mesh.loop_triangles, "loops", np.int32, 3),
            triangle_faces=_get(mesh.loop_triangles, "polygon_index", np.int32),
        )
        shaded = _get(mesh.polygons, "use_smooth", bool)
        source.smooth = bool(len(shaded)) and bool(shaded.mean() > 0.5)
        source._take_layers(mesh)
        source._take_groups(obj, mesh)
        return source

    def _take_layers(self, mesh: Any) -> None:
        """The active texture coordinates, which carreau carries; further ones and colours, which are sampled."""
        active = mesh.uv_layers.active
        for layer in mesh.uv_layers:
            values = _get(layer.uv, "vector", float, 2)
            if layer == active:
                self.uv_name, self.uv = layer.name, values
            else:
                self.layers.append(("UV", layer.name, "CORNER", values))
        for layer in mesh.color_attributes:
            self.layers.append((layer.data_type, layer.name, layer.domain, _get(layer.data, "color", float, 4)))

    def _take_groups(self, obj: Any, mesh: Any) -> None:
        names = [group.name for group in obj.vertex_groups]
        weights = np.zeros((len(names), len(self.points)))
        if names:
            for vertex in mesh.vertices:
                for element in vertex.groups:
                    if element.group < len(names):
                        weights[element.group, vertex.index] = element.weight
        self.groups = dict(zip(names, weights, strict=True))
        keys = getattr(mesh, "shape_keys", None)
        for key in keys.key_blocks[1:] if keys is not None else ():
            self.keys[key.name] = _get(key.data, "co", float, 3) - _get(key.relative_key.data, "co", float, 3)

    def mark(self, mesh: Any, *, sharp: bool, seams: bool, materials: bool) -> None:
        """Collects edges that shall stay: those that the user marked, and borders of materials."""
        edges = _get(mesh.edges, "vertices", np.int32, 2)
        wanted = np.zeros(len(edges), dtype=bool)
        if sharp:
            wanted |= _get(mesh.edges, "use_edge_sharp", bool)
        if seams:
            wanted |= _get(mesh.edges, "use_seam", bool)
        if materials and len(edges):
            of_corners = _get(mesh.loops, "edge_index", np.int32)
            of_faces = np.repeat(self.materials, np.diff(self.starts))
            low, high = np.full(len(edges), 2**30), np.full(len(edges), -1)
            np.minimum.at(low, of_corners, of_faces)
            np.maximum.at(high, of_corners, of_faces)
            wanted |= high > low
        self.marked = edges[wanted]


def _get(items: Any, name: str, kind: Any, width: int = 1) -> np.ndarray:
    """A property of all items; Blender has floats in single precision."""
    single = np.float32 if kind is float else kind
    values = np.empty(len(items) * width, dtype=single)
    items.foreach_get(name, values)
    values = values.astype(np.float64) if kind is float else values
    return values.reshape(-1, width) if width > 1 else values


def new_mesh(name: str, points: np.ndarray, corners: np.ndarray, starts: np.ndarray) -> Any:
    """A mesh of polygons."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", corners.astype(np.int32))
    mesh.polygons.add(len(starts) - 1)
    mesh.polygons.foreach_set("loop_start", starts[:-1].astype(np.int32))
    mesh.update(calc_edges=True)
    return mesh
