"""OBJ files, which hold all that carreau carries: polygons, texture coordinates of corners, materials, features."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .surface import Source

__all__ = ["Result", "read", "write", "write_edges"]


@dataclass
class Result:
    """What carreau wrote, in its own order."""

    points: np.ndarray
    corners: np.ndarray
    starts: np.ndarray
    materials: np.ndarray
    uv: np.ndarray | None  # of every corner
    edges: np.ndarray  # features


def write(path: str, source: Source) -> None:
    """Writes a mesh as it is stretched; ids are those of the mesh."""
    points = source.frame.out(source.points)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    if source.uv is not None:
        lines += [f"vt {u!r} {v!r}" for u, v in source.uv.tolist()]
    corners, starts, materials = source.corners.tolist(), source.starts.tolist(), source.materials.tolist()
    current = None
    for face, material in enumerate(materials):
        if material != current:
            lines.append(f"usemtl m{material}")
            current = material
        around = range(starts[face], starts[face + 1])
        if source.uv is None:
            lines.append("f " + " ".join(str(corners[c] + 1) for c in around))
        else:
            lines.append("f " + " ".join(f"{corners[c] + 1}/{c + 1}" for c in around))
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(lines) + "\n")


def write_edges(path: str, edges: np.ndarray) -> None:
    """Writes features: a line with two vertex ids each."""
    with open(path, "w", encoding="ascii") as file:
        file.writelines(f"{a} {b}\n" for a, b in edges.tolist())


def read(path: str) -> Result:
    """Reads what carreau wrote."""
    points, texture, corners, of_texture, starts, materials, edges = [], [], [], [], [0], [], []
    material = 0
    with open(path, encoding="utf-8") as file:
        for line in file:
            word, _, rest = line.partition(" ")
            if word == "v":
                points.append([float(x) for x in rest.split()[:3]])
            elif word == "vt":
                texture.append([float(x) for x in rest.split()[:2]])
            elif word == "f":
                for parts in (corner.split("/") for corner in rest.split()):
                    corners.append(int(parts[0]) - 1)
                    of_texture.append(int(parts[1]) - 1 if len(parts) > 1 and parts[1] else -1)
                starts.append(len(corners))
                materials.append(material)
            elif word == "usemtl" and rest.strip()[1:].isdigit():
                material = int(rest.strip()[1:])
            elif word == "l":
                ids = [int(i) - 1 for i in rest.split()]
                edges += pairwise(ids)
    uv = np.array(texture)[of_texture] if texture and -1 not in of_texture else None
    return Result(
        np.array(points, dtype=float).reshape(-1, 3),
        np.array(corners, dtype=np.int64),
        np.array(starts, dtype=np.int64),
        np.array(materials, dtype=np.int32),
        uv,
        np.array(edges, dtype=np.int64).reshape(-1, 2),
    )
