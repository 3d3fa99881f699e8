"""The preferences of the add-on."""

from __future__ import annotations

from typing import Any

import bpy

__all__ = ["CLASSES", "common", "path"]


class CarreauPreferences(bpy.types.AddonPreferences):
    """Path, threads and deadline."""

    bl_idname = __package__

    path: bpy.props.StringProperty(
        name="Program",
        subtype="FILE_PATH",
        description="carreau; empty: the Python package, or the program on the PATH",
    )
    threads: bpy.props.IntProperty(
        name="Threads", min=0, max=512, description="0: all processors; results do not depend on it"
    )
    deadline: bpy.props.FloatProperty(
        name="Deadline", min=0.0, description="Seconds after which a run gives up; 0: never"
    )

    def draw(self, _context: Any) -> None:
        for name in ("path", "threads", "deadline"):
            self.layout.prop(self, name)


def _preferences() -> Any:
    addon = bpy.context.preferences.addons.get(__package__)
    return addon.preferences if addon is not None else None


def path() -> str:
    """The executable that is wanted; empty: what is found."""
    found = _preferences()
    return bpy.path.abspath(found.path) if found is not None and found.path else ""


def common() -> dict[str, Any]:
    """Options of every run."""
    found = _preferences()
    if found is None:
        return {}
    return {"threads": found.threads or None, "deadline": found.deadline or None}


CLASSES = (CarreauPreferences,)
