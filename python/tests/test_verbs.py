"""Verbs: options, results, records."""

from __future__ import annotations

import functools
import inspect
import json
import re
import subprocess
import sys

import numpy as np
import pytest

import carreau as cr

VERBS = [
    "segment",
    "cad",
    "enrich",
    "simplify",
    "patch",
    "field",
    "motorcycle",
    "quad",
    "skeleton",
    "hex",
    "repair",
    "curvature",
    "info",
    "compare",
]
#: Options that only Python has.
OWN = {"progress"}


@functools.cache
def long_options(verb: str) -> set[str]:
    """The options that a verb's help names, as keyword arguments."""
    text = subprocess.run(
        [sys.executable, "-m", "carreau", verb, "--help"], capture_output=True, text=True, check=True
    ).stdout
    names = {name.replace("-", "_") for name in re.findall(r"^ +(?:-\w, )?--([a-z-]+)", text, re.M)}
    assert len(names) > 5, text
    return names - {"help", "version"}


@pytest.mark.parametrize("verb", VERBS)
def test_functions_have_the_options_of_the_command_line(verb):
    function = getattr(cr, verb)
    own = {p.name for p in inspect.signature(function).parameters.values() if p.kind is p.KEYWORD_ONLY}
    wanted = long_options(verb)
    documented = own | set(cr.Common.__annotations__)
    if verb not in ("info", "repair"):
        documented |= set(cr.Preparation.__annotations__)
    assert wanted <= documented, f"not in the signature: {wanted - documented}"
    assert own <= wanted, f"not on the command line: {own - wanted}"
    for name in own:
        assert re.search(rf"^    (?:\w+, )*{name}(?:, \w+)* : ", function.__doc__, re.M), f"{name} is not documented"
    for name in set(cr.Common.__annotations__) - OWN:
        assert name in long_options("segment") and re.search(rf"^    {name} : ", cr.Common.__doc__, re.M)
    for name in set(cr.Preparation.__annotations__) - set(cr.Common.__annotations__):
        assert name in long_options("segment") and re.search(rf"^    {name} : ", cr.Preparation.__doc__, re.M)


def test_unknown_names_come_with_the_nearest_ones(bracket):
    with pytest.raises(TypeError, match="did you mean 'clusters'"):
        cr.segment(bracket, cluster=3)
    with pytest.raises(TypeError, match="unexpected keyword argument 'zzz'$"):
        cr.quad(bracket, zzz=3)


def test_wrong_values_are_told_as_keywords(bracket):
    with pytest.raises(cr.OptionsError, match=r"'wild' for 'rectify'.*paper, cut, none"):
        cr.segment(bracket, rectify="wild")
    with pytest.raises(cr.OptionsError, match="merge_threshold"):
        cr.segment(bracket, regions=3, merge_threshold=2)
    with pytest.raises(cr.OptionsError, match="length"):
        cr.quad(bracket, edge_length="1 mm")
    with pytest.raises(TypeError, match="deviation"):
        cr.simplify(bracket, deviation=[1, 2])
    with pytest.raises(ValueError):
        cr.quad(bracket, quads=12.5)


def test_inputs_of_every_kind(tmp_path, bracket):
    path = tmp_path / "part.ply"
    bracket.write(path)
    points, faces = np.array(bracket.points), np.array(bracket.faces, np.int64)
    results = [cr.patch(shape) for shape in (bracket, path, str(path), (points, faces), (points, faces.tolist()))]
    for result in results[1:]:
        assert np.array_equal(result.mesh.face_corners, results[0].mesh.face_corners)
    with pytest.raises(TypeError, match="dict"):
        cr.patch({})
    with pytest.raises(cr.ReadError, match="gone.ply"):
        cr.patch(tmp_path / "gone.ply")


