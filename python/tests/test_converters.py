"""To and from trimesh, meshio and pyvista: counts, positions, areas, Euler numbers, attributes."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import need

import carreau as cr


def mixed() -> cr.Mesh:
    """A house: five quads, two triangles, a pentagon; an attribute of each kind."""
    points = [
        [0, 0, 0],
        [2, 0, 0],
        [2, 3, 0],
        [0, 3, 0],
        [0, 0, 2],
        [2, 0, 2],
        [2, 3, 2],
        [0, 3, 2],
        [1, 0, 3],
        [1, 3, 3],
    ]
    faces = [
        [0, 3, 2, 1],
        [1, 2, 6, 5],
        [3, 0, 4, 7],
        [0, 1, 5, 8, 4],
        [2, 3, 7, 9],
        [2, 9, 6],
        [5, 6, 9, 8],
        [4, 8, 9, 7],
    ]
    return cr.Mesh(
        points,
        faces,
        edges=[[4, 7], [5, 6]],
        edge_tags=[3, 4],
        vertex_attributes={"height": [p[2] for p in points], "normal": np.ones((10, 3))},
        face_attributes={"wall": np.arange(8), "weight": np.linspace(0, 1, 8)},
    )


def same(a: cr.Mesh, b: cr.Mesh) -> None:
    assert np.array_equal(a.points, b.points)
    assert np.array_equal(a.face_corners, b.face_corners) and np.array_equal(a.face_offsets, b.face_offsets)
    for name, values in a.vertex_attributes.items():
        assert np.array_equal(values, b.vertex_attributes[name]), name
    for name, values in a.face_attributes.items():
        assert np.array_equal(values, b.face_attributes[name]), name


def test_trimesh_agrees_on_counts_areas_and_topology(bracket, torus):
    need("trimesh")
    for mesh in (bracket, torus, cr.quad(bracket, quads=600, quiet=True).mesh):
        other = cr.to_trimesh(mesh)
        assert len(other.vertices) == mesh.n_points and np.array_equal(other.vertices, mesh.points)
        assert other.euler_number == mesh.topology()["euler"]
        assert other.is_watertight and other.is_winding_consistent
        assert np.isclose(other.volume, mesh.triangulated().topology()["volume"])
        assert np.isclose(other.area, mesh.triangulated().quality()["area"])


def test_trimesh_there_and_back(bracket):
    need("trimesh")
    labelled = cr.segment(bracket).mesh
    same(labelled, cr.from_trimesh(cr.to_trimesh(labelled)))
    flat = mixed().to_trimesh()
    assert len(flat.faces) == sum(len(face) - 2 for face in mixed().faces) and np.allclose(
        sorted(set(flat.face_attributes["wall"].tolist())), range(8)
    )


def test_trimesh_makes_what_carreau_reads():
    trimesh = need("trimesh")
    ball = trimesh.creation.icosphere(subdivisions=3, radius=2.0)
    mesh = cr.from_trimesh(ball)
    assert mesh.topology()["closed"] and np.isclose(mesh.quality()["area"], ball.area)
    regions = cr.segment(mesh).regions
    assert [region["primitive"]["type"] for region in regions] == ["sphere"]
    assert np.isclose(regions[0]["primitive"]["radius"], 2.0, rtol=1e-3)


def test_meshio_there_and_back():
    need("meshio")
    mesh = mixed()
    other = mesh.to_meshio()
    assert sum(len(block.data) for block in other.cells if block.type != "line") == mesh.n_faces
    back = cr.from_meshio(other)
    same(mesh, back)
    assert np.array_equal(back.edges, mesh.edges) and np.array_equal(back.edge_tags, mesh.edge_tags)


@pytest.mark.parametrize("extension", ["obj", "off", "ply", "stl", "vtu", "mesh", "msh"])
def test_meshio_reads_what_carreau_writes(tmp_path, torus, extension):
    meshio = need("meshio")
    path = tmp_path / f"torus.{extension}"
    cr.Mesh(torus.points, torus.faces).write(path)
    other = cr.from_meshio(meshio.read(path))
    if extension == "stl":
        other = cr.repair(other, quiet=True).mesh
    exact = extension not in ("stl",)
    assert (other.n_points, other.n_faces) == (torus.n_points, torus.n_faces)
    assert other.topology()["euler"] == 0
    assert np.isclose(other.quality()["area"], torus.quality()["area"], rtol=1e-12 if exact else 1e-5)
    if exact:
        assert np.array_equal(other.points, torus.points) and np.array_equal(other.faces, torus.faces)


@pytest.mark.parametrize("extension", ["obj", "ply", "stl", "vtk", "vtu", "mesh"])
def test_carreau_reads_what_meshio_writes(tmp_path, torus, extension):
    meshio = need("meshio")
    path = tmp_path / f"torus.{extension}"
    meshio.write_points_cells(path, np.array(torus.points), [("triangle", np.array(torus.faces, np.int64))])
    mesh = cr.read(path)
    assert mesh.n_faces == torus.n_faces and mesh.topology()["euler"] == 0
    assert np.isclose(mesh.quality()["area"], torus.quality()["area"], rtol=1e-5)


@pytest.mark.parametrize("extension", ["vtu", "vtk", "mesh", "msh"])
def test_hexahedra_through_meshio(tmp_path, tube, extension):
    meshio = need("meshio")
    result = cr.hex(tube, hexes=200, quiet=True)
    path = tmp_path / f"tube.{extension}"
    result.mesh.write(path)
    other = meshio.read(path)
    hexes = np.vstack([block.data for block in other.cells if block.type == "hexahedron"])
    assert np.array_equal(hexes, result.hexes) and np.allclose(other.points, result.points, rtol=0, atol=0)
    quads = np.vstack([block.data for block in other.cells if block.type == "quad"])
    assert len(quads) == len(result.quads)
    back = cr.from_meshio(result.mesh.to_meshio())
    assert np.array_equal(back.hexes, result.hexes)
    assert np.array_equal(back.face_attributes["ref"], result.tags)


def test_cells_that_have_no_place_are_refused():
    meshio = need("meshio")
    tet = meshio.Mesh(np.eye(4)[:, :3], [("tetra", [[0, 1, 2, 3]])])
    with pytest.raises(cr.InputError, match="tetra"):
        cr.from_meshio(tet)


def test_pyvista_there_and_back():
    need("pyvista")
    mesh = mixed()
    other = mesh.to_pyvista()
    assert other.n_points == mesh.n_points and other.n_cells == mesh.n_faces
    same(mesh, cr.from_pyvista(other))


def test_pyvista_agrees_on_areas_and_quads(bracket):
    need("pyvista")
    result = cr.quad(bracket, quads=600, quiet=True)
    other = result.mesh.to_pyvista()
    assert other.n_cells == len(result.quads)
    assert np.isclose(other.area, result.mesh.quality()["area"], rtol=1e-3)
    assert np.isclose(bracket.to_pyvista().volume, bracket.topology()["volume"])
    assert other.n_open_edges == 0 and other.is_manifold
    assert np.array_equal(other.cell_data["region"], result.mesh.face_attributes["region"])


def test_hexahedra_in_pyvista(tube):
    need("pyvista")
    result = cr.hex(tube, hexes=200, quiet=True)
    grid = result.mesh.to_pyvista()
    assert grid.n_cells == len(result.hexes) and set(grid.celltypes.tolist()) == {12}
    assert np.isclose(grid.volume, result.record["volume"], rtol=0.02)
    skin = (
        grid.extract_surface(algorithm="geometry")
        if "algorithm" in grid.extract_surface.__doc__
        else grid.extract_surface()
    )
    assert skin.n_cells == len(result.quads)
    back = cr.from_pyvista(grid)
    assert np.array_equal(back.hexes, result.hexes)


def test_pyvista_makes_what_carreau_reads():
    pyvista = need("pyvista")
    cylinder = pyvista.Cylinder(radius=1.0, height=4.0, resolution=48, capping=True).clean()
    mesh = cr.from_pyvista(cylinder)
    assert {len(face) for face in mesh.faces} == {4, 48}
    assert mesh.topology()["closed"] and np.isclose(
        mesh.triangulated().topology()["volume"], cylinder.volume, rtol=1e-6
    )
    kinds = sorted(region["primitive"]["type"] for region in cr.segment(mesh, quiet=True).regions)
    assert kinds == ["cylinder", "plane", "plane"]


def test_foreign_meshes_come_with_a_hint(torus):
    need("trimesh")
    with pytest.raises(TypeError, match=r"cr\.from_trimesh"):
        cr.segment(torus.to_trimesh())
