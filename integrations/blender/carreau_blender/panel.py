"""The panel in the sidebar of the 3D view, and the entry in the menu of exports."""

from __future__ import annotations

from typing import Any

import bpy

from .operators import SYMMETRIES, Run

__all__ = ["CLASSES", "register", "unregister"]


class CarreauSettings(bpy.types.PropertyGroup):
    """What the panel hands to the operators; it is stored with the scene."""

    quads: bpy.props.IntProperty(name="Quads", default=3000, min=1, soft_max=100_000, max=100_000_000)
    symmetry: bpy.props.EnumProperty(name="Symmetry", items=SYMMETRIES)
    adaptive: bpy.props.BoolProperty(name="Adaptive", description="Smaller quads where the surface bends")
    triangles: bpy.props.IntProperty(
        name="Triangles", min=0, max=100_000_000, description="0: as many as the angle takes"
    )
    deviation: bpy.props.FloatProperty(name="Angle", default=14.0, min=0.1, max=90.0)
    feature_angle: bpy.props.FloatProperty(
        name="Sharp above",
        min=0.0,
        max=180.0,
        description="Degrees; 0: creases at the size of the result; 180: only what is marked",
    )
    keep_sharp: bpy.props.BoolProperty(name="Edges marked sharp", default=True)
    keep_seams: bpy.props.BoolProperty(name="Seams", default=True)
    keep_materials: bpy.props.BoolProperty(name="Borders of materials", default=True)
    replace: bpy.props.BoolProperty(name="In place")
    apply_modifiers: bpy.props.BoolProperty(name="Apply modifiers", default=True)
    regions: bpy.props.IntProperty(name="Faces", min=0, description="Merged down to this number; 0: from the data")
    materials: bpy.props.EnumProperty(
        name="Materials", items=[("KIND", "By kind", ""), ("FACE", "By face", ""), ("NONE", "Left", "")]
    )


#: What an operator takes from the settings, by the same names.
_OF_NEW_MESHES = ("feature_angle", "keep_sharp", "keep_seams", "keep_materials", "replace", "apply_modifiers")
_TAKEN = {
    "carreau.quads": ("quads", "symmetry", "adaptive", *_OF_NEW_MESHES),
    "carreau.remesh": ("triangles", "deviation", *_OF_NEW_MESHES),
    "carreau.segment": ("regions", "materials"),
}


class CarreauPanel(bpy.types.Panel):
    """Buttons with the few options that matter."""

    bl_idname, bl_label = "VIEW3D_PT_carreau", "carreau"
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "carreau"

    def draw(self, context: Any) -> None:
        settings, column = context.scene.carreau, self.layout.column()
        if Run.current is not None:
            column.label(text=f"{Run.current.bl_label} … Esc: cancel", icon="SORTTIME")
        self._block(column, "carreau.quads", "MESH_GRID", settings, ("quads", "symmetry", "adaptive"))
        self._block(
            column,
            "carreau.remesh",
            "MOD_REMESH",
            settings,
            ("triangles", *(() if settings.triangles else ("deviation",))),
        )
        self._block(column, "carreau.segment", "FACE_MAPS", settings, ("regions", "materials"))
        column.separator()
        column.operator_context = "INVOKE_DEFAULT"
        column.operator("carreau.export", text="Export CAD model …", icon="EXPORT")
        box = self.layout.column(heading="Kept", align=True)
        for name in ("keep_sharp", "keep_seams", "keep_materials"):
            box.prop(settings, name)
        box.prop(settings, "feature_angle")
        rest = self.layout.column(heading="Result", align=True)
        for name in ("replace", "apply_modifiers"):
            rest.prop(settings, name)

    def _block(self, column: Any, name: str, icon: str, settings: Any, shown: tuple[str, ...]) -> None:
        column.separator()
        for option in shown:
            column.prop(settings, option)
        button = column.operator(name, icon=icon)
        for option in _TAKEN[name]:
            setattr(button, option, getattr(settings, option))


def _menu(self: Any, _context: Any) -> None:
    self.layout.operator("carreau.export", text="CAD model by carreau (.step, .igs)")


def register() -> None:
    """The settings of scenes, the entry in the menu."""
    bpy.types.Scene.carreau = bpy.props.PointerProperty(type=CarreauSettings)
    bpy.types.TOPBAR_MT_file_export.append(_menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_export.remove(_menu)
    del bpy.types.Scene.carreau


CLASSES = (CarreauSettings, CarreauPanel)
