"""Meshes and skeletons: arrays, checks, files."""

from __future__ import annotations

import gc
import pickle

import numpy as np
import pytest

import carreau as cr

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)


def every_array(mesh: cr.Mesh):
    yield from (mesh.points, mesh.face_corners, mesh.face_offsets, mesh.edges, mesh.edge_tags, mesh.hexes)
    yield from mesh.vertex_attributes.values()
    yield from mesh.face_attributes.values()
    if isinstance(mesh.faces, np.ndarray):
        yield mesh.faces


def rich() -> cr.Mesh:
    return cr.Mesh(
        SQUARE,
        [[0, 1, 2], [0, 2, 3]],
        edges=[[0, 2]],
        edge_tags=[7],
        vertex_attributes={"t": [0.5, 1, 2, 3], "uv": np.arange(8.0).reshape(4, 2), "n": np.eye(4)[:, :3]},
        face_attributes={"id": [3, -4], "rgba": np.arange(8, dtype=np.uint8).reshape(2, 4)},
    )


def test_arrays_are_those_that_were_given():
    mesh = rich()
    assert np.array_equal(mesh.points, SQUARE)
    assert np.array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])
    assert np.array_equal(mesh.edges, [[0, 2]]) and mesh.edge_tags.tolist() == [7]
    assert mesh.vertex_attributes["t"].tolist() == [0.5, 1, 2, 3]
    assert mesh.vertex_attributes["uv"].shape == (4, 2) and mesh.vertex_attributes["n"].shape == (4, 3)
    assert mesh.face_attributes["id"].dtype == np.int32 and mesh.face_attributes["id"].tolist() == [3, -4]
    assert mesh.face_attributes["rgba"].dtype == np.uint8


def test_arrays_are_views_that_nobody_can_write():
    mesh = rich()
    for array in every_array(mesh):
        assert not array.flags.writeable and not array.flags.owndata
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True
    # The same memory each time, not a copy.
    assert mesh.points.ctypes.data == mesh.points.ctypes.data
    assert mesh.faces.ctypes.data == mesh.face_corners.ctypes.data


def test_arrays_keep_their_memory_alive():
    points = rich().points
    gc.collect()
    junk = [np.full((4, 3), 9.0) for _ in range(1000)]
    assert np.array_equal(points, SQUARE) and len(junk) == 1000


def test_meshes_are_frozen():
    mesh = rich()
    for name in ("points", "source", "anything"):
        with pytest.raises(AttributeError):
            setattr(mesh, name, None)
    with pytest.raises(TypeError):
        mesh.vertex_attributes["t"] = None  # type: ignore[index]


def test_polygons_of_any_size():
    mesh = cr.Mesh(SQUARE, [[0, 1, 2, 3], [0, 2, 1]])
    assert [face.tolist() for face in mesh.faces] == [[0, 1, 2, 3], [0, 2, 1]]
    assert mesh.face_offsets.tolist() == [0, 4, 7]
    quads = cr.Mesh(SQUARE, [[0, 1, 2, 3]])
    assert quads.faces.shape == (1, 4)
    assert quads.triangulated().faces.shape == (2, 3)


@pytest.mark.parametrize(
    ("faces", "error", "text"),
    [
        ([[0, 1, 4]], cr.InputError, "face 0"),
        ([[0, 1, 2], [0, 2, -1]], cr.InputError, "face 1"),
        ([[0, 1, 2], [0, 2, 2**33]], cr.InputError, "face 1"),
        ([[0, 1, 2], [0, 1, 2, 9]], cr.InputError, "face 1"),
        (np.zeros((2, 3)), TypeError, "integers"),
        (np.zeros(3, int), cr.InputError, "shape"),
    ],
)
def test_wrong_faces_are_refused_with_their_place(faces, error, text):
    with pytest.raises(error, match=text):
        cr.Mesh(SQUARE, faces)


