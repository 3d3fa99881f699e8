"""Faces of parts, CAD files, and what goes wrong."""

import sys

import bpy
import numpy as np
import pytest
from test_new_meshes import BOX


def face_values(mesh, name):
    found = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.attributes[name].data.foreach_get("value", found)
    return found


@pytest.mark.parametrize("materials", ["KIND", "FACE", "NONE"])
def test_segment_gives_face_sets_and_materials(put, materials):
    obj = put("bracket")
    obj.scale.x = -1
    bpy.context.view_layer.update()
    own = len(obj.data.materials)
    assert bpy.ops.carreau.segment(materials=materials, mark_sharp=True) == {"FINISHED"}
    mesh = obj.data
    sets, regions, kinds = (face_values(mesh, name) for name in (".sculpt_face_set", "region", "primitive"))
    assert (sets == regions + 1).all() and len(set(regions)) == 13
    # A plane is flat: faces of one region look one way.
    for region in set(regions[kinds == 0]):
        normals = np.array([mesh.polygons[f].normal for f in np.flatnonzero(regions == region)])
        assert np.allclose(normals, normals[0], atol=1e-3)
    assert len(mesh.materials) == {"KIND": 2, "FACE": 13, "NONE": own}[materials]
    sharp = {tuple(sorted(e.vertices)) for e in mesh.edges if e.use_edge_sharp}
    sides = {}
    for face in mesh.polygons:
        for key in face.edge_keys:
            sides.setdefault(tuple(sorted(key)), set()).add(regions[face.index])
    assert sharp == {key for key, of in sides.items() if len(of) > 1}


def test_polygons_get_one_face_each(put):
    put(BOX)
    assert bpy.ops.carreau.segment() == {"FINISHED"}
    assert sorted(face_values(bpy.context.active_object.data, "region")) == list(range(6))


@pytest.mark.parametrize("method, extension", [("cad", "step"), ("patch", "igs")])
def test_cad_files_are_written_in_millimetres(put, tmp_path, method, extension):
    obj = put(BOX)
    obj.location.x = 7
    obj.scale = (1, 1, -2)
    bpy.context.view_layer.update()
    path = tmp_path / f"box.{extension}"
    assert bpy.ops.carreau.export("EXEC_DEFAULT", filepath=str(path), method=method) == {"FINISHED"}
    text = path.read_text()
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    if extension == "step":
        assert text.count("ADVANCED_FACE(") == 6 and "'Part'" in text
        points = [
            tuple(map(float, part.split("(")[2].split(")")[0].split(","))) for part in text.split("CARTESIAN_POINT")[1:]
        ]
        # One unit of the scene is a metre; a corner of the box is at 6, -1, -2.
        assert (6000.0, -1000.0, -2000.0) in points


def test_lengths_may_be_taken_as_they_are(put, tmp_path):
    put(BOX)
    path = tmp_path / "box.step"
    assert bpy.ops.carreau.export("EXEC_DEFAULT", filepath=str(path), scene_units=False) == {"FINISHED"}
    assert "(-1.,-1.,-1.)" in path.read_text().replace(" ", "").replace("-1.0", "-1.")


def test_wrong_files_are_named(put, tmp_path):
    put(BOX)
    with pytest.raises(RuntimeError, match=r"no CAD file by its name.*\n.*Remedy: .*\.step"):
        bpy.ops.carreau.export("EXEC_DEFAULT", filepath=str(tmp_path / "box.stl"))
    with pytest.raises(RuntimeError, match="does not exist"):
        bpy.ops.carreau.export("EXEC_DEFAULT", filepath=str(tmp_path / "no" / "box.step"))


def test_failures_have_the_name_the_place_and_a_remedy_and_change_nothing(put):
    put(([(0, 0, 0), (0, 0, 0), (0, 0, 0)], [(0, 1, 2)]), "Point")
    names = sorted(o.name for o in bpy.data.objects)
    with pytest.raises(RuntimeError, match="Point"):
        bpy.ops.carreau.quads()
    assert sorted(o.name for o in bpy.data.objects) == names
    put(([(0, 0, 0)], []), "Empty")
    for operator in (bpy.ops.carreau.quads, bpy.ops.carreau.segment):
        with pytest.raises(RuntimeError, match="Empty has no faces.*\n.*Remedy"):
            operator()


