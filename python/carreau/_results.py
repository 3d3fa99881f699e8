"""What verbs return: arrays, the record, a picture; none of it can be changed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._frozen import Frozen, freeze
from ._mesh import Mesh, Skeleton
from ._notebook import framed

__all__ = [
    "CadFace",
    "CadResult",
    "CompareResult",
    "CurvatureResult",
    "FieldResult",
    "HexResult",
    "InfoResult",
    "MotorcycleResult",
    "Patch",
    "PatchResult",
    "QuadResult",
    "RemeshResult",
    "RepairResult",
    "Result",
    "SegmentResult",
    "SkeletonResult",
]


class Result(Frozen):
    """What all results have.

    Attributes
    ----------
    record : mapping
        The result record, as the command line's ``--json`` writes it. Pass a result as ``options=`` to replay its run.
    summary : tuple of str
        What the command line would print.
    """

    __slots__ = ("__weakref__", "_arrays", "_found", "_input", "_source", "record", "summary")

    record: Mapping[str, Any]
    summary: tuple[str, ...]
    _found: _core.Found
    _arrays: Mapping[str, NDArray[Any]]
    _source: str
    _input: Mesh | None

    def __init__(self, found: _core.Found, source: str, given: Mesh | None) -> None:
        self._set(
            _found=found,
            _input=given,
            _arrays=found.arrays,
            _source=source,
            record=freeze(json.loads(found.record)),
            summary=tuple(found.summary),
        )

    @property
    def options(self) -> Mapping[str, Any]:
        """Every option with its value."""
        return self.record["options"]

    @property
    def quality(self) -> Mapping[str, Any]:
        """Figures of quality."""
        return self.record.get("quality", freeze({}))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the user should know: repairs, losses, fallbacks."""
        return self.record["warnings"]

    @property
    def seconds(self) -> Mapping[str, float]:
        """Time in total and per stage."""
        return self.record["seconds"]

    def to_json(self) -> str:
        """The result record as text."""
        return self._found.record

    def picture(self) -> bytes | None:
        """A picture of the result (PNG)."""
        return self._found.picture()

    def __repr__(self) -> str:
        return f"<carreau.{type(self).__name__}: {'; '.join(self.summary)}>"

    def page(self) -> str:
        """A page (HTML) to look at the result, beside the input where that was a mesh, with quality and options."""
        before = self._input._native if self._input is not None else None
        return self._found.page(f"{self.record['verb']} {self._source}", before)

    def _repr_html_(self) -> str:
        return framed(self.page())


class _MeshResult(Result):
    """A result with a mesh."""

    __slots__ = ("mesh",)

    mesh: Mesh
    """The mesh that the command line would write, attributes included."""

    def __init__(self, found: _core.Found, source: str, given: Mesh | None) -> None:
        super().__init__(found, source, given)
        self._set(mesh=Mesh._wrap(found.mesh, source))


class _LayoutResult(_MeshResult):
    """A result with a layout file."""

    __slots__ = ()

    def layout(self) -> dict[str, Any]:
        """The content of the file that ``layout=`` writes."""
        return json.loads(self._found.layout())


class InfoResult(Result):
    """What `info` found: counts, topology and defects in `record`."""

    __slots__ = ()

    @property
    def topology(self) -> Mapping[str, Any]:
        """Counts, Euler number, genus, volume, defects with their places."""
        return self.record["topology"]


class CompareResult(Result):
    """What `compare` measured: distances and angles of normals in `record`."""

    __slots__ = ()

    @property
    def distance(self) -> Mapping[str, float]:
        """Two-sided distance in the unit of the meshes: mean, rms, max, and a bound that max does not exceed."""
        return self.record["distance"]

    @property
    def relative(self) -> Mapping[str, float]:
        """The same as shares of the first mesh's diagonal."""
        return self.record["relative"]


class RepairResult(_MeshResult):
    """A sound surface."""

    __slots__ = ()

    @property
    def report(self) -> Mapping[str, Any]:
        """What was done, in numbers."""
        return self.record["repair"]


class CurvatureResult(_MeshResult):
    """Principal curvatures and directions at every vertex."""

    __slots__ = ()

    @property
    def kmin(self) -> NDArray[np.float64]:
        """Smallest principal curvature, (n,)."""
        return self.mesh.vertex_attributes["kmin"]

    @property
    def kmax(self) -> NDArray[np.float64]:
        """Largest principal curvature, (n,)."""
        return self.mesh.vertex_attributes["kmax"]

    @property
    def dmin(self) -> NDArray[np.float64]:
        """Direction of the smallest, (n, 3)."""
        return self.mesh.vertex_attributes["dmin"]

    @property
    def dmax(self) -> NDArray[np.float64]:
        """Direction of the largest, (n, 3)."""
        return self.mesh.vertex_attributes["dmax"]


