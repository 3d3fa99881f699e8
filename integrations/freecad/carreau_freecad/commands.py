"""The commands of the workbench: each opens the task panel of an operation."""

from __future__ import annotations

from typing import Any

import FreeCAD as App
import FreeCADGui as Gui

from .operations import OPERATIONS
from .resources import TRANSLATIONS, icon, translated

__all__ = ["names", "register", "selected"]


def names() -> list[str]:
    """The names of the commands, in the order of the toolbar."""
    return [f"carreau_{name}" for name in OPERATIONS]


def register() -> list[str]:
    """Announces the commands and their translations."""
    Gui.addLanguagePath(TRANSLATIONS)
    Gui.updateLocale()
    for name in OPERATIONS:
        Gui.addCommand(f"carreau_{name}", _Command(name))
    return names()


def selected() -> list[Any]:
    """The meshes that are selected."""
    return [feature for feature in Gui.Selection.getSelection() if feature.isDerivedFrom("Mesh::Feature")]


class _Command:
    def __init__(self, name: str) -> None:
        self._name, self._operation = name, OPERATIONS[name]

    def GetResources(self) -> dict[str, str]:
        title, tip = translated(self._operation.title), translated(self._operation.tip)
        return {
            "MenuText": title,
            "ToolTip": f"{tip}. {translated('Select one mesh first.')}",
            "Pixmap": icon(self._name),
        }

    def IsActive(self) -> bool:
        return App.ActiveDocument is not None and len(selected()) == 1

    def Activated(self) -> None:
        from .panel import Panel

        if not Gui.Control.activeDialog():
            Gui.Control.showDialog(Panel(self._name, selected()[0]))