def test_a_fan_of_three_faces_becomes_quads_or_is_refused_with_a_place(put):
    put(([(0, 0, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (-1, -1, 0)], [(0, 1, 2), (0, 1, 3), (0, 1, 4)]), "Fan")
    try:
        bpy.ops.carreau.quads(quads=50)
    except RuntimeError as error:
        assert "Where: " in str(error)
    else:
        assert all(face.loop_total == 4 for face in bpy.context.active_object.data.polygons)


def test_a_wrong_path_is_named(put):
    put(BOX)
    bpy.context.preferences.addons["carreau_blender"].preferences.path = "/nowhere/carreau"
    with pytest.raises(RuntimeError, match=r"/nowhere/carreau is no program.*\n.*preferences"):
        bpy.ops.carreau.quads()


def test_a_deadline_is_kept(put):
    put("bracket")
    bpy.context.preferences.addons["carreau_blender"].preferences.deadline = 1e-3
    with pytest.raises(RuntimeError, match="deadline"):
        bpy.ops.carreau.quads()


def test_operators_want_a_mesh_in_object_mode(put):
    assert not bpy.ops.carreau.quads.poll()
    put(BOX)
    assert bpy.ops.carreau.quads.poll()
    bpy.ops.object.mode_set(mode="EDIT")
    assert not bpy.ops.carreau.quads.poll()


class Event:
    def __init__(self, type, value="NOTHING"):
        self.type, self.value = type, value


class Modal:
    """An operator as the window runs it, without one."""

    def __init__(self, kind, **options):
        self.kind, self.said = kind, []
        self.options = options

    def __getattr__(self, name):
        if name in self.options:
            return self.options[name]
        found = getattr(self.kind, name)
        return found.__get__(self) if callable(found) else found

    def report(self, level, text):
        self.said.append((level, text))


@pytest.mark.parametrize("escape", [True, False])
def test_the_loop_of_the_window_ends_with_a_result_or_at_escape(put, escape, monkeypatch):
    """`modal` with a timer's ticks; what needs a window (the timer itself) is left out."""
    operators = sys.modules["carreau_blender.operators"]
    obj = put("bracket")
    run = Modal(operators.CarreauSegment, regions=0, materials="NONE", mark_sharp=False)
    run._child, source, run._output = run._prepare(bpy.context)
    run._child.start(source, run._output)
    left = []
    run._leave = lambda context: (run._child.close(), left.append(True))
    assert run.modal(bpy.context, Event("MOUSEMOVE")) == {"PASS_THROUGH"}
    if escape:
        assert run.modal(bpy.context, Event("ESC", "PRESS")) == {"RUNNING_MODAL"}
    state = {"PASS_THROUGH"}
    while state == {"PASS_THROUGH"}:
        state = run.modal(bpy.context, Event("TIMER"))
    assert left and state == ({"CANCELLED"} if escape else {"FINISHED"})
    assert ("region" in obj.data.attributes) is not escape
    assert run.said and not any("ERROR" in level for level, _ in run.said)


class Layout:
    """What a panel draws on, without a window."""

    def __init__(self):
        self.icons, self.buttons, self.shown = set(), [], []

    def column(self, **_):
        return self

    def separator(self):
        pass

    def label(self, text, icon):
        self.icons.add(icon)

    def prop(self, owner, name):
        assert name in owner.bl_rna.properties
        self.shown.append(name)

    def operator(self, name, icon="NONE", **_):
        self.icons.add(icon)
        self.buttons.append((name, type("Button", (), {})()))
        return self.buttons[-1][1]


def test_the_panel_hands_its_settings_to_the_operators(put):
    panel = sys.modules["carreau_blender.panel"]
    put(BOX)
    bpy.context.scene.carreau.quads = 77
    layout = Layout()
    shown = type("Shown", (), {"layout": layout, "_block": panel.CarreauPanel._block})()
    panel.CarreauPanel.draw(shown, bpy.context)
    known = bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items.keys()
    assert layout.icons <= set(known)
    buttons = dict(layout.buttons)
    assert set(buttons) == {"carreau.quads", "carreau.remesh", "carreau.segment", "carreau.export"}
    assert buttons["carreau.quads"].quads == 77
    for name, button in buttons.items():
        group, operator = name.split(".")
        properties = getattr(getattr(bpy.ops, group), operator).get_rna_type().properties
        assert set(vars(button)) <= set(properties.keys())
