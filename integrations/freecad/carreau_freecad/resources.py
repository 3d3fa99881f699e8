"""Where the files of the workbench are, and the words of the user's language."""

from __future__ import annotations

from pathlib import Path

import FreeCAD as App

__all__ = ["TRANSLATIONS", "icon", "translated"]

_FOLDER = Path(__file__).resolve().parent.parent / "resources"
TRANSLATIONS = str(_FOLDER / "translations")


def icon(name: str) -> str:
    """The file of an icon."""
    return str(_FOLDER / "icons" / f"{name}.svg")


def translated(text: str) -> str:
    """A text in the user's language."""
    return App.Qt.translate("carreau", text) if hasattr(App, "Qt") else text
