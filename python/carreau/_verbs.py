"""The verbs: one function each, with the options of the command line as keyword arguments.

Options keep the command line's names, with underscores, and its meaning: what is not given (None) is the default,
angles are in degrees, a length is a number in the unit of the mesh or a share of the bounding-box diagonal ("1%"), and
words such as "none", "auto" or "off" are strings. Names and values are checked by the command line's own parser.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict, Unpack

from numpy.typing import ArrayLike

from ._call import Watch, run
from ._mesh import Mesh, Skeleton
from ._results import (
    CadResult,
    CompareResult,
    CurvatureResult,
    FieldResult,
    HexResult,
    InfoResult,
    MotorcycleResult,
    PatchResult,
    QuadResult,
    RemeshResult,
    RepairResult,
    Result,
    SegmentResult,
    SkeletonResult,
)

__all__ = [
    "cad",
    "compare",
    "curvature",
    "enrich",
    "field",
    "hex",
    "info",
    "motorcycle",
    "patch",
    "quad",
    "repair",
    "segment",
    "simplify",
    "skeleton",
]

File: TypeAlias = str | os.PathLike[str]
#: A mesh, a file, or points and faces.
Surface: TypeAlias = Mesh | File | tuple[ArrayLike, ArrayLike | Sequence[Sequence[int]]]
#: A number in the unit of the mesh, or a share of its diagonal such as "1%".
Length: TypeAlias = float | str
Estimator: TypeAlias = Literal["corrected", "normal-cycle-1ring", "normal-cycle-ball", "mepp"]


class Common(TypedDict, total=False):
    """Keyword arguments that every verb has.

    Attributes
    ----------
    output : path
        A file to write, too; the extension decides.
    json : path
        A file for the result record.
    picture : path
        A file for a picture of the result (PNG).
    report : path
        A file for a page (HTML) that shows input and result.
    options : path, Result or mapping
        Options of an earlier run: a file, its result, its record. Keyword arguments win over them.
    threads : int
        Number of threads (0: all processors); results do not depend on it.
    seed : int
        Seed of pseudo-random choices.
    deadline : float
        Gives up after this many seconds with `DeadlineError`.
    unit : {"mm", "cm", "m", "in"}
        Unit of the input's lengths, written into CAD files.
    quiet : bool
        Neither warnings nor a progress bar.
    verbose : bool or int
        Logs to stderr; 2 in detail.
    progress : bool or callable
        A progress bar (needs tqdm), or a function of a stage's name and the share of it that is done. By default a bar
        where stderr is a terminal or in a notebook.
    """

    output: File | None
    json: File | None
    picture: File | None
    report: File | None
    options: File | Result | Mapping[str, Any] | None
    threads: int | None
    seed: int | None
    deadline: float | None
    unit: Literal["mm", "cm", "m", "in"] | None
    quiet: bool
    verbose: bool | int
    progress: bool | Watch | None


class Preparation(Common, total=False):
    """Keyword arguments of every verb that takes a surface, besides those of `Common`.

    Attributes
    ----------
    weld : float or str
        Vertices nearer than this become one (0: those at equal positions).
    keep : {"all", "largest"} or float or str
        Pieces that stay: all, the largest, or those with at least this share of the largest one's area. By default all;
        the largest where a method takes one body.
    as_is : bool
        The surface is taken as it is: nothing is welded, left out or turned.
    """

    weld: Length | None
    keep: float | str | None
    as_is: bool


def _options(arguments: dict[str, Any], *inputs: str) -> dict[str, Any]:
    """The options among the local names of a verb."""
    common = arguments.pop("common")
    return {name: value for name, value in arguments.items() if name not in inputs} | common


def _progress(options: dict[str, Any]) -> bool | Watch | None:
    return options.pop("progress", None)


def cad(
    mesh: Surface,
    *,
    style: Literal["auto", "mechanical", "organic"] | None = None,
    tolerance: Length | None = None,
    labels: ArrayLike | str | None = None,
    snap: Literal["on", "off"] | None = None,
    max_faces: int | None = None,
    **common: Unpack[Common],
) -> CadResult:
    """Make a CAD model with the faces that the part really has; ``output="part.step"`` writes it.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The surface; polygons are cut into triangles.
    style : {"auto", "mechanical", "organic"}, optional
        What kind of model is made: the faces of a part, or smooth faces over all of a scan ("organic"); "auto" makes
        these where no region has a surface with a name, and where more than half of a part would be plane
        facets ("auto").
    tolerance : float or str, optional
        Largest distance of a vertex from its face; from the data, for "organic" .1 % of the diagonal.
    labels : array_like of int, str or path, optional
        Faces as given, one label per triangle: an array, the name of a face attribute, or a file.
    snap : {"on", "off"}, optional
        Adjust the surfaces of noisy meshes to each other: directions, axes, equal radii, round numbers ("on").
    max_faces : int, optional
        Refuse models of more faces.
    **common
        Options that every verb has, see `Common`.

    Returns
    -------
    CadResult
        Face of every triangle, and the faces with their kinds and figures.

    Examples
    --------
    >>> import carreau as cr
    >>> result = cr.cad(cr.sample("bracket"))
    >>> len(result.faces), result.record["solids"]
    (13, 1)
    >>> sorted({face.kind for face in result.faces})
    ['cylinder', 'plane']
    """
    options = _options(locals(), "mesh")
    return run("cad", CadResult, (mesh,), options, _progress(options))


def segment(
    mesh: Surface,
    *,
    preset: Literal["default", "paper"] | None = None,
    surfaces: bool | None = None,
    clusters: int | None = None,
    merge_threshold: float | Literal["auto"] | None = None,
    regions: int | None = None,
    rectify: Literal["paper", "cut", "none"] | None = None,
    labels: ArrayLike | str | None = None,
    sharp_angle: float | None = None,
    score_threshold: float | None = None,
    estimator: Estimator | None = None,
    radius: Length | None = None,
    scale: Literal["largest-side", "root-area"] | None = None,
    min_area: float | None = None,
    tolerance: Length | None = None,
    **common: Unpack[Preparation],
) -> SegmentResult:
    """Find the faces of a part and the surface that each lies on.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The surface; polygons are cut into triangles.
    preset : {"default", "paper"}, optional
        All options of the paper's pipeline, or the defaults.
    surfaces : bool, optional
        Recognise planes, spheres, cylinders, cones and tori before curvature is asked (True).
    clusters : int, optional
        Number of clusters of curvature; from the data.
    merge_threshold : float or "auto", optional
        Largest distance of regions that are merged.
    regions : int, optional
        Merge regions of near-constant curvature down to this number.
    rectify : {"paper", "cut", "none"}, optional
        How boundaries are corrected ("cut").
    labels : array_like of int, str or path, optional
        Start from these labels, one per triangle: an array, the name of a face attribute, or a file.
    sharp_angle : float, optional
        Edges that bend by more are sharp, in degrees; from the data, near 25.
    score_threshold : float, optional
        Boundary edges with a lower score are correct, for ``rectify="paper"`` (0.2).
    estimator : {"corrected", "normal-cycle-1ring", "normal-cycle-ball", "mepp"}, optional
        How curvatures are estimated ("corrected").
    radius : float or str, optional
        Radius of the estimator "normal-cycle-ball"; three mean edge lengths.
    scale : {"largest-side", "root-area"}, optional
        The length that curvatures are multiplied by.
    min_area : float, optional
        Smaller regions are merged first, as a share of the area (0.001).
    tolerance : float or str, optional
        Largest distance of a region's vertices from its surface ("0.003%").
    **common
        Options that every verb on a surface has, see `Preparation` and `Common`.

    Returns
    -------
    SegmentResult
        Labels, regions with their surfaces, boundaries.

    Examples
    --------
    >>> import carreau as cr
    >>> result = cr.segment(cr.sample("bracket"))
    >>> len(result.regions)
    13
    >>> sorted({region["primitive"]["type"] for region in result.regions})
    ['cylinder', 'plane']
    """
    options = _options(locals(), "mesh")
    return run("segment", SegmentResult, (mesh,), options, _progress(options))


def enrich(
    mesh: Surface,
    *,
    deviation: float | None = None,
    gradation: float | Literal["off"] | None = None,
    feature_angle: float | None = None,
    features: ArrayLike | File | None = None,
    ignore_tags: bool = False,
    labels: ArrayLike | str | None = None,
    sizes: ArrayLike | str | None = None,
    min_size: Length | None = None,
    max_size: Length | None = None,
    **common: Unpack[Preparation],
) -> RemeshResult:
    """Refine a surface to an angular deviation.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The surface; polygons are cut into triangles.
    deviation : float, optional
        Angle between edges and the surface, in degrees (5).
    gradation : float or "off", optional
        Largest ratio of sizes over one unit of length (1.5).
    feature_angle : float, optional
        Every edge with a larger angle between its faces stays, in degrees (180: none; without it: creases of 35°
        alone).
    features : "auto", array_like of int (k, 2) or path, optional
        "auto": creases at the size of the result stay; or these besides: pairs of vertices, or a file.
    labels : array_like of int or str, optional
        Labels of faces, or the face attribute that has them: edges between two values stay.
    sizes : array_like of float or str, optional
        No edge shall be longer than these, one per vertex: an array, or a vertex attribute.
    ignore_tags : bool
        Marked edges of the mesh are not special.
    min_size, max_size : float or str, optional
        Smallest and largest edge length ("0.02%", "20%").
    **common
        Options that every verb on a surface has, see `Preparation` and `Common`.

    Returns
    -------
    RemeshResult
        The mesh, with the vertex attribute ``size``.

    Examples
    --------
    >>> import carreau as cr
    >>> coarse = cr.sample("icosphere", 8)
    >>> fine = cr.enrich(coarse, deviation=3)
    >>> fine.mesh.n_faces > 4 * coarse.n_faces
    True
    """
    options = _options(locals(), "mesh")
    return run("enrich", RemeshResult, (mesh,), options, _progress(options))


def simplify(
    mesh: Surface,
    *,
    deviation: float | None = None,
    triangles: int | None = None,
    distance: Length | None = None,
    gradation: float | Literal["off"] | None = None,
    feature_angle: float | None = None,
    features: ArrayLike | File | None = None,
    ignore_tags: bool = False,
    labels: ArrayLike | str | None = None,
    sizes: ArrayLike | str | None = None,
    min_size: Length | None = None,
    max_size: Length | None = None,
    enrich: float | Literal["off"] | None = None,
    anisotropic: bool = False,
    geometric: bool = False,
    **common: Unpack[Preparation],
) -> RemeshResult:
    """Coarsen a surface to an angular deviation, a number of triangles or a distance.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The surface; polygons are cut into triangles.
    deviation : float, optional
        Angle between edges and the surface, in degrees (14).
    triangles : int, optional
        Number of triangles, met within 1 %.
    distance : float or str, optional
        Largest distance between input and output, both ways.
    gradation : float or "off", optional
        Largest ratio of sizes over one unit of length (1.5).
    feature_angle : float, optional
        Every edge with a larger angle between its faces stays, in degrees (180: none; without it: creases of 35°
        alone).
    features : "auto", array_like of int (k, 2) or path, optional
        "auto": creases at the size of the result stay; or these besides: pairs of vertices, or a file.
    labels : array_like of int or str, optional
        Labels of faces, or the face attribute that has them: edges between two values stay.
    sizes : array_like of float or str, optional
        No edge shall be longer than these, one per vertex: an array, or a vertex attribute.
    ignore_tags : bool
        Marked edges of the mesh are not special.
    min_size, max_size : float or str, optional
        Smallest and largest edge length ("0.02%", "20%").
    enrich : float or "off", optional
        Enrich to this angle first ("off").
    anisotropic : bool
        Edges are longer where the surface bends less.
    geometric : bool
        Shapes are left aside: as near to the surface as the number of triangles allows.
    **common
        Options that every verb on a surface has, see `Preparation` and `Common`.

    Returns
    -------
    RemeshResult
        The mesh, with the vertex attribute ``size``.

    Examples
    --------
    >>> import carreau as cr
    >>> light = cr.simplify(cr.sample("torus", 60), triangles=1000)
    >>> abs(light.mesh.n_faces - 1000) <= 10
    True
    """
    options = _options(locals(), "mesh")
    return run("simplify", RemeshResult, (mesh,), options, _progress(options))


def patch(
    mesh: Surface,
    *,
    layout: File | None = None,
    preset: Literal["default", "paper"] | None = None,
    strategy: Literal["grow", "zones", "matching", "matching-cardinality"] | None = None,
    policy: Literal["paper", "keep-first"] | None = None,
    min_cells: int | None = None,
    q_max: float | None = None,
    dihedral: float | None = None,
    adapt_dihedral: bool = False,
    convex_only: bool = False,
    quality: Literal["angles", "adapted", "jacobian"] | None = None,
    dissection: Literal["greedy", "longest-row", "minimum"] | None = None,
    merge: bool | None = None,
    probes: int | None = None,
    crease_angle: float | None = None,
    feature_angle: float | None = None,
    features: ArrayLike | File | None = None,
    ignore_tags: bool = False,
    fit: Literal["auto", "bilinear", "bicubic"] | None = None,
    tolerance: Length | None = None,
    trimmed: bool = False,
    schema: Literal["ap214", "ap242"] | None = None,
    **common: Unpack[Preparation],
) -> PatchResult:
    """Decompose a triangle mesh into quad patches, on its own vertices.

    With ``output="part.step"`` (or .stp, .igs, .iges) a CAD file is written: planes, and faces without bends.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The surface; polygons are cut into triangles.
    layout : path, optional
        A file for the patches as grids of ids (JSON); see also `PatchResult.patches`.
    preset : {"default", "paper"}, optional
        All options of the paper's pipeline, or the defaults.
    strategy : {"grow", "zones", "matching", "matching-cardinality"}, optional
        How patches are found ("grow").
    policy : {"paper", "keep-first"}, optional
        What happens where rows and columns contradict each other ("keep-first").
    min_cells : int, optional
        Smallest patch, in cells (2; 1 keeps single quads).
    q_max : float, optional
        Largest Q of equation 1, in degrees (90).
    dihedral : float, optional
        Largest angle between the two triangles of a quad, in degrees (30).
    adapt_dihedral : bool
        Accept a larger angle where the surface around bends as much.
    convex_only : bool
        Accept no quad with a corner above 180 degrees.
    quality : {"angles", "adapted", "jacobian"}, optional
        How candidate quads are ranked ("angles").
    dissection : {"greedy", "longest-row", "minimum"}, optional
        How polygons are cut into rectangles ("minimum").
    merge : bool, optional
        Join patches along complete common sides (True).
    probes : int, optional
        Rectangles tried through each triangle by the strategy "grow"; 0 tries all.
    crease_angle : float, optional
        Strategy "grow": rectangles end at sharper creases, in degrees (40).
    feature_angle : float, optional
        Never cross edges with more than this angle between the faces, in degrees.
    features : array_like of int (k, 2) or path, optional
        Never cross these edges: pairs of vertices, or a file.
    ignore_tags : bool
        Cross marked edges, too.
    fit : {"auto", "bilinear", "bicubic"}, optional
        CAD faces: planes, and patches divided at their bends; curved patches as splines within the tolerance, too; or
        one face a patch, whose area and volume many programs get wrong ("auto").
    tolerance : float or str, optional
        Largest distance of a vertex from a bicubic face ("0.1%").
    trimmed : bool
        One trimmed CAD face per rectilinear polygon instead of one face per patch.
    schema : {"ap214", "ap242"}, optional
        Application protocol of STEP files ("ap214").
    **common
        Options that every verb on a surface has, see `Preparation` and `Common`.

    Returns
    -------
    PatchResult
        Patches, triangles left over, and the mesh of the cells.

    Examples
    --------
    >>> import carreau as cr
    >>> result = cr.patch(cr.sample("torus", 40))
    >>> result.coverage > 0.9
    True
    >>> result.patches[0].vertices.shape[0] == result.patches[0].triangles.shape[0] + 1
    True
    """
    options = _options(locals(), "mesh")
    return run("patch", PatchResult, (mesh,), options, _progress(options))


def field(
    mesh: Surface,
    *,
    layout: File | None = None,
    orthogonal: bool = False,
    pin: Literal["none", "45", "90", 45, 90] | None = None,
    propagation: Literal["none", "local", "global"] | None = None,
    lean: float | None = None,
    curvature: float | None = None,
    guides: File | None = None,
    feature_angle: float | None = None,
    features: ArrayLike | File | None = None,
    ignore_tags: bool = False,
    classic: bool = False,
    **common: Unpack[Preparation],
) -> FieldResult:
    """Frame field aligned with features, with room for a quad in every corner.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The surface; polygons are cut into triangles.
    layout : path, optional
        A file for mesh, frames, matchings and the quads of every corner (JSON); see also `FieldResult.layout`.
    orthogonal : bool
        The two directions stay orthogonal.
    pin : {"none", 45, 90}, optional
        Corners below this angle get one quad (90); "none": the classic field, without any repair.
    propagation : {"none", "local", "global"}, optional
        How far the turn that pinned corners ask for spreads ("local").
    lean : float, optional
        Largest angle by which the two directions lean towards each other, in degrees (60).
    curvature : float, optional
        Weight of the directions of curvature beside the smoothness (0).
    guides : path, optional
        A file of polylines on the surface that the field follows.
    feature_angle : float, optional
        Every edge with a larger angle between its faces is a feature, in degrees (180: none is; without it: creases of
        35° alone).
    features : "auto", array_like of int (k, 2) or path, optional
        "auto": creases at the size of the result; or these besides: pairs of vertices, or a file.
    ignore_tags : bool
        Marked edges of the mesh are not special.
    classic : bool
        Count the corners without room and the singularities of the classic field, too.
    **common
        Options that every verb on a surface has, see `Preparation` and `Common`.

    Returns
    -------
    FieldResult
        The mesh that carries the field, frames, matchings, singularities.

    Examples
    --------
    >>> import carreau as cr
    >>> found = cr.field(cr.sample("bracket", 30))
    >>> found.u.shape == found.v.shape == (found.mesh.n_faces, 3)
    True
    """
    options = _options(locals(), "mesh")
    return run("field", FieldResult, (mesh,), options, _progress(options))


def motorcycle(
    mesh: Surface,
    *,
    layout: File | None = None,
    quads: int | None = None,
    edge_length: Length | None = None,
    feature_angle: float | None = None,
    features: ArrayLike | File | None = None,
    ignore_tags: bool = False,
    **common: Unpack[Preparation],
) -> MotorcycleResult:
    """Motorcycle graph of a frame field: tracks that divide a surface into patches for quads.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The surface; polygons are cut into triangles.
    layout : path, optional
        A file for mesh, nodes, tracks, arcs and the sides of every patch (JSON); see also `MotorcycleResult.layout`.
    quads : int, optional
        Number of quads that the graph is for: tracks nearer than half of one are joined (3000).
    edge_length : float or str, optional
        Length of their edges instead.
    feature_angle : float, optional
        Every edge with a larger angle between its faces is a feature, in degrees (180: none is; without it: creases of
        35° alone).
    features : "auto", array_like of int (k, 2) or path, optional
        "auto": creases at the size of the result; or these besides: pairs of vertices, or a file.
    ignore_tags : bool
        Marked edges of the mesh are not special.
    **common
        Options that every verb on a surface has, see `Preparation` and `Common`.

    Returns
    -------
    MotorcycleResult
        The triangles with the patch of each, tracks, nodes, corners of the patches.

    Examples
    --------
    >>> import carreau as cr
    >>> graph = cr.motorcycle(cr.sample("bracket", 30))
    >>> len(graph.corners) == len(set(graph.labels.tolist()))
    True
    """
    options = _options(locals(), "mesh")
    return run("motorcycle", MotorcycleResult, (mesh,), options, _progress(options))


def quad(
    mesh: Surface,
    *,
    quads: int | None = None,
    edge_length: Length | None = None,
    adaptive: bool = False,
    sizes: str | None = None,
    symmetry: Literal["off", "x", "y", "z", "auto"] | None = None,
    guides: File | None = None,
    curvature: float | None = None,
    max_quads: int | None = None,
    feature_angle: float | None = None,
    features: ArrayLike | File | None = None,
    ignore_tags: bool = False,
    rung: int | None = None,
    **common: Unpack[Preparation],
) -> QuadResult:
    """All-quad mesh that keeps every feature.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The surface; polygons are cut into triangles.
    quads : int, optional
        Number of quads, met within 10 % where the features allow it (3000).
    edge_length : float or str, optional
        Length of the edges instead.
    adaptive : bool
        Make quads smaller where the surface bends and larger where it is flat; their number stays.
    sizes : str, optional
        A vertex attribute that says how long the edges are to be, relative to each other; of a colour, red makes quads
        smaller.
    symmetry : {"off", "x", "y", "z", "auto"}, optional
        Make the quads of one half and mirror them: across an axis, or across all planes of symmetry ("off").
    guides : path, optional
        A file of polylines on the surface that rows of quads follow.
    curvature : float, optional
        Weight of the directions of curvature in the field; 0 gives fewer irregular vertices (0.03).
    max_quads : int, optional
        More quads are refused.
    feature_angle : float, optional
        Every edge with a larger angle between its faces is a feature, in degrees (180: none is; without it: creases of
        35° alone).
    features : "auto", array_like of int (k, 2) or path, optional
        "auto": creases at the size of the result; or these besides: pairs of vertices, or a file.
    ignore_tags : bool
        Marked edges of the mesh are not special.
    rung : int, optional
        The first method to try: 1 the map, 3 pairs of triangles, 4 every triangle in three, which always works (1).
    **common
        Options that every verb on a surface has, see `Preparation` and `Common`.

    Returns
    -------
    QuadResult
        The mesh, with features as marked edges and the face attribute ``region``.

    Examples
    --------
    >>> import carreau as cr
    >>> cr.quad(cr.sample("bracket", 30), quads=800).quads.shape[1]
    4
    """
    options = _options(locals(), "mesh")
    return run("quad", QuadResult, (mesh,), options, _progress(options))


def skeleton(
    mesh: Surface,
    *,
    speed: float | None = None,
    medial: float | None = None,
    detail: float | None = None,
    no_prune: bool = False,
    **common: Unpack[Preparation],
) -> SkeletonResult:
    """Curve skeleton of a surface, with radii.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The surface; open ends are closed.
    speed : float, optional
        Pull back to where a vertex is: more is slower and closer to the shape (0.1).
    medial : float, optional
        Pull to the centre of the inner ball (0.2).
    detail : float, optional
        Edges shorter than this share of the diagonal are collapsed on the way (0.002).
    no_prune : bool
        Keep branches that stay within the ball of their branching.
    **common
        Options that every verb on a surface has, see `Preparation` and `Common`.

    Returns
    -------
    SkeletonResult
        Nodes, segments and radii; its `skeleton` is what `hex` takes.

    Examples
    --------
    >>> import carreau as cr
    >>> cr.skeleton(cr.sample("torus", 40)).record["cycles"]
    1
    """
    options = _options(locals(), "mesh")
    return run("skeleton", SkeletonResult, (mesh,), options, _progress(options))


def hex(
    shape: Surface | Skeleton,
    *,
    skeleton: Skeleton | File | None = None,
    surface: Mesh | File | None = None,
    padding: Literal["none", "sides", "all"] | None = None,
    refine_across: int | None = None,
    refine_along: int | None = None,
    hexes: int | None = None,
    edge_length: Length | None = None,
    radius: Length | None = None,
    adapt_radius: bool = False,
    stage: Literal["base", "full"] | None = None,
    layers: int | None = None,
    first_layer: Length | None = None,
    growth: float | None = None,
    extend: float | None = None,
    order: Literal[1, 2] | None = None,
    allow_invalid: bool = False,
    max_distance: Length | None = None,
    allow_far: bool = False,
    **common: Unpack[Preparation],
) -> HexResult:
    """Mesh a tubular surface, or the tubes around a skeleton, with hexahedra.

    Parameters
    ----------
    shape : Mesh, Skeleton, path or (points, faces)
        The surface or the skeleton.
    skeleton : Skeleton or path, optional
        The skeleton of the surface; found where it is not given.
    surface : Mesh or path, optional
        The surface around the skeleton.
    padding : {"none", "sides", "all"}, optional
        Layer of hexes on the boundary ("all").
    refine_across, refine_along : int, optional
        Halve every cell across and along its axis this many times.
    hexes : int, optional
        About this many hexes, at most: sets the steps along the branches.
    edge_length : float or str, optional
        Length of the steps along the branches.
    radius : float or str, optional
        One radius for all nodes.
    adapt_radius : bool
        Insert cells where a branch of a skeleton is more than twice as thick as where it is thinnest.
    stage : {"base", "full"}, optional
        "base": the graph as given, without clean-up and resampling ("full").
    layers : int, optional
        Put this many boundary layers on the wall, thin ones for flow; goes with `first_layer`.
    first_layer : float or str, optional
        Thickness of the first layer, on the wall.
    growth : float, optional
        Thickness of every layer over that of the one before it (1.2).
    extend : float, optional
        Lengthen every end by a straight piece of this many of its radii.
    order : {1, 2}, optional
        2: cells have nodes in the middle of edges and faces, too, those of the boundary on the surface (1).
    allow_invalid : bool
        Return cells without a certificate too; the record lists them.
    max_distance : float or str, optional
        Largest distance between cells and surface, either way, that is no error ("2%").
    allow_far : bool
        Return cells that are farther than that from the surface, or lie where others are, too.
    **common
        Options that every verb on a surface has, see `Preparation` and `Common`.

    Returns
    -------
    HexResult
        Points, hexahedra, boundary quads and their tags.

    Examples
    --------
    >>> import carreau as cr
    >>> tube = cr.Skeleton([[0, 0, 0], [0, 0, 3], [0, 0, 6]], [[0, 1], [1, 2]], radii=[1, 1, 1])
    >>> result = cr.hex(tube, hexes=200)
    >>> result.certified, sorted(set(result.tags.tolist()))
    (True, [1, 2, 3])
    """
    options = _options(locals(), "shape")
    return run("hex", HexResult, (shape,), options, _progress(options))


def repair(
    mesh: Surface,
    *,
    weld: Length | None = None,
    no_weld: bool = False,
    keep_degenerate: bool = False,
    keep_duplicates: bool = False,
    no_orient: bool = False,
    no_split: bool = False,
    keep_unreferenced: bool = False,
    keep: float | str | None = None,
    fill_holes: int | Literal["all"] | None = None,
    orient: bool = False,
    **common: Unpack[Common],
) -> RepairResult:
    """Weld, drop degenerate and duplicate faces, orient, split what is not manifold.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The surface.
    weld : float or str, optional
        Weld vertices nearer than this (0: at equal positions).
    no_weld, keep_degenerate, keep_duplicates, no_orient, no_split, keep_unreferenced : bool
        Leave out a step.
    keep : {"all", "largest"} or float or str, optional
        Pieces that stay: all, the largest, or those with at least this share of the largest one's area ("all").
    fill_holes : int or "all", optional
        Fill holes of up to this many border edges, or all: least area, refined and smoothed like the surroundings; the
        record's ``filled`` has the new faces and vertices of each.
    orient : bool
        Turn faces even where replayed options say not to.
    **common
        Options that every verb has, see `Common`.

    Returns
    -------
    RepairResult
        The mesh, and what was done in `report`.

    Examples
    --------
    >>> import carreau as cr
    >>> soup = cr.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]], [[0, 1, 2], [3, 4, 5]])
    >>> cr.repair(soup, quiet=True).mesh.n_points
    4
    """
    options = _options(locals(), "mesh")
    return run("repair", RepairResult, (mesh,), options, _progress(options))


def curvature(
    mesh: Surface,
    *,
    estimator: Estimator | None = None,
    radius: Length | None = None,
    feature_angle: float | None = None,
    **common: Unpack[Preparation],
) -> CurvatureResult:
    """Principal curvatures and directions at every vertex.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The surface; polygons are cut into triangles.
    estimator : {"corrected", "normal-cycle-1ring", "normal-cycle-ball", "mepp"}, optional
        How curvatures are estimated ("corrected").
    radius : float or str, optional
        Radius of the estimator "normal-cycle-ball".
    feature_angle : float, optional
        Edges with a larger angle between their faces are features, in degrees (25).
    **common
        Options that every verb on a surface has, see `Preparation` and `Common`.

    Returns
    -------
    CurvatureResult
        Curvatures and directions, also as vertex attributes of `mesh`.

    Examples
    --------
    >>> import carreau as cr
    >>> ball = cr.curvature(cr.sample("icosphere"))
    >>> bool(abs(ball.kmax - 1).max() < 0.1)
    True
    """
    options = _options(locals(), "mesh")
    return run("curvature", CurvatureResult, (mesh,), options, _progress(options))


def info(
    mesh: Surface, *, walls: Length | None = None, gaps: Length | None = None, **common: Unpack[Common]
) -> InfoResult:
    """Counts, topology, defects with their places, and quality of a mesh.

    Parameters
    ----------
    mesh : Mesh, path or (points, faces)
        The mesh.
    walls : float or str, optional
        Count faces whose wall, through the material to the opposite face, is thinner than this.
    gaps : float or str, optional
        Count faces with an opposite one before them that is nearer than this.
    **common
        Options that every verb has, see `Common`; ``output`` is none of them.

    Returns
    -------
    InfoResult
        Everything is in its record.

    Examples
    --------
    >>> import carreau as cr
    >>> cr.info(cr.sample("torus")).topology["euler"]
    0
    """
    options = _options(locals(), "mesh")
    return run("info", InfoResult, (mesh,), options, _progress(options))


def compare(a: Surface, b: Surface, *, samples: int | None = None, **common: Unpack[Preparation]) -> CompareResult:
    """How far two surfaces are apart, both ways.

    Parameters
    ----------
    a, b : Mesh, path or (points, faces)
        The surfaces.
    samples : int, optional
        Number of sample points on each.
    **common
        Options that every verb has, see `Common`; ``output`` is none of them.

    Returns
    -------
    CompareResult
        Distances, in the unit of the meshes and as shares of the first one's diagonal.

    Examples
    --------
    >>> import carreau as cr
    >>> mesh = cr.sample("torus")
    >>> cr.compare(mesh, mesh).distance["max"] < 1e-12
    True
    """
    options = _options(locals(), "a", "b")
    return run("compare", CompareResult, (a, b), options, _progress(options))
