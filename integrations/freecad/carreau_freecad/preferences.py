"""The page of the workbench in FreeCAD's preferences."""

from __future__ import annotations

import FreeCADGui as Gui
from PySide import QtGui

from .resources import translated
from .settings import parameters

__all__ = ["register"]


def register() -> None:
    """Announces the page."""
    Gui.addPreferencePage(_Page, "carreau")


class _Page:
    """Path, threads and deadline; the names of the methods are FreeCAD's."""

    def __init__(self) -> None:
        self.form = QtGui.QWidget()
        self.form.setWindowTitle("carreau")
        rows = QtGui.QFormLayout(self.form)
        self._path = QtGui.QLineEdit()
        self._path.setPlaceholderText(translated("the Python package, or the program on the PATH"))
        self._threads = QtGui.QSpinBox()
        self._threads.setRange(0, 512)
        self._threads.setSpecialValueText(translated("all processors"))
        self._deadline = QtGui.QDoubleSpinBox()
        self._deadline.setRange(0, 1e6)
        self._deadline.setSpecialValueText(translated("none"))
        rows.addRow(translated("Program"), self._path)
        rows.addRow(translated("Threads"), self._threads)
        rows.addRow(translated("Deadline in seconds"), self._deadline)

    def saveSettings(self) -> None:
        group = parameters()
        group.SetString("Path", self._path.text().strip())
        group.SetInt("Threads", self._threads.value())
        group.SetFloat("Deadline", self._deadline.value())

    def loadSettings(self) -> None:
        group = parameters()
        self._path.setText(group.GetString("Path", ""))
        self._threads.setValue(group.GetInt("Threads", 0))
        self._deadline.setValue(group.GetFloat("Deadline", 0.0))
