"""What files have no place for is sampled on the surface of the source.

Weights of vertex groups, shape keys, colours, further texture coordinates; and the materials, by their numbers.
"""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree

from .surface import Source

__all__ = ["carry", "materials"]

#: How far a corner is moved to the middle of its face before it is sampled, so that it is on its own side of a border.
PULL = 0.02


class _Sampler:
    """The nearest points of the source: the corners of their triangles, and weights of these."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._tree = BVHTree.FromPolygons(source.points.tolist(), source.corners[source.triangles].tolist())

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = [self._tree.find_nearest(point) for point in points.tolist()]
        near = np.array([place for place, _, _, _ in found], dtype=float)
        corners = self._source.triangles[[triangle for _, _, triangle, _ in found]]
        return corners, _weights(near, self._source.points[self._source.corners[corners]])


def _weights(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Barycentric coordinates, none below 0."""
    a, b, c = triangles.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    twice = np.maximum(np.einsum("ij,ij->i", normal, normal), 1e-300)
    parts = [np.einsum("ij,ij->i", np.cross(v - u, points - u), normal) / twice for u, v in ((b, c), (c, a), (a, b))]
    weights = np.clip(np.stack(parts, axis=1), 0, None)
    total = weights.sum(axis=1, keepdims=True)
    return np.where(total > 0, weights / np.where(total > 0, total, 1), 1 / 3)


def carry(source: Source, obj: Any) -> None:
    """Gives an object with a new mesh, in the coordinates of the source, what the source has."""
    if not (source.groups or source.keys or source.layers) or not len(source.triangles):
        return
    mesh = obj.data
    points = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    mesh.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3).astype(float)
    sampler = _Sampler(source)
    corners, weights = sampler.at(points)
    vertices = source.corners[corners]
    for name, values in source.groups.items():
        group = obj.vertex_groups.new(name=name)
        for vertex, weight in enumerate((values[vertices] * weights).sum(axis=1).tolist()):
            if weight > 0:
                group.add([vertex], weight, "REPLACE")
    if source.keys:
        obj.shape_key_add(name="Basis", from_mix=False)
        for name, offsets in source.keys.items():
            moved = points + (offsets[vertices] * weights[:, :, None]).sum(axis=1)
            obj.shape_key_add(name=name, from_mix=False).data.foreach_set("co", moved.astype(np.float32).ravel())
    of_corners = sampler.at(_pulled(mesh, points)) if any(layer[2] == "CORNER" for layer in source.layers) else None
    for kind, name, domain, values in source.layers:
        if domain == "CORNER":
            corners_there, weights_there = of_corners
            _add(mesh, kind, name, domain, (values[corners_there] * weights_there[:, :, None]).sum(axis=1))
        elif domain == "POINT":
            _add(mesh, kind, name, domain, (values[vertices] * weights[:, :, None]).sum(axis=1))


def _pulled(mesh: Any, points: np.ndarray) -> np.ndarray:
    """The corners of all faces, moved a little to the middle."""
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    sizes = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_total", sizes)
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    middles = np.add.reduceat(points[corners], starts, axis=0) / sizes[:, None]
    return points[corners] * (1 - PULL) + np.repeat(middles, sizes, axis=0) * PULL


def _add(mesh: Any, kind: str, name: str, domain: str, values: np.ndarray) -> None:
    flat = values.astype(np.float32).ravel()
    if kind == "UV":
        mesh.uv_layers.new(name=name, do_init=False).uv.foreach_set("vector", flat)
    else:
        mesh.color_attributes.new(name=name, type=kind, domain=domain).data.foreach_set("color", flat)


def materials(source: Source, mesh: Any, numbers: np.ndarray) -> None:
    """The materials of the source, by the numbers of their slots."""
    for name in source.slots:
        mesh.materials.append(bpy.data.materials.get(name) if name else None)
    mesh.polygons.foreach_set("material_index", np.minimum(numbers, max(len(source.slots) - 1, 0)).astype(np.int32))