class CadFace(Frozen):
    """A face of a CAD model: its kind, its area, and the figures of its surface."""

    __slots__ = ("area", "edges", "figures", "kind", "name", "region", "triangles")

    name: str
    """Its name in the CAD file."""
    kind: str
    """``plane``, ``cylinder``, ``cone``, ``sphere``, ``torus``, ``extrusion``, ``revolution`` or ``bspline``."""
    area: float
    """Its exact area."""
    edges: int
    """Number of edges around it; a seam counts twice."""
    region: int | None
    """The region of the segmentation that it is, or is a part of."""
    figures: Mapping[str, Any]
    """What its kind has of: origin, direction, radius, major_radius, minor_radius, half_angle_deg, control_points."""
    triangles: NDArray[np.intp]
    """The triangles of the mesh that it stands for."""

    def __init__(self, entry: Mapping[str, Any], triangles: NDArray[np.intp]) -> None:
        own = ("name", "kind", "area", "edges", "region")
        figures = freeze({key: value for key, value in entry.items() if key not in own})
        triangles.setflags(write=False)
        self._set(triangles=triangles, figures=figures, **{key: entry[key] for key in own})

    def __repr__(self) -> str:
        radius = self.figures.get("radius")
        return f"<carreau.CadFace: {self.name}, area {self.area:g}{'' if radius is None else f', radius {radius:g}'}>"


class CadResult(_MeshResult):
    """A CAD model: the mesh with the face of every triangle, and the faces."""

    __slots__ = ()

    @property
    def labels(self) -> NDArray[np.int32]:
        """Face of every triangle."""
        return self.mesh.face_attributes["face"]

    @property
    def faces(self) -> tuple[CadFace, ...]:
        """The faces of the model, in the order of the numbers in `labels`."""
        table, labels = self.record["face_table"], self.labels
        order = np.argsort(labels, kind="stable")
        ends = np.searchsorted(labels[order], np.arange(len(table) + 1))
        return tuple(CadFace(entry, order[ends[k] : ends[k + 1]]) for k, entry in enumerate(table))


class SegmentResult(_MeshResult):
    """The faces of a part, and the surface that each lies on."""

    __slots__ = ()

    @property
    def labels(self) -> NDArray[np.int32]:
        """Region of every triangle; 0 is the largest."""
        return self.mesh.face_attributes["region"]

    @property
    def regions(self) -> tuple[Mapping[str, Any], ...]:
        """Area, curvatures, surface and neighbours of every region."""
        return self.record["regions"]

    @property
    def boundaries(self) -> tuple[Mapping[str, Any], ...]:
        """Lines between regions: the two regions, the vertices, whether closed."""
        return self.record["boundaries"]


class RemeshResult(_MeshResult):
    """A graded mesh, of `enrich` or `simplify`; `quality` has its shapes, lengths and deviations."""

    __slots__ = ()


class Patch(Frozen):
    """A grid of quads on the vertices of a triangle mesh."""

    __slots__ = ("triangles", "vertices")

    vertices: NDArray[np.uint32]
    """Vertices row by row, (rows + 1, columns + 1)."""
    triangles: NDArray[np.uint32]
    """The two triangles of every cell, (rows, columns, 2)."""

    def __init__(self, vertices: NDArray[np.uint32], triangles: NDArray[np.uint32]) -> None:
        self._set(vertices=vertices, triangles=triangles)

    def __repr__(self) -> str:
        rows, columns, _ = self.triangles.shape
        return f"<carreau.Patch: {rows} × {columns} cells>"


class PatchResult(_LayoutResult):
    """Quad patches on the given vertices; `mesh` has one quad per cell, then the triangles left over."""

    __slots__ = ("patches",)

    patches: tuple[Patch, ...]

    def __init__(self, found: _core.Found, source: str, given: Mesh | None) -> None:
        super().__init__(found, source, given)
        arrays, patches, v, t = self._arrays, [], 0, 0
        for rows, columns in arrays["shapes"].tolist():
            vertices, triangles = (rows + 1) * (columns + 1), 2 * rows * columns
            patches.append(
                Patch(
                    arrays["vertices"][v : v + vertices].reshape(rows + 1, columns + 1),
                    arrays["triangles"][t : t + triangles].reshape(rows, columns, 2),
                )
            )
            v, t = v + vertices, t + triangles
        self._set(patches=tuple(patches))

    @property
    def leftover(self) -> NDArray[np.uint32]:
        """Triangles in no patch."""
        return self._arrays["leftover"]

    @property
    def coverage(self) -> float:
        """Share of the triangles that patches hold."""
        return self.record["coverage"]


