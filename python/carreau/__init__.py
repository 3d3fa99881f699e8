"""carreau turns triangle surfaces into structured models.

>>> import carreau as cr
>>> part = cr.sample("bracket")  # or cr.read("part.stl"), or cr.Mesh(V, F)
>>> faces = cr.segment(part)  # the CAD faces of a part
>>> quads = cr.quad(part, quads=2000)  # an all-quad mesh
>>> quads.mesh.faces.shape[1]
4

Verbs are functions: `segment`, `enrich`, `simplify`, `patch`, `field`, `motorcycle`, `quad`, `skeleton`, `hex`, and
`info`, `compare`, `repair`, `curvature`. Their keyword arguments are the options of the command line. They take a
`Mesh`, a file or a pair of arrays, and return results that do not change. Many files at once: `carreau.batch`.
"""

from . import _core
from ._call import Watch
from ._errors import *  # noqa: F403
from ._errors import __all__ as _errors
from ._mesh import Mesh, Skeleton, read, sample, samples, write
from ._results import *  # noqa: F403
from ._results import __all__ as _results
from ._verbs import (
    Common,
    Preparation,
    cad,
    compare,
    curvature,
    enrich,
    field,
    hex,
    info,
    motorcycle,
    patch,
    quad,
    repair,
    segment,
    simplify,
    skeleton,
)
from .converters import from_meshio, from_pyvista, from_trimesh, to_meshio, to_pyvista, to_trimesh

__version__: str = _core.__version__

__all__ = [
    "Common",
    "Preparation",
    "Mesh",
    "Skeleton",
    "Watch",
    "__version__",
    "cad",
    "compare",
    "curvature",
    "enrich",
    "field",
    "from_meshio",
    "from_pyvista",
    "from_trimesh",
    "hex",
    "info",
    "motorcycle",
    "patch",
    "quad",
    "read",
    "repair",
    "sample",
    "samples",
    "segment",
    "simplify",
    "skeleton",
    "to_meshio",
    "to_pyvista",
    "to_trimesh",
    "write",
    *_errors,
    *_results,
]
