"""Makes quads of files in Blender, with materials and texture coordinates, and ends a run; one line of JSON a file.

    CARREAU=… CARREAU_ADDON=… python scans.py FILE…

`python` has `bpy`. The last line is about Esc: the seconds from the key to the end of the run, in the window's loop.
"""

import json
import os
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bpy
import conftest
import numpy as np
from test_segment_and_export import Event, Modal

IMPORTERS = {".obj": "obj_import", ".stl": "stl_import", ".ply": "ply_import"}


def load(path):
    """The object of a file, with two materials and texture coordinates by Blender's own projection."""
    getattr(bpy.ops.wm, IMPORTERS[os.path.splitext(path)[1].lower()])(filepath=path)
    obj = bpy.context.selected_objects[0]
    bpy.context.view_layer.objects.active = obj
    mesh = obj.data
    mesh.materials.clear()
    for name in ("low", "high"):
        mesh.materials.append(bpy.data.materials.new(name))
    middle = np.mean([corner[2] for corner in obj.bound_box])
    for face in mesh.polygons:
        face.material_index = int(face.center.z > middle)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project()
    bpy.ops.object.mode_set(mode="OBJECT")
    return obj


def quads(path):
    obj = load(path)
    row = {"file": os.path.basename(path), "faces": len(obj.data.polygons)}
    vertices = np.empty(len(obj.data.vertices) * 3, dtype=np.float32)
    obj.data.vertices.foreach_get("co", vertices)
    name = obj.name
    bpy.ops.ed.undo_push(message="before")
    start = time.monotonic()
    try:
        bpy.ops.carreau.quads(quads=3000, replace=True, keep_materials=False, keep_seams=False)
    except RuntimeError as error:
        return {**row, "failure": str(error)}
    row["seconds"] = round(time.monotonic() - start, 1)
    bpy.ops.ed.undo_push(message="quads")
    mesh = bpy.data.objects[name].data
    row["quads"] = len(mesh.polygons)
    row["all_quads"] = all(face.loop_total == 4 for face in mesh.polygons)
    row["materials"] = len({face.material_index for face in mesh.polygons})
    uv = np.empty(len(mesh.loops) * 2, dtype=np.float32)
    if mesh.uv_layers.active is not None:
        mesh.uv_layers.active.uv.foreach_get("vector", uv)
    row["texture"] = bool(mesh.uv_layers.active is not None and np.ptp(uv) > 0.1 and np.isfinite(uv).all())
    bpy.ops.ed.undo()
    again = np.empty_like(vertices)
    bpy.data.objects[name].data.vertices.foreach_get("co", again)
    row["undo_restores"] = again.tobytes() == vertices.tobytes()
    return row


def escape(path):
    load(path)
    operators = sys.modules["carreau_blender.operators"]
    given = {p.identifier: p.default for p in bpy.ops.carreau.quads.get_rna_type().properties if hasattr(p, "default")}
    run = Modal(operators.CarreauQuads, **given)
    run._child, source, run._output = run._prepare(bpy.context)
    run._child.start(source, run._output)
    run._leave = lambda context: run._child.close()
    stages, start = [], time.monotonic()
    while time.monotonic() - start < 5:
        run.modal(bpy.context, Event("TIMER"))
        if run._child.stage and run._child.stage not in stages:
            stages.append(run._child.stage)
        time.sleep(0.05)
    pressed = time.monotonic()
    run.modal(bpy.context, Event("ESC", "PRESS"))
    while run.modal(bpy.context, Event("TIMER")) != {"CANCELLED"}:
        time.sleep(0.05)
    return {"file": os.path.basename(path), "stages": stages, "seconds_to_end": round(time.monotonic() - pressed, 2)}


def main():
    addon = bpy.context.preferences.addons.new()
    addon.module = conftest.NAME
    sys.modules[conftest.NAME].register()
    addon.preferences.path = conftest.CARREAU
    for path in sys.argv[1:]:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=False)
        print(json.dumps(quads(path)), flush=True)
    print(json.dumps(escape(sys.argv[-1])), flush=True)
    # `bpy` waits for ever for classes that a script has registered.
    os._exit(0)


main()