def test_wrong_points_and_attributes_are_refused():
    with pytest.raises(cr.InputError, match=r"\(n, 3\)"):
        cr.Mesh(SQUARE[:, :2], [[0, 1, 2]])
    with pytest.raises(cr.InputError, match="vertex 2"):
        cr.Mesh(SQUARE + [[0], [0], [np.nan], [0]], [[0, 1, 2]])
    with pytest.raises(cr.InputError, match="'t'.*4 vertices"):
        cr.Mesh(SQUARE, [[0, 1, 2]], vertex_attributes={"t": [1.0]})
    with pytest.raises(TypeError, match="'t'"):
        cr.Mesh(SQUARE, [[0, 1, 2]], vertex_attributes={"t": list("abcd")})
    with pytest.raises(cr.InputError, match="32 bits"):
        cr.Mesh(SQUARE, [[0, 1, 2]], face_attributes={"id": [2**40]})


def test_an_error_says_where_and_what_to_do():
    with pytest.raises(cr.InputError) as caught:
        cr.quad(cr.Mesh(SQUARE, []))
    assert isinstance(caught.value, (cr.Error, ValueError))
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.where, again.remedy) == (str(caught.value), caught.value.where, caught.value.remedy)


@pytest.mark.parametrize("extension", ["ply", "vtu", "vtp", "vtk"])
def test_files_keep_everything(tmp_path, extension):
    mesh = rich()
    path = tmp_path / f"mesh.{extension}"
    mesh.write(path)
    back = cr.read(path)
    assert np.array_equal(back.points, mesh.points) and np.array_equal(back.faces, mesh.faces)
    assert np.array_equal(back.vertex_attributes["t"], mesh.vertex_attributes["t"])
    assert np.array_equal(back.face_attributes["id"], mesh.face_attributes["id"])
    assert back.source == path.name


def test_files_that_are_not_there_or_unknown(tmp_path):
    with pytest.raises(cr.ReadError) as caught:
        cr.read(tmp_path / "no.ply")
    assert isinstance(caught.value, OSError) and "no.ply" in str(caught.value)
    with pytest.raises(cr.WriteError, match="unknown extension"):
        cr.write(tmp_path / "mesh.xyz", rich())
    with pytest.raises(cr.OptionsError, match=r"cr\.patch"):
        rich().write(tmp_path / "part.step")
    assert list(tmp_path.iterdir()) == []


def test_losses_of_a_format_are_warnings(tmp_path):
    with pytest.warns(cr.CarreauWarning):
        rich().write(tmp_path / "mesh.stl")


def test_topology_and_quality(torus):
    assert (torus.topology()["euler"], torus.topology()["genus"]) == (0, 1)
    assert torus.quality()["area"] > 0
    assert torus.bounds.shape == (2, 3)


def test_pickled_meshes_are_the_same():
    for mesh in (rich(), cr.Mesh(SQUARE, [[0, 1, 2, 3], [0, 2, 1]])):
        back = pickle.loads(pickle.dumps(mesh))
        for a, b in zip(every_array(mesh), every_array(back), strict=True):
            assert np.array_equal(a, b) and a.dtype == b.dtype


def test_samples_have_names():
    assert {"bracket", "torus"} <= set(cr.samples())
    with pytest.raises(cr.OptionsError, match="bracket"):
        cr.sample("braket")
    assert np.array_equal(cr.sample("noisy-torus", 20, seed=1).points, cr.sample("noisy-torus", 20, seed=1).points)
    assert not np.array_equal(cr.sample("noisy-torus", 20, seed=1).points, cr.sample("noisy-torus", 20, seed=2).points)


def test_skeletons(tmp_path, tube):
    assert not tube.points.flags.writeable and tube.segments.tolist() == [[0, 1], [1, 2]]
    tube.write(tmp_path / "tube.cgr")
    back = cr.read(tmp_path / "tube.cgr")
    assert isinstance(back, cr.Skeleton)
    assert np.array_equal(back.points, tube.points) and np.array_equal(back.radii, tube.radii)
    for segments, text in (([[0, 0]], "itself"), ([[0, 3]], "no node 3")):
        with pytest.raises(cr.InputError, match=text):
            cr.Skeleton([[0, 0, 0], [1, 0, 0], [2, 0, 0]], segments)
    with pytest.raises(cr.InputError, match="negative"):
        cr.Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], radii=[1, -1])
    assert np.isnan(cr.Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]]).radii).all()


def test_notebooks_see_a_page(torus):
    html = torus._repr_html_()
    assert html.startswith("<iframe") and "&lt;!doctype html&gt;" in html and html.count("<") == 2
    assert torus.page().startswith("<!doctype html>") and "torus" in torus.page()
    assert torus.picture().startswith(b"\x89PNG")