def test_numbers_words_and_shares_are_understood(bracket):
    options = cr.quad(bracket, edge_length=np.float64(4.5), feature_angle=np.int64(40), quiet=True).options
    assert float(options["edge_length"]) == 4.5 and options["feature_angle"] == 40
    assert cr.quad(bracket, edge_length="4%", quiet=True).options["edge_length"] == "4%"
    assert cr.segment(bracket, surfaces=False).options["surfaces"] is False
    assert cr.segment(bracket, surfaces=True).options["surfaces"] is True
    assert (
        cr.simplify(bracket, gradation="off", geometric=True, triangles=500, ignore_tags=False).options["gradation"]
        is None
    )


def test_results_are_frozen(bracket):
    result = cr.segment(bracket)
    with pytest.raises(AttributeError):
        result.mesh = None
    with pytest.raises(TypeError):
        result.record["regions"] = None
    with pytest.raises(TypeError):
        result.regions[0]["area"] = None
    assert not result.labels.flags.writeable


def test_records_replay_their_runs(tmp_path, bracket):
    first = cr.simplify(bracket, deviation=20, feature_angle=50)
    for options in (first, first.record, first.options, json.loads(first.to_json())):
        again = cr.simplify(bracket, options=options)
        assert np.array_equal(again.mesh.points, first.mesh.points)
        assert again.options == first.options
    path = tmp_path / "record.json"
    path.write_text(first.to_json())
    assert cr.simplify(bracket, options=path, deviation=25).options["deviation"] == 25
    with pytest.raises(cr.OptionsError, match="simplify"):
        cr.quad(bracket, options=first)


def test_the_command_line_makes_the_same(tmp_path, bracket):
    path, record, out = tmp_path / "part.ply", tmp_path / "record.json", tmp_path / "quads.ply"
    bracket.write(path)
    words = ["quad", str(path), "--quads", "500", "--json", str(record), "-o", str(out), "-q"]
    subprocess.run([sys.executable, "-m", "carreau", *words], check=True)
    result = cr.quad(bracket, quads=500, quiet=True)
    told = json.loads(record.read_text())
    assert np.array_equal(cr.read(out).points, result.mesh.points)
    assert told["quality"] == json.loads(result.to_json())["quality"]
    assert told["options"] == json.loads(result.to_json())["options"]


def test_files_are_written_beside_the_result(tmp_path, bracket):
    names = {"output": "part.step", "json": "part.json", "picture": "part.png", "layout": "layout.json"}
    names["report"] = "part.html"
    files = {option: tmp_path / name for option, name in names.items()}
    result = cr.patch(bracket, **files)
    assert {path.name for path in tmp_path.iterdir()} == set(names.values())
    assert files["output"].read_text().startswith("ISO-10303-21;")
    assert json.loads(files["json"].read_text())["patches"] == len(result.patches)
    assert json.loads(files["layout"].read_text()) == result.layout()
    assert files["picture"].read_bytes() == result.picture()


def test_segment(bracket):
    result = cr.segment(bracket)
    assert len(result.labels) == bracket.n_faces and len(result.regions) == result.labels.max() + 1
    truth = bracket.face_attributes["truth"]
    assert (
        len({*zip(result.labels.tolist(), truth.tolist(), strict=True)})
        == len(result.regions)
        == len(set(truth.tolist()))
    )
    again = cr.segment(bracket, labels=truth, rectify="none")
    assert len(again.regions) == len(set(truth.tolist()))
    assert all(boundary["vertices"] for boundary in result.boundaries)


def test_enrich_and_simplify(torus):
    fine = cr.enrich(torus, deviation=3)
    coarse = cr.simplify(torus, triangles=1500)
    assert fine.mesh.n_faces > torus.n_faces > coarse.mesh.n_faces
    assert abs(coarse.mesh.n_faces - 1500) <= 15
    for mesh in (fine.mesh, coarse.mesh):
        assert mesh.topology()["euler"] == 0 and (mesh.vertex_attributes["size"] > 0).all()
    sizes = np.full(torus.n_points, 0.2 * np.linalg.norm(np.ptp(torus.bounds, axis=0)) / 10)
    bounded = cr.simplify(torus, sizes=sizes, deviation=20)
    assert bounded.mesh.n_faces > cr.simplify(torus, deviation=20).mesh.n_faces


