"""Quads, graded meshes, faces, hexahedra and sound meshes in the document."""

import FreeCAD as App
import Mesh

import carreau_freecad as cf


def same_place(a, b):
    return (a.Base - b.Base).Length < 1e-9 and a.Rotation.isSame(b.Rotation, 1e-9)


def area(quads, points):
    total = 0.0
    for quad in quads:
        a, b, c, d = (points[v] for v in quad)
        total += (b - a).cross(c - a).Length / 2 + (c - a).cross(d - a).Length / 2
    return total


def test_quads_are_shell_elements_at_the_place_of_the_mesh(put):
    mesh = put("cylinder")
    (made,) = cf.quads(mesh, quads=400)
    elements = made.FemMesh
    assert made.TypeId == "Fem::FemMeshObject" and same_place(made.Placement, mesh.Placement)
    assert elements.QuadrangleCount == elements.FaceCount and 300 < elements.FaceCount < 500
    assert elements.TriangleCount == elements.VolumeCount == 0
    nodes = elements.Nodes
    own = mesh.Mesh.copy()
    own.Placement = App.Placement()
    faces = [elements.getElementNodes(f) for f in elements.Faces]
    assert {v for face in faces for v in face} == set(nodes)
    assert abs(area(faces, nodes) - own.Area) < 0.03 * own.Area


def test_quads_as_triangles_are_a_closed_mesh(put):
    mesh = put("cylinder")
    (made,) = cf.quads(mesh, quads=400, triangles=True)
    assert made.TypeId == "Mesh::Feature" and made.Mesh.CountFacets % 2 == 0
    assert made.Mesh.isSolid() and abs(made.Mesh.Volume - mesh.Mesh.Volume) < 0.03 * mesh.Mesh.Volume
    assert same_place(made.Placement, mesh.Placement)


def test_quads_are_mirrored_across_an_axis(put):
    mesh = put("torus")
    (made,) = cf.quads(mesh, quads=400, symmetry="x", adaptive=True)
    back = made.Placement.inverse()
    places = [back.multVec(p) for p in made.FemMesh.Nodes.values()]
    # The middle of the torus is the origin of the mesh.
    mirrored = [App.Vector(-p.x, p.y, p.z) for p in places]
    off = max(min(p.distanceToPoint(q) for q in places) for p in mirrored)
    assert off < 1e-5 * mesh.Mesh.BoundBox.DiagonalLength, off


def test_remesh_meets_the_number_of_triangles(put):
    mesh = put("torus")
    (made,) = cf.remesh(mesh, triangles=1000)
    assert 900 < made.Mesh.CountFacets < 1100 < mesh.Mesh.CountFacets
    assert made.Mesh.isSolid() and same_place(made.Placement, mesh.Placement)


def test_segments_are_a_group_of_meshes_that_cover_the_mesh(put):
    mesh = put("bracket")
    (group,) = cf.segment(mesh)
    kinds = sorted(piece.Label.split("_")[0] for piece in group.Group)
    assert kinds == ["cylinder"] * 5 + ["plane"] * 8
    assert sum(piece.Mesh.CountFacets for piece in group.Group) == mesh.Mesh.CountFacets
    assert abs(sum(piece.Mesh.Area for piece in group.Group) - mesh.Mesh.Area) < 1e-4 * mesh.Mesh.Area
    assert all(same_place(piece.Placement, mesh.Placement) for piece in group.Group)


def test_hexes_are_a_fem_mesh_that_calculix_takes(put, tmp_path):
    mesh = put("open-cylinder")
    (made,) = cf.hexes(mesh, hexes=200)
    elements = made.FemMesh
    assert elements.HexaCount == elements.VolumeCount > 0 and same_place(made.Placement, mesh.Placement)
    groups = {elements.getGroupName(g): set(elements.getGroupElements(g)) for g in elements.Groups}
    assert set(groups) == {"wall", "cap_1", "cap_2"}
    assert set().union(*groups.values()) == set(elements.Faces)

    # What FreeCAD hands to CalculiX: cells around the right way.
    path = tmp_path / "cells.inp"
    elements.writeABAQUS(str(path), 0, False)
    nodes, cells, section = {}, [], ""
    for line in path.read_text().splitlines():
        if line.startswith("*"):
            section = line.upper()
        elif not line.strip():
            continue
        elif section.startswith("*NODE"):
            number, *xyz = line.split(",")
            nodes[int(number)] = App.Vector(*map(float, xyz))
        elif section.startswith("*ELEMENT") and "C3D8" in section:
            cells.append([int(word) for word in line.rstrip(", ").split(",")][1:])
    assert len(cells) == elements.HexaCount
    for cell in cells:
        a, b, _, d, e = (nodes[v] for v in cell[:5])
        assert (b - a).cross(d - a).dot(e - a) > 0


def test_prepare_welds_and_closes(put):
    own = Mesh.createBox(10, 20, 30)
    points, faces = own.Topology
    # Every triangle with corners of its own, one of them missing.
    soup = Mesh.Mesh()
    soup.addFacets([tuple(tuple(points[v]) for v in face) for face in faces[1:]])
    mesh = put(soup)
    (made,) = cf.prepare(mesh, fill_holes=True)
    assert made.Mesh.isSolid() and abs(made.Mesh.Volume - 6000) < 1e-2 and same_place(made.Placement, mesh.Placement)


def test_info_tells_what_there_is(put, document):
    before = len(document.Objects)
    record = cf.info(put(Mesh.createBox(10, 20, 30)))
    assert (
        record["topology"]["closed"]
        and record["topology"]["triangles"] == 12
        and any("closed" in s for s in record["summary"])
    )
    assert len(document.Objects) == before + 1
