"""Export to CAD programs: exact faces, or the mesh's own patches as spline surfaces."""

from __future__ import annotations

import os
import shutil
from typing import Any

import bpy
import numpy as np
from bpy_extras.io_utils import ExportHelper

from . import ply
from .child import Child, Failure
from .operators import Run
from .surface import Source

__all__ = ["CLASSES"]


class CarreauExport(Run, bpy.types.Operator, ExportHelper):
    """Writes the object as a CAD model: a STEP or IGES file"""

    bl_idname, bl_label = "carreau.export", "CAD model"
    bl_options = {"PRESET"}  # noqa: RUF012 -- Blender's way
    filename_ext = ".step"

    filter_glob: bpy.props.StringProperty(default="*.step;*.stp;*.igs;*.iges", options={"HIDDEN"})
    method: bpy.props.EnumProperty(
        name="Faces",
        items=[
            ("cad", "Exact", "The faces that the part has: planes, cylinders, … for parts of machines"),
            ("patch", "Patches", "Quad patches on the vertices of the mesh as spline surfaces, for anything"),
        ],
    )
    scene_units: bpy.props.BoolProperty(
        name="Scene units",
        default=True,
        description="Lengths as the scene shows them; else one unit of Blender is a millimetre",
    )
    apply_modifiers: bpy.props.BoolProperty(
        name="Apply modifiers", default=True, description="The object as it is seen"
    )

    def check(self, _context: Any) -> bool:
        """Called by Blender's file browser: the four extensions are all right as they are."""
        if os.path.splitext(self.filepath)[1].lower() in (".step", ".stp", ".igs", ".iges"):
            return False
        self.filepath = bpy.path.ensure_ext(self.filepath, self.filename_ext)
        return True

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Asks for the file first; `execute` follows."""
        return ExportHelper.invoke(self, context, event)

    def execute(self, context: Any) -> set[str]:
        """In the window beside Blender, else until the end."""
        self.filepath = bpy.path.abspath(self.filepath)
        return Run.execute(self, context) if bpy.app.background else Run.invoke(self, context, None)

    def begin(self, context: Any, child_of: Any) -> tuple[Child, str, str]:
        folder, name = os.path.split(self.filepath)
        extension = os.path.splitext(name)[1].lower()
        if extension not in (".step", ".stp", ".igs", ".iges"):
            raise Failure(f"{name} is no CAD file by its name", remedy="end it with .step or .igs", code=5)
        if not os.path.isdir(folder or "."):
            raise Failure(f"the folder {folder} does not exist", remedy="choose another one", code=5)
        obj = context.active_object
        source = Source.of(obj, context.evaluated_depsgraph_get() if self.apply_modifiers else None)
        if not len(source.triangles):
            raise Failure(f"{obj.name} has no faces", remedy="select a mesh that has some", code=3)
        matrix = np.array(obj.matrix_world, dtype=float)
        scale = context.scene.unit_settings.scale_length * 1000 if self.scene_units else 1.0
        points = (source.points @ matrix[:3, :3].T + matrix[:3, 3]) * scale
        triangles = source.corners[source.triangles]
        if np.linalg.det(matrix[:3, :3]) < 0:  # A mirror turns surfaces inside out.
            triangles = triangles[:, ::-1]
        child = child_of(self.method, {"unit": "mm"})
        # Bodies in the file are named after it.
        given = f"{bpy.path.clean_name(obj.name)}.ply"
        ply.write(child.path(given), points.tolist(), triangles.tolist())
        return child, given, f"result{extension}"

    def end(self, context: Any, record: dict[str, Any], path: str) -> None:
        beside = f"{self.filepath}.part"
        shutil.copyfile(path, beside)
        os.replace(beside, self.filepath)


CLASSES = (CarreauExport,)