def test_patch(torus):
    result = cr.patch(torus)
    cells = sum(patch.triangles[..., 0].size for patch in result.patches)
    used = [t for patch in result.patches for t in patch.triangles.ravel().tolist()] + result.leftover.tolist()
    assert sorted(used) == list(range(torus.n_faces))
    assert cells + len(result.leftover) == result.mesh.n_faces
    faces = np.asarray(torus.faces)
    for patch in result.patches:
        corners = np.stack(
            [patch.vertices[:-1, :-1], patch.vertices[1:, 1:], patch.vertices[:-1, 1:], patch.vertices[1:, :-1]]
        )
        for r, c in np.ndindex(patch.triangles.shape[:2]):
            assert set(faces[patch.triangles[r, c]].ravel().tolist()) == set(corners[:, r, c].tolist())
        assert not patch.vertices.flags.writeable


def test_patches_stay_off_given_edges(torus):
    edges = np.array(torus.faces[:40, :2])
    given = {frozenset(edge) for edge in edges.tolist()}
    for patch in cr.patch(torus, features=edges).patches:
        grid = patch.vertices
        inner = [*zip(grid[1:-1, :-1].ravel(), grid[1:-1, 1:].ravel(), strict=True)]
        inner += [*zip(grid[:-1, 1:-1].ravel(), grid[1:, 1:-1].ravel(), strict=True)]
        assert not given & {frozenset((int(a), int(b))) for a, b in inner}


def test_field(bracket):
    result = cr.field(bracket, quiet=True)
    m = result.mesh.n_faces
    assert result.u.shape == result.v.shape == (m, 3) and len(result.source) == m
    assert np.allclose(np.linalg.norm(result.u, axis=1), 1) and np.allclose(np.linalg.norm(result.v, axis=1), 1)
    points = result.mesh.points[result.mesh.faces]
    normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert np.abs(np.einsum("ij,ij->i", result.u, normals)).max() < 1e-6
    pairs, turns = result.matchings
    assert len(pairs) == len(turns) and pairs.max() < m and turns.max() < 4
    layout = result.layout()
    assert len(layout["edges"]) == len(pairs)
    vertices, quads = result.singularities
    assert [(s["vertex"], s["quads"]) for s in layout["singularities"]] == [*zip(vertices, quads, strict=True)]
    assert cr.field(bracket, pin="none", orthogonal=True, quiet=True).quality["lean_max_deg"] < 1e-6


def test_motorcycle(bracket):
    result = cr.motorcycle(bracket, quads=800, quiet=True)
    layout, mesh = result.layout(), result.mesh
    assert mesh.topology()["euler"] == bracket.topology()["euler"]
    assert result.labels.tolist() == layout["patch"] and len(result.labels) == mesh.n_faces
    assert result.corners.tolist() == [p["corners"] for p in layout["patches"]]
    assert sum(p["area"] for p in layout["patches"]) == pytest.approx(bracket.quality()["area"], rel=0.01)
    # Tracks are tagged edges, and all edges with their tags.
    tagged = {frozenset(e) for e, tag in zip(mesh.edges.tolist(), mesh.edge_tags.tolist(), strict=True) if tag > 1}
    along = [frozenset(e) for track in result.tracks for e in np.stack([track[:-1], track[1:]], 1).tolist()]
    assert len(along) == len(tagged) and set(along) == tagged
    for track, ends in zip(result.tracks, result.ends, strict=True):
        assert result.nodes[ends].tolist() == track[[0, -1]].tolist() and not track.flags.writeable
    vertices, quads = result.singularities
    starts = [(s["vertex"], s["quads"]) for s in layout["starts"] if s["inner"]]
    assert starts == [*zip(vertices.tolist(), quads.tolist(), strict=True)]
    # Patches meet only along tracks and features.
    marked = tagged | {frozenset(e) for e in layout["features"]}
    owner: dict[frozenset[int], int] = {}
    for face, patch in zip(mesh.faces.tolist(), result.labels.tolist(), strict=True):
        for edge in map(frozenset, zip(face, face[1:] + face[:1], strict=True)):
            assert edge in marked or owner.setdefault(edge, patch) == patch
    assert result.picture() != cr.field(bracket, quiet=True).picture()
    with pytest.raises(cr.OptionsError, match="quads"):
        cr.motorcycle(bracket, quads=0)


