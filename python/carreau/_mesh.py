"""Meshes and skeletons."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._errors import CarreauWarning, InputError, OptionsError
from ._frozen import Frozen, freeze
from ._notebook import framed

__all__ = ["Mesh", "Skeleton", "as_edges", "read", "sample", "samples", "write"]

#: Formats of boundary representations, which only `patch` can write.
CAD_EXTENSIONS = (".igs", ".iges", ".step", ".stp")


class Mesh(Frozen):
    """A surface of triangles and polygons, or a volume mesh with its boundary.

    A mesh does not change. Its arrays are views of its own memory: read-only, never copies.

    Parameters
    ----------
    points : array_like of float, (n, 3)
        Positions of the vertices.
    faces : array_like of int, (m, 3) or (m, 4), or a list of lists
        Vertices of the faces, 0-based, counter-clockwise seen from outside. A list may mix polygons of any size.
    edges : array_like of int, (k, 2), optional
        Marked edges: features that methods keep.
    edge_tags : array_like of int, (k,), optional
        Their reference numbers.
    hexes : array_like of int, (h, 8), optional
        Hexahedra, corners in VTK order; `faces` is then the tagged boundary.
    vertex_attributes, face_attributes : mapping of str to array_like, optional
        Values by name: numbers, integer labels, vectors of two or three numbers, colours (uint8, four columns).
    source : str, optional
        The name under which messages and records know the mesh.

    Raises
    ------
    InputError
        For an index out of range or a coordinate that is not finite; the message says where.

    Examples
    --------
    >>> import carreau as cr
    >>> mesh = cr.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> mesh
    <carreau.Mesh 'mesh': 4 vertices, 2 faces>
    >>> mesh.points.flags.writeable
    False
    """

    __slots__ = ("__weakref__", "_native", "source")

    source: str
    _native: _core.Mesh

    def __init__(
        self,
        points: ArrayLike,
        faces: ArrayLike | Sequence[Sequence[int]] = (),
        *,
        edges: ArrayLike = (),
        edge_tags: ArrayLike | None = None,
        hexes: ArrayLike = (),
        vertex_attributes: Mapping[str, ArrayLike] | None = None,
        face_attributes: Mapping[str, ArrayLike] | None = None,
        source: str = "mesh",
    ) -> None:
        points = _points(points)
        corners, sizes = _faces(faces)
        edges = _indices(edges, "edges", 2)
        tags = np.ones(len(edges), np.int32) if edge_tags is None else _integers(edge_tags, "edge_tags")
        if tags.shape != (len(edges),):
            raise InputError(f"{len(tags)} edge_tags for {len(edges)} edges")
        made = _core.Mesh(
            points,
            corners,
            sizes,
            edges,
            tags,
            _indices(hexes, "hexes", 8),
            _columns(vertex_attributes, len(points), "vertices"),
            _columns(face_attributes, len(sizes), "faces"),
        )
        self._set(_native=made, source=str(source))

    @classmethod
    def _wrap(cls, made: _core.Mesh, source: str) -> Mesh:
        mesh = cls.__new__(cls)
        mesh._set(_native=made, source=source)
        return mesh

    # ---- arrays ----------------------------------------------------------------------------------------------------

    @property
    def points(self) -> NDArray[np.float64]:
        """Positions of the vertices, (n, 3)."""
        return self._native.points

    @property
    def faces(self) -> NDArray[np.uint32] | tuple[NDArray[np.uint32], ...]:
        """Vertices of the faces: a table where all have as many corners, else one array per face."""
        table = self._native.faces
        if table is not None:
            return table
        corners, offsets = self._native.corners, self._native.offsets
        return tuple(corners[a:b] for a, b in pairwise(offsets))

    @property
    def face_corners(self) -> NDArray[np.uint32]:
        """Vertices of all faces, one after the other."""
        return self._native.corners

    @property
    def face_offsets(self) -> NDArray[np.uint32]:
        """Where each face begins in `face_corners`, and where the last one ends, (m + 1,)."""
        return self._native.offsets

    @property
    def edges(self) -> NDArray[np.uint32]:
        """Marked edges, (k, 2): features that methods keep. Not all edges of the mesh."""
        return self._native.edges

    @property
    def edge_tags(self) -> NDArray[np.int32]:
        """Reference numbers of the marked edges."""
        return self._native.edge_tags

    @property
    def hexes(self) -> NDArray[np.uint32]:
        """Hexahedra, corners in VTK order, (h, 8)."""
        return self._native.hexes

    @property
    def tets(self) -> NDArray[np.uint32]:
        """Tetrahedra, (t, 4)."""
        return self._native.tets

    @property
    def wedges(self) -> NDArray[np.uint32]:
        """Triangular prisms, (w, 6)."""
        return self._native.wedges

    @property
    def pyramids(self) -> NDArray[np.uint32]:
        """Pyramids, (p, 5)."""
        return self._native.pyramids

    @property
    def vertex_attributes(self) -> Mapping[str, NDArray[Any]]:
        """Values on vertices, by name."""
        return MappingProxyType(self._native.vertex)

    @property
    def face_attributes(self) -> Mapping[str, NDArray[Any]]:
        """Values on faces, by name."""
        return MappingProxyType(self._native.face)

    @property
    def names(self) -> Mapping[tuple[str, int], str]:
        """Words for the values of label attributes: ``(attribute, label)`` to name."""
        return MappingProxyType(dict(self._native.names))

    # ---- what it is ------------------------------------------------------------------------------------------------

    @property
    def n_points(self) -> int:
        """Number of vertices, unreferenced ones included."""
        return len(self._native.points)

    @property
    def n_faces(self) -> int:
        """Number of faces."""
        return len(self._native.offsets) - 1

    @property
    def n_cells(self) -> int:
        """Number of volume cells."""
        m = self._native
        return len(m.hexes) + len(m.tets) + len(m.wedges) + len(m.pyramids)

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Smallest and largest coordinates, (2, 3)."""
        if self.n_points == 0:
            return np.zeros((2, 3))
        return np.array([self.points.min(axis=0), self.points.max(axis=0)])

    def topology(self) -> Mapping[str, Any]:
        """Counts, Euler number, genus, volume and defects with their places; of the boundary, for a volume mesh."""
        return freeze(json.loads(self._native.describe()[0]))

    def quality(self) -> Mapping[str, Any]:
        """Area and the distributions of edge lengths, angles and shapes; of the boundary, for a volume mesh."""
        return freeze(json.loads(self._native.describe()[1]))

    # ---- other meshes ----------------------------------------------------------------------------------------------

    def with_attributes(
        self, vertex: Mapping[str, ArrayLike] | None = None, face: Mapping[str, ArrayLike] | None = None
    ) -> Mesh:
        """The same mesh with more attributes."""
        vertex = _columns(vertex, self.n_points, "vertices")
        face = _columns(face, self.n_faces, "faces")
        return Mesh._wrap(self._native.with_attributes(vertex, face), self.source)

    def triangulated(self) -> Mesh:
        """The surface with every polygon cut into triangles; face attributes follow."""
        return Mesh._wrap(self._native.triangulated(), self.source)

    def boundary(self) -> Mesh:
        """The surface of a volume mesh."""
        return Mesh._wrap(self._native.boundary(), self.source)

    # ---- files and pictures ----------------------------------------------------------------------------------------

    def write(self, path: str | os.PathLike[str], *, ascii: bool = False) -> None:
        """Write a mesh file, whole or not at all; the extension decides the format.

        Parameters
        ----------
        path : path
            Where to write.
        ascii : bool
            Text instead of binary, in formats that have both.
        """
        path = os.fspath(path)
        if path.lower().endswith(CAD_EXTENSIONS):
            raise OptionsError(f"{path}: CAD files hold patches; write one by cr.patch(mesh, output={path!r})")
        _warn(self._native.write(path, ascii))

    def picture(self) -> bytes:
        """A picture of the mesh (PNG)."""
        return self._native.picture()

    def to_trimesh(self, **options: Any):
        """This mesh as a `trimesh.Trimesh`; see `carreau.to_trimesh`."""
        from .converters import to_trimesh

        return to_trimesh(self, **options)

    def to_meshio(self):
        """This mesh as a `meshio.Mesh`; see `carreau.to_meshio`."""
        from .converters import to_meshio

        return to_meshio(self)

    def to_pyvista(self):
        """This mesh as a `pyvista.PolyData` or `UnstructuredGrid`; see `carreau.to_pyvista`."""
        from .converters import to_pyvista

        return to_pyvista(self)

    def __repr__(self) -> str:
        cells = f", {self.n_cells} cells" if self.n_cells else ""
        return f"<carreau.Mesh {self.source!r}: {self.n_points} vertices, {self.n_faces} faces{cells}>"

    def page(self) -> str:
        """A page (HTML) to look at the mesh: turn it, slice it, colour it by its attributes."""
        return self._native.page(self.source)

    def _repr_html_(self) -> str:
        return framed(self.page())

    def __getstate__(self) -> dict[str, Any]:
        edges = {"edges": np.array(self.edges), "edge_tags": np.array(self.edge_tags)}
        columns = {
            "vertex_attributes": {name: np.array(v) for name, v in self.vertex_attributes.items()},
            "face_attributes": {name: np.array(v) for name, v in self.face_attributes.items()},
        }
        if len(self.tets) + len(self.wedges) + len(self.pyramids):
            raise TypeError("a mesh of tetrahedra, wedges or pyramids cannot be pickled: write it to a file")
        flat = (np.array(self.face_corners), np.diff(self.face_offsets).astype(np.uint32))
        return {
            "points": np.array(self.points),
            "flat": flat,
            "hexes": np.array(self.hexes),
            **edges,
            **columns,
            "source": self.source,
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        corners, sizes = state["flat"]
        columns = state["vertex_attributes"], state["face_attributes"]
        parts = state["points"], corners, sizes, state["edges"], state["edge_tags"], state["hexes"]
        self._set(_native=_core.Mesh(*parts, *columns), source=state["source"])


class Skeleton(Frozen):
    """A graph drawn in space with a radius at every node.

    Parameters
    ----------
    points : array_like of float, (n, 3)
        Positions of the nodes.
    segments : array_like of int, (k, 2)
        Pairs of nodes.
    radii : array_like of float, (n,), optional
        Radii of the nodes; NaN where none is known.

    Examples
    --------
    >>> import carreau as cr
    >>> cr.Skeleton([[0, 0, 0], [0, 0, 5]], [[0, 1]], radii=[1, 1])
    <carreau.Skeleton: 2 nodes, 1 segments>
    """

    __slots__ = ("__weakref__", "_native")

    _native: _core.Net

    def __init__(self, points: ArrayLike, segments: ArrayLike, radii: ArrayLike | None = None) -> None:
        points = _points(points)
        radii = np.full(len(points), np.nan) if radii is None else np.ascontiguousarray(radii, np.float64)
        if radii.shape != (len(points),):
            raise InputError(f"radii have the shape {radii.shape}; ({len(points)},) is expected")
        segments = np.asarray(segments)
        if segments.ndim != 2 or segments.shape[1] != 2 or segments.dtype.kind not in "iu":
            raise TypeError("segments are an array of integers with two columns")
        self._set(_native=_core.Net(points, radii, np.ascontiguousarray(segments, np.int64)))

    @classmethod
    def _wrap(cls, made: _core.Net) -> Skeleton:
        skeleton = cls.__new__(cls)
        skeleton._set(_native=made)
        return skeleton

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Skeleton:
        """Read a graph: .cgr, .cg, .skel, .swc, .tgf, or the lines of a .vtp, .vtk or .obj file."""
        skeleton = cls._wrap(_core.Net.read(os.fspath(path)))
        _warn(skeleton._native.notes)
        return skeleton

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write a graph; the extension decides the format."""
        _warn(self._native.write(os.fspath(path)))

    @property
    def points(self) -> NDArray[np.float64]:
        """Positions of the nodes, (n, 3)."""
        return self._native.points

    @property
    def segments(self) -> NDArray[np.uint32]:
        """Pairs of nodes, (k, 2)."""
        return self._native.segments

    @property
    def radii(self) -> NDArray[np.float64]:
        """Radii of the nodes, (n,); NaN where none is known."""
        return self._native.radii

    def __repr__(self) -> str:
        return f"<carreau.Skeleton: {len(self.points)} nodes, {len(self.segments)} segments>"

    def __reduce__(self):
        return Skeleton, (np.array(self.points), np.array(self.segments), np.array(self.radii))


def read(path: str | os.PathLike[str]) -> Mesh | Skeleton:
    """Read a mesh file, or a skeleton file (.cgr, .cg, .skel, .swc, .tgf); the extension decides.

    What the reader repaired or left out becomes a `CarreauWarning`.

    Raises
    ------
    ReadError
        The file cannot be read; the message names its line or byte.
    """
    path = os.fspath(path)
    if _core.Net.is_skeleton_file(path):
        return Skeleton.read(path)
    made = _core.Mesh.read(path)
    _warn(made.notes)
    return Mesh._wrap(made, os.path.basename(path))


def write(path: str | os.PathLike[str], what: Mesh | Skeleton, *, ascii: bool = False) -> None:
    """Write a mesh or a skeleton, whole or not at all; the extension decides the format."""
    if isinstance(what, Skeleton):
        what.write(path)
    elif isinstance(what, Mesh):
        what.write(path, ascii=ascii)
    else:
        raise TypeError(f"a Mesh or a Skeleton is expected, not {type(what).__name__}")


def sample(name: str, resolution: int | None = None, *, seed: int = 0) -> Mesh:
    """A built-in procedural model; `samples` names them.

    Parameters
    ----------
    name : str
        Name of the model.
    resolution : int, optional
        Edges of about 1/`resolution` of the bounding-box diagonal.
    seed : int
        Seed of the noise of noisy models.

    Examples
    --------
    >>> import carreau as cr
    >>> cr.sample("bracket").topology()["genus"]
    3
    """
    return Mesh._wrap(_core.sample(name, resolution, seed), name)


def samples() -> dict[str, str]:
    """Names of the built-in models, and what they are."""
    return dict(_core.samples())


def as_edges(edges: ArrayLike) -> NDArray[np.uint32]:
    """Pairs of vertices as the native half expects them."""
    return _indices(edges, "features", 2)


def _warn(notes: Sequence[str]) -> None:
    for note in notes:
        warnings.warn(note, CarreauWarning, stacklevel=3)


# ---- arrays at the border ------------------------------------------------------------------------------------------


def _points(points: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(points)
    if array.size == 0:
        array = array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"points have the shape {array.shape}; (n, 3) is expected")
    return np.ascontiguousarray(array, np.float64)


def _faces(faces: ArrayLike | Sequence[Sequence[int]]) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """All corners, and the number of corners of every face."""
    if isinstance(faces, (list, tuple)) and len({len(face) for face in faces}) > 1:
        sizes = np.array([len(face) for face in faces], np.uint32)
        flat = np.concatenate([np.asarray(face) for face in faces])
        return _unsigned(flat, "face", np.repeat(np.arange(len(faces)), sizes)), sizes
    array = np.asarray(faces)
    if array.size == 0:
        array = np.zeros((0, 3), np.uint32)
    if array.ndim != 2:
        raise InputError(f"faces have the shape {array.shape}; (m, 3), (m, 4) or a list of lists is expected")
    rows = np.repeat(np.arange(len(array)), array.shape[1])
    return _unsigned(array.ravel(), "face", rows), np.full(len(array), array.shape[1], np.uint32)


def _indices(values: ArrayLike, what: str, width: int) -> NDArray[np.uint32]:
    array = np.asarray(values)
    if array.size == 0:
        return np.zeros((0, width), np.uint32)
    if array.ndim != 2 or array.shape[1] != width:
        raise InputError(f"{what} have the shape {array.shape}; (k, {width}) is expected")
    rows = np.repeat(np.arange(len(array)), width)
    return _unsigned(array.ravel(), what.rstrip("s"), rows).reshape(-1, width)


def _unsigned(flat: NDArray[Any], what: str, rows: NDArray[Any]) -> NDArray[np.uint32]:
    """Vertex indices; what does not fit is told with its row."""
    if flat.dtype.kind not in "iu":
        raise TypeError(f"{what}s are integers, not {flat.dtype}")
    wrong = np.flatnonzero((flat < 0) | (flat > np.iinfo(np.uint32).max))
    if len(wrong):
        k = wrong[0]
        place = f"{what} {rows[k]}"
        raise InputError(f"a {what} uses vertex {flat[k]}; at {place}; ids are 0-based and not negative", place)
    return np.ascontiguousarray(flat, np.uint32)


def _integers(values: ArrayLike, what: str) -> NDArray[np.int32]:
    array = np.asarray(values)
    if array.size == 0:
        return np.zeros(array.shape, np.int32)
    if array.dtype.kind not in "iub":
        raise TypeError(f"{what} are integers, not {array.dtype}")
    bounds = np.iinfo(np.int32)
    if array.min() < bounds.min or array.max() > bounds.max:
        raise InputError(f"{what}: labels have 32 bits with a sign; {array.min()} to {array.max()} are given")
    return np.ascontiguousarray(array, np.int32)


def _columns(columns: Mapping[str, ArrayLike] | None, count: int, what: str) -> dict[str, NDArray[Any]]:
    made = {}
    for name, values in (columns or {}).items():
        array = np.asarray(values)
        if len(array.shape) == 0 or len(array) != count:
            raise InputError(f"the attribute '{name}' has the shape {array.shape}; there are {count} {what}")
        if array.ndim == 1 and array.dtype.kind in "iub":
            made[name] = _integers(array, f"'{name}'")
        elif array.ndim == 2 and array.shape[1] == 4 and array.dtype == np.uint8:
            made[name] = np.ascontiguousarray(array)
        elif array.dtype.kind in "fiub" and (array.ndim == 1 or (array.ndim == 2 and array.shape[1] in (2, 3))):
            made[name] = np.ascontiguousarray(array, np.float64)
        else:
            raise TypeError(
                f"the attribute '{name}' is {array.dtype} of the shape {array.shape}; numbers, integer labels, two or "
                "three numbers per element or colours (uint8, four columns) are expected"
            )
    return made
