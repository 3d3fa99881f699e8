"""CAD models in the document, and what FreeCAD itself does with them."""

import FreeCAD as App
import Mesh
import Part
import pytest

import carreau_freecad as cf

#: What FreeCAD calls the surfaces that carreau names.
SURFACES = {"plane": "Plane", "cylinder": "Cylinder", "cone": "Cone", "sphere": "Sphere", "torus": "Toroid"}


def same_place(a, b):
    return (a.Base - b.Base).Length < 1e-9 and a.Rotation.isSame(b.Rotation, 1e-9)


def check_names(part):
    assert len(part.FaceNames) == len(part.FaceColors) == len(part.Shape.Faces)
    for name, face in zip(part.FaceNames, part.Shape.Faces, strict=True):
        kind = SURFACES.get(name.split("_")[0])
        assert kind is None or type(face.Surface).__name__ == kind, name


def test_a_bracket_becomes_a_solid_that_freecad_fillets_and_cuts_and_stores(put, document, tmp_path):
    mesh = put("bracket", "Bracket")
    (part,) = cf.cad(mesh)
    assert part.TypeId == "Part::Feature" and part.Label == "Bracket CAD"
    shape = part.Shape
    assert shape.ShapeType == "Solid" and shape.isValid() and len(shape.Faces) == 13
    check_names(part)
    # Bores are round: what the chords of the mesh leave out of them is gone from the solid.
    assert abs(shape.Volume - mesh.Mesh.Volume) < 2e-3 * mesh.Mesh.Volume
    assert same_place(part.Placement, mesh.Placement)
    # The points as they are seen, one in a hundred, are on the solid as it is seen.
    for point in mesh.Mesh.Topology[0][::100]:
        assert shape.Shells[0].distToShape(Part.Vertex(point))[0] < 1e-4

    straight = max((e for e in shape.Edges if isinstance(e.Curve, Part.Line)), key=lambda e: e.Length)
    filleted = document.addObject("Part::Fillet", "Fillet")
    filleted.Base = part
    number = 1 + next(n for n, e in enumerate(shape.Edges) if e.isSame(straight))
    filleted.Edges = [(number, 1.0, 1.0)]
    tool = document.addObject("Part::Cylinder", "Tool")
    tool.Radius, tool.Height = 5, 200
    tool.Placement.Base = shape.CenterOfMass - App.Vector(0, 0, 100)
    cut = document.addObject("Part::Cut", "Cut")
    cut.Base, cut.Tool = filleted, tool
    document.recompute()
    assert filleted.Shape.isValid() and 0 < abs(shape.Volume - filleted.Shape.Volume) < 100
    assert cut.Shape.isValid() and cut.Shape.Volume < filleted.Shape.Volume - 10

    names, volume = list(part.FaceNames), shape.Volume
    path = str(tmp_path / "bracket.FCStd")
    document.saveAs(path)
    App.closeDocument(document.Name)
    again = App.openDocument(path)
    try:
        stored = again.getObject("CAD")
        assert stored.Shape.isValid() and abs(stored.Shape.Volume - volume) < 1e-9 * volume
        assert list(stored.FaceNames) == names
        check_names(stored)
    finally:
        App.closeDocument(again.Name)


def test_every_body_is_a_part_with_its_own_faces(put, document):
    box, ball = Mesh.createBox(10, 20, 30), Mesh.createCylinder(5, 12, True, 1, 40)
    ball.translate(40, 0, 0)
    box.addMesh(ball)
    parts = cf.cad(put(box))
    assert sorted(len(part.Shape.Faces) for part in parts) == [3, 6]
    for part in parts:
        assert part.Shape.isValid() and part.Shape.ShapeType == "Solid"
        check_names(part)
    assert len({part.Label for part in parts}) == 2


def test_an_open_surface_is_a_shell(put):
    (part,) = cf.cad(put("open-cylinder"))
    assert part.Shape.ShapeType in ("Shell", "Face") and not part.Shape.Solids and part.Shape.isValid()
    check_names(part)


def test_a_run_is_one_step_for_undo(put, document):
    mesh = put(Mesh.createBox(10, 20, 30))
    before = [feature.Name for feature in document.Objects]
    (part,) = cf.cad(mesh)
    name = part.Name
    document.undo()
    assert [feature.Name for feature in document.Objects] == before
    document.redo()
    assert document.getObject(name).Shape.isValid()


def test_the_result_stays_in_the_container_of_the_mesh(put, document):
    mesh = put(Mesh.createBox(10, 20, 30))
    container = document.addObject("App::Part", "Assembly")
    container.Placement.Base = App.Vector(0, 0, 50)
    container.addObject(mesh)
    (part,) = cf.cad(mesh)
    assert part in container.Group
    assert same_place(part.getGlobalPlacement(), mesh.getGlobalPlacement())


@pytest.mark.parametrize("factor", [1e-3, 1e4])
def test_lengths_are_millimetres_at_any_size(put, factor):
    (part,) = cf.cad(put(Mesh.createBox(1 * factor, 2 * factor, 3 * factor)))
    assert abs(part.Shape.Volume - 6 * factor**3) < 1e-5 * factor**3
