"""The preferences of the workbench, in FreeCAD's parameters."""

from __future__ import annotations

from typing import Any

import FreeCAD as App

__all__ = ["GROUP", "common", "parameters", "path"]

GROUP = "User parameter:BaseApp/Preferences/Mod/carreau"


def parameters() -> Any:
    """FreeCAD's group of parameters."""
    return App.ParamGet(GROUP)


def path() -> str:
    """The executable that is wanted; empty: what is found."""
    return str(parameters().GetString("Path", ""))


def common() -> dict[str, Any]:
    """Options of every run."""
    group = parameters()
    threads, deadline = group.GetInt("Threads", 0), group.GetFloat("Deadline", 0.0)
    return {"threads": threads or None, "deadline": deadline or None}
