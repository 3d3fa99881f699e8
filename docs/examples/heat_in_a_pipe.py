"""Heat through a bent pipe: triangles to hexahedra with carreau, finite elements with scikit-fem.

The pipe is a sector of a torus, cold at one open end, warm at the other, insulated along its wall. The temperature is
then proportional to the angle around the axis of the bend, and the flow is known: 2π (R − √(R² − a²)) / angle.

    pip install . scikit-fem meshio
    python docs/examples/heat_in_a_pipe.py
"""

import math

import meshio
import numpy as np
import skfem
from skfem.helpers import dot, grad
from skfem.io.meshio import from_meshio

import carreau as cr

BEND, RADIUS, ANGLE = 3.0, 1.0, 1.5


def pipe(along: int = 64, around: int = 48) -> cr.Mesh:
    """The wall of the pipe as triangles, open at both ends."""
    rings = np.linspace(0, ANGLE, along + 1)
    turns = np.linspace(0, 2 * math.pi, around, endpoint=False)
    angle, turn = np.meshgrid(rings, turns, indexing="ij")
    r = BEND + RADIUS * np.cos(turn)
    points = np.stack([r * np.cos(angle), r * np.sin(angle), RADIUS * np.sin(turn)], axis=-1).reshape(-1, 3)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(along), np.arange(around), indexing="ij"))
    k = (j + 1) % around
    a, b, c, d = (i * around + j, (i + 1) * around + j, (i + 1) * around + k, i * around + k)
    return cr.Mesh(points, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]))


def exact_flow() -> float:
    """Heat per time through the pipe for a conductivity and a difference of temperatures of one."""
    return 2 * math.pi * (BEND - math.sqrt(BEND**2 - RADIUS**2)) / ANGLE


@skfem.BilinearForm
def conduction(u, v, _):
    return dot(grad(u), grad(v))


def flow(mesh: skfem.Mesh, element: skfem.Element, cold: np.ndarray, warm: np.ndarray) -> tuple[float, np.ndarray]:
    """The flow, and the temperature of every vertex, with zero and one at the vertices of the two ends."""
    matrix = conduction.assemble(skfem.Basis(mesh, element))
    given = np.zeros(matrix.shape[0])
    given[warm] = 1.0
    temperature = skfem.solve(*skfem.condense(matrix, x=given, D=np.union1d(cold, warm)))
    return float(temperature @ matrix @ temperature), temperature


def model(result: cr.HexResult) -> tuple[skfem.MeshHex, list[np.ndarray]]:
    """The mesh, and the vertices of its ends: boundary faces are tagged, 1 the wall, 2 and 3 the open ends."""
    mesh = from_meshio(meshio.Mesh(result.points, [("hexahedron", result.hexes.astype(np.int64))]))
    return mesh, [np.unique(result.quads[result.tags == tag]).astype(np.int64) for tag in (2, 3)]


def flows(result: cr.HexResult) -> dict[str, float]:
    """Flows by hexahedra, by tetrahedra on the same vertices, and the exact one."""
    mesh, ends = model(result)
    hexes, _ = flow(mesh, skfem.ElementHex1(), *ends)
    tetrahedra, _ = flow(mesh.to_meshtet(), skfem.ElementTetP1(), *ends)
    return {"hexahedra": hexes, "tetrahedra": tetrahedra, "exact": exact_flow()}


if __name__ == "__main__":
    for name, value in flows(cr.hex(pipe())).items():
        print(f"{name:>10}: {value:.4f}")