class FieldResult(_LayoutResult):
    """A frame field; `mesh` carries it: the input with a few splits."""

    __slots__ = ()

    @property
    def u(self) -> NDArray[np.float64]:
        """Unit direction of the first branch in every triangle, (m, 3)."""
        return self._arrays["u"]

    @property
    def v(self) -> NDArray[np.float64]:
        """Unit direction of the second branch, (m, 3)."""
        return self._arrays["v"]

    @property
    def source(self) -> NDArray[np.uint32]:
        """Triangle of the (repaired) input for every triangle."""
        return self._arrays["source"]

    @property
    def features(self) -> NDArray[np.uint32]:
        """Feature edges, (k, 2)."""
        return self._arrays["features"]

    @property
    def matchings(self) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """Triangles i and j of every inner edge that is no feature, (e, 2), and its turn p: branch s of i continues as
        branch s + p modulo 4 of j."""
        return self._arrays["pairs"], self._arrays["turns"]

    @property
    def singularities(self) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """Singular inner vertices, and the number of quads of each."""
        return self._arrays["singular_vertices"], self._arrays["singular_quads"]


class MotorcycleResult(_LayoutResult):
    """A motorcycle graph; `mesh` holds the triangles that it is drawn into: tracks are paths of their edges."""

    __slots__ = ("tracks",)

    tracks: tuple[NDArray[np.uint32], ...]
    """The vertices of every track, from node to node."""

    def __init__(self, found: _core.Found, source: str, given: Mesh | None) -> None:
        super().__init__(found, source, given)
        arrays = self._arrays
        ends = np.cumsum(arrays["track_sizes"])[:-1]
        tracks = np.split(arrays["track_vertices"], ends) if len(arrays["track_sizes"]) else []
        self._set(tracks=tuple(tracks))

    @property
    def labels(self) -> NDArray[np.int32]:
        """Patch of every triangle."""
        return self.mesh.face_attributes["patch"]

    @property
    def corners(self) -> NDArray[np.uint32]:
        """Number of corners of every patch, (p,)."""
        return self._arrays["corners"]

    @property
    def nodes(self) -> NDArray[np.uint32]:
        """The vertices where tracks and features meet, (n,)."""
        return self._arrays["nodes"]

    @property
    def ends(self) -> NDArray[np.uint32]:
        """The two nodes, by their places in `nodes`, that every track runs between, (t, 2)."""
        return self._arrays["track_nodes"]

    @property
    def singularities(self) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """Singular inner vertices, and the number of quads of each."""
        return self._arrays["singular_vertices"], self._arrays["singular_quads"]


class QuadResult(_MeshResult):
    """An all-quad mesh that keeps every feature."""

    __slots__ = ()

    @property
    def quads(self) -> NDArray[np.uint32]:
        """Vertices of the quads, (q, 4)."""
        return self.mesh.faces  # type: ignore[return-value]

    @property
    def rungs(self) -> tuple[Mapping[str, int], ...]:
        """How the quads of each region were made: 1 by the map, 3 of pairs of triangles, 4 of every triangle."""
        return self.record["rungs"]


class SkeletonResult(Result):
    """A curve skeleton with radii."""

    __slots__ = ("skeleton",)

    skeleton: Skeleton
    """The graph, as `hex` takes it."""

    def __init__(self, found: _core.Found, source: str, given: Mesh | None) -> None:
        super().__init__(found, source, given)
        self._set(skeleton=Skeleton._wrap(found.net))

    @property
    def points(self) -> NDArray[np.float64]:
        """Positions of the nodes, (n, 3)."""
        return self.skeleton.points

    @property
    def segments(self) -> NDArray[np.uint32]:
        """Pairs of nodes, (k, 2)."""
        return self.skeleton.segments

    @property
    def radii(self) -> NDArray[np.float64]:
        """Radii of the nodes, (n,)."""
        return self.skeleton.radii

    @property
    def preimage(self) -> NDArray[np.uint32]:
        """The node that every vertex of the closed surface was drawn to."""
        return self._arrays["preimage"]


class HexResult(_MeshResult):
    """A mesh of hexahedra with tagged boundary."""

    __slots__ = ("skeleton",)

    skeleton: Skeleton
    """The skeleton that was meshed, after clean-up."""

    def __init__(self, found: _core.Found, source: str, given: Mesh | None) -> None:
        super().__init__(found, source, given)
        self._set(skeleton=Skeleton._wrap(found.net))

    @property
    def points(self) -> NDArray[np.float64]:
        """Positions of the vertices, (n, 3)."""
        return self.mesh.points

    @property
    def hexes(self) -> NDArray[np.uint32]:
        """Corners of the cells in VTK order, (h, 8)."""
        return self.mesh.hexes

    @property
    def quads(self) -> NDArray[np.uint32]:
        """Boundary faces, outward, (q, 4)."""
        return self.mesh.faces  # type: ignore[return-value]

    @property
    def tags(self) -> NDArray[np.int32]:
        """Tag of every boundary face: 1 the wall, 2, 3 … the open ends."""
        return self.mesh.face_attributes["ref"]

    @property
    def certified(self) -> bool:
        """Whether every cell is certified to have a positive Jacobian everywhere."""
        return self.record["certified"]