def test_quad(bracket):
    result = cr.quad(bracket, quads=800, quiet=True)
    assert result.quads.shape == (result.record["quads"], 4)
    assert result.mesh.topology()["euler"] == bracket.topology()["euler"]
    assert result.quality["feature_recall"] > 0.99 and sum(r["quads"] for r in result.rungs) == len(result.quads)


def test_skeleton_and_hex(torus):
    found = cr.skeleton(torus)
    assert found.record["cycles"] == 1 and (found.radii > 0).all()
    assert len(found.points) == len(found.segments) == found.record["nodes"]
    result = cr.hex(torus, skeleton=found.skeleton, quiet=True)
    assert result.certified and result.hexes.shape[1] == 8 and len(result.tags) == len(result.quads)
    assert set(result.tags.tolist()) == {1}
    assert result.quality["scaled_jacobian_min"] > 0 and result.quality["inverted"] == 0
    boundary = result.mesh.boundary()
    assert boundary.n_faces == len(result.quads) and boundary.topology()["closed"]


def test_hex_of_a_skeleton_within_a_surface(tube):
    result = cr.hex(tube, hexes=300, padding="none", quiet=True)
    assert result.certified and result.hexes.max() < len(result.points)
    assert set(result.tags.tolist()) == {1, 2, 3}
    surface = cr.sample("cylinder", 20)
    with pytest.raises(cr.OptionsError, match="skeleton"):
        cr.hex(tube, skeleton=tube)
    assert isinstance(cr.hex(surface, quiet=True), cr.HexResult)


def test_info_compare_repair_curvature(bracket, torus):
    assert cr.info(torus).topology["genus"] == 1
    moved = cr.Mesh(torus.points + [0, 0, 0.25], torus.faces)
    assert 0 < cr.compare(torus, moved).distance["max"] <= 0.25 + 1e-9
    soup = cr.Mesh(torus.points[torus.faces].reshape(-1, 3), np.arange(3 * torus.n_faces).reshape(-1, 3))
    mended = cr.repair(soup, quiet=True)
    assert mended.mesh.n_points == torus.n_points and mended.mesh.topology()["genus"] == 1
    holed = cr.Mesh(torus.points, torus.faces[6:])
    filled = cr.repair(holed, fill_holes="all", quiet=True)
    assert filled.mesh.topology()["closed"] and len(filled.record["filled"]) >= 1
    assert not cr.repair(holed, fill_holes=3, quiet=True).mesh.topology()["closed"]
    assert cr.info(torus, walls="1%", quiet=True).record["walls"]["faces"] == 0
    ball = cr.curvature(cr.sample("icosphere", 20))
    assert np.allclose(ball.kmin, 1, atol=0.1) and np.allclose(ball.kmax, 1, atol=0.1)
    assert ball.dmax.shape == (ball.mesh.n_points, 3)


def test_warnings_of_a_run_are_warnings(bracket):
    broken = cr.Mesh(bracket.points, np.vstack([bracket.faces, bracket.faces[:1]]))
    with pytest.warns(cr.CarreauWarning):
        result = cr.quad(broken, quads=500)
    assert result.warnings


def test_notebooks_see_a_page(bracket, tube):
    results = [verb(bracket, quiet=True) for verb in (cr.segment, cr.field, cr.motorcycle, cr.patch, cr.skeleton)]
    for result in [*results, cr.hex(tube, quiet=True), cr.info(bracket)]:
        assert result.page().startswith("<!doctype html>") and result.record["verb"] in result.page()
        assert result._repr_html_().startswith("<iframe")
    assert cr.info(bracket).picture() is None
