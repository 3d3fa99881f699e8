"""To and from trimesh, meshio and pyvista, which are imported only when asked for.

Positions, faces, marked edges, hexahedra and attributes are kept as far as the other side has a place for them.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._errors import InputError
from ._mesh import Mesh

if TYPE_CHECKING:
    import meshio
    import pyvista
    import trimesh

__all__ = ["from_meshio", "from_pyvista", "from_trimesh", "to_meshio", "to_pyvista", "to_trimesh"]

#: Kinds of cells that are faces, as meshio calls them.
_FACES = ("triangle", "quad", "polygon")


# ---- trimesh -------------------------------------------------------------------------------------------------------


def to_trimesh(mesh: Mesh, **options: Any) -> trimesh.Trimesh:
    """A mesh as a `trimesh.Trimesh`; polygons are cut into triangles.

    Parameters
    ----------
    mesh : Mesh
        The surface.
    **options
        Passed to trimesh. By default it is told not to merge or drop vertices (``process=False``), so that ids stay.
    """
    import trimesh

    flat = mesh.triangulated()
    options = {"process": False} | options
    return trimesh.Trimesh(
        vertices=np.array(flat.points),
        faces=np.array(flat.faces, dtype=np.int64).reshape(-1, 3),
        vertex_attributes={name: np.array(v) for name, v in flat.vertex_attributes.items()},
        face_attributes={name: np.array(v) for name, v in flat.face_attributes.items()},
        **options,
    )


def from_trimesh(mesh: trimesh.Trimesh, source: str = "trimesh") -> Mesh:
    """A `trimesh.Trimesh` as a mesh; attributes that are no numbers are left out."""
    return Mesh(
        mesh.vertices,
        mesh.faces,
        vertex_attributes=_fitting(mesh.vertex_attributes),
        face_attributes=_fitting(mesh.face_attributes),
        source=source,
    )


# ---- meshio --------------------------------------------------------------------------------------------------------


def to_meshio(mesh: Mesh) -> meshio.Mesh:
    """A mesh as a `meshio.Mesh`: faces in their order, then marked edges and volume cells.

    Attributes of faces become cell data; cells that are no faces have NaN or 0 there. Tags of marked edges are in the
    cell data ``edge_tag``.
    """
    import meshio

    blocks: list[tuple[str, NDArray[Any]]] = []
    spans: list[tuple[int, int] | None] = []
    for start, end, width in _runs(np.diff(mesh.face_offsets)):
        kind = {3: "triangle", 4: "quad"}.get(width, "polygon")
        corners = mesh.face_corners[mesh.face_offsets[start] : mesh.face_offsets[end]]
        blocks.append((kind, np.array(corners, dtype=np.int64).reshape(-1, width)))
        spans.append((start, end))
    solids = [("line", mesh.edges), ("hexahedron", mesh.hexes), ("tetra", mesh.tets)]
    solids += [("wedge", mesh.wedges), ("pyramid", mesh.pyramids)]
    for kind, cells in solids:
        if len(cells):
            blocks.append((kind, np.array(cells, dtype=np.int64)))
            spans.append(None)
    data = {
        name: [
            np.array(values[span[0] : span[1]]) if span else _nothing(values, len(block))
            for span, (_, block) in zip(spans, blocks, strict=True)
        ]
        for name, values in mesh.face_attributes.items()
    }
    if len(mesh.edges):
        data["edge_tag"] = [
            np.array(mesh.edge_tags) if kind == "line" else np.zeros(len(block), np.int32) for kind, block in blocks
        ]
    points = {name: np.array(v) for name, v in mesh.vertex_attributes.items()}
    return meshio.Mesh(np.array(mesh.points), blocks, point_data=points, cell_data=data)


def from_meshio(mesh: meshio.Mesh, source: str = "meshio") -> Mesh:
    """A `meshio.Mesh` as a mesh: triangles, quads and polygons are faces, lines are marked edges, hexahedra are cells.

    Raises
    ------
    InputError
        For kinds of cells that a mesh cannot hold.
    """
    faces: list[NDArray[Any]] = []
    edges: list[NDArray[Any]] = []
    hexes: list[NDArray[Any]] = []
    blocks: list[int] = []
    lines: list[int] = []
    for k, block in enumerate(mesh.cells):
        if (
            block.type.startswith(_FACES)
            and np.asarray(block.data).ndim == 2
            and block.type.rstrip("0123456789") in _FACES
        ):
            faces.append(np.asarray(block.data))
            blocks.append(k)
        elif block.type == "line":
            edges.append(np.asarray(block.data))
            lines.append(k)
        elif block.type == "hexahedron":
            hexes.append(np.asarray(block.data))
        elif block.type != "vertex":
            raise InputError(f"cells of the kind '{block.type}' have no place in a carreau.Mesh", f"cell block {k}")
    columns = {
        name: np.concatenate([np.asarray(values[k]).reshape(len(mesh.cells[k].data), -1) for k in blocks]).squeeze()
        for name, values in mesh.cell_data.items()
        if blocks and name != "edge_tag"
    }
    tags = [np.asarray(mesh.cell_data["edge_tag"][k]) for k in lines] if "edge_tag" in mesh.cell_data else []
    return Mesh(
        _spatial(mesh.points),
        [face for block in faces for face in block] if len({f.shape[1] for f in faces}) > 1 else _stack(faces, 3),
        edges=_stack(edges, 2),
        edge_tags=np.concatenate(tags) if tags else None,
        hexes=_stack(hexes, 8),
        vertex_attributes=_fitting(mesh.point_data),
        face_attributes=_fitting(columns),
        source=source,
    )


# ---- pyvista -------------------------------------------------------------------------------------------------------


def to_pyvista(mesh: Mesh) -> pyvista.PolyData | pyvista.UnstructuredGrid:
    """A mesh as a `pyvista.PolyData`, or as an `UnstructuredGrid` of its cells where it has hexahedra.

    A grid holds the volume cells only; its surface with the tags is ``to_pyvista(carreau.Mesh(mesh.points, mesh.faces,
    ...))``.
    """
    import pyvista

    if mesh.n_cells:
        kinds = [(mesh.hexes, 12), (mesh.tets, 10), (mesh.wedges, 13), (mesh.pyramids, 14)]
        cells = [_padded(table).ravel() for table, _ in kinds if len(table)]
        types = [np.full(len(table), kind, np.uint8) for table, kind in kinds if len(table)]
        made = pyvista.UnstructuredGrid(np.concatenate(cells), np.concatenate(types), np.array(mesh.points))
    else:
        sizes = np.diff(mesh.face_offsets).astype(np.int64)
        starts = np.asarray(mesh.face_offsets[:-1], np.int64)
        made = pyvista.PolyData(np.array(mesh.points), np.insert(mesh.face_corners.astype(np.int64), starts, sizes))
        made.cell_data.update({name: np.array(v) for name, v in mesh.face_attributes.items()})
    made.point_data.update({name: np.array(v) for name, v in mesh.vertex_attributes.items()})
    return made


def from_pyvista(mesh: pyvista.DataSet, source: str = "pyvista") -> Mesh:
    """A `pyvista.PolyData` or an `UnstructuredGrid` of faces, lines and hexahedra as a mesh."""
    import pyvista

    if not isinstance(mesh, pyvista.PolyData):
        return from_meshio(pyvista.to_meshio(mesh), source)
    flat = np.asarray(mesh.faces)
    faces = mesh.regular_faces if mesh.is_all_triangles else _unpadded(flat)
    columns = mesh.cell_data if mesh.n_lines == mesh.n_verts == 0 else {}
    return Mesh(
        mesh.points,
        faces,
        edges=[pair for line in _unpadded(np.asarray(mesh.lines)) for pair in pairwise(line)],
        vertex_attributes=_fitting(mesh.point_data),
        face_attributes=_fitting(columns),
        source=source,
    )


# ---- arrays --------------------------------------------------------------------------------------------------------


def _runs(sizes: NDArray[Any]) -> list[tuple[int, int, int]]:
    """Faces of one size that follow each other: first, end, size."""
    if len(sizes) == 0:
        return []
    starts = np.flatnonzero(np.diff(sizes, prepend=-1)).tolist()
    return [(a, b, int(sizes[a])) for a, b in zip(starts, [*starts[1:], len(sizes)], strict=True)]


def _nothing(values: NDArray[Any], count: int) -> NDArray[Any]:
    """A value for elements that have none."""
    return np.full((count, *values.shape[1:]), np.nan if values.dtype.kind == "f" else 0, values.dtype)


def _stack(tables: list[NDArray[Any]], width: int) -> NDArray[Any]:
    return np.concatenate(tables) if tables else np.zeros((0, width), np.int64)


def _spatial(points: Any) -> NDArray[np.float64]:
    """Points of the plane get a third coordinate."""
    points = np.asarray(points, np.float64)
    missing = 3 - points.shape[1]
    return np.pad(points, ((0, 0), (0, missing))) if missing > 0 else points


def _padded(table: NDArray[Any]) -> NDArray[np.int64]:
    """Rows that begin with their length."""
    return np.insert(table.astype(np.int64), 0, table.shape[1], axis=1)


def _unpadded(flat: NDArray[Any]) -> list[NDArray[Any]]:
    rows, at = [], 0
    while at < len(flat):
        rows.append(flat[at + 1 : at + 1 + flat[at]])
        at += 1 + flat[at]
    return rows


def _fitting(columns: Any) -> dict[str, NDArray[Any]]:
    """Attributes that a mesh can hold."""
    made = {}
    for name, values in dict(columns).items():
        array = np.asarray(values)
        colors = array.ndim == 2 and array.shape[1] == 4 and array.dtype == np.uint8
        vectors = array.ndim == 2 and array.shape[1] in (2, 3) and array.dtype.kind in "fiub"
        numbers = array.ndim == 1 and array.dtype.kind in "fiub"
        wide = array.dtype.kind in "iu" and array.size and (array.max() > 2**31 - 1 or array.min() < -(2**31))
        if wide and not colors:
            array = array.astype(np.float64)
        if colors or vectors or numbers:
            made[str(name)] = array
    return made
