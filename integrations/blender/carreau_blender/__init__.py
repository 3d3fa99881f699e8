"""carreau in Blender: operators and a panel for the active object. See README.md."""

from __future__ import annotations

import bpy

from . import export, operators, panel, preferences

_CLASSES = (*preferences.CLASSES, *operators.CLASSES, *export.CLASSES, *panel.CLASSES)


def register() -> None:
    """Called by Blender."""
    for kind in _CLASSES:
        bpy.utils.register_class(kind)
    panel.register()


def unregister() -> None:
    """Called by Blender."""
    panel.unregister()
    for kind in reversed(_CLASSES):
        bpy.utils.unregister_class(kind)
