"""The task panel of an operation: its options, the progress of its run, and Cancel. FreeCAD goes on meanwhile."""

from __future__ import annotations

from typing import Any

import FreeCAD as App
import FreeCADGui as Gui
from PySide import QtCore, QtGui

from .child import POLL, Cancelled, Failure
from .operations import OPERATIONS, Job, Option
from .resources import icon, translated

__all__ = ["Panel", "complain"]


class Panel:
    """What FreeCAD's task view shows; `form` is its widget."""

    def __init__(self, name: str, mesh: Any) -> None:
        self._name, self._mesh, self._operation = name, mesh, OPERATIONS[name]
        self._job: Job | None = None
        self._timer = QtCore.QTimer()
        self._timer.setInterval(round(POLL * 1000))
        self._timer.timeout.connect(self._look)
        self._build()

    def _build(self) -> None:
        self.form = QtGui.QWidget()
        self.form.setWindowTitle(f"carreau: {translated(self._operation.title)}")
        self.form.setWindowIcon(QtGui.QIcon(icon(self._name)))
        column = QtGui.QVBoxLayout(self.form)
        head = QtGui.QLabel(f"{self._mesh.Label}: {translated(self._operation.tip)}")
        head.setWordWrap(True)
        column.addWidget(head)
        self._rows = QtGui.QWidget()
        rows = QtGui.QFormLayout(self._rows)
        self._fields = {option.name: _Field(option) for option in self._operation.options}
        for option in self._operation.options:
            rows.addRow(translated(option.label), self._fields[option.name].widget)
        column.addWidget(self._rows)
        self._bar = QtGui.QProgressBar()
        self._bar.setVisible(False)
        column.addWidget(self._bar)
        self._text = QtGui.QLabel()
        self._text.setWordWrap(True)
        self._text.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
        column.addWidget(self._text)
        # Wherever the keyboard is in the window: the 3D view would take the key otherwise.
        self._escape = QtGui.QShortcut(QtGui.QKeySequence(QtCore.Qt.Key_Escape), Gui.getMainWindow())
        self._escape.setContext(QtCore.Qt.ApplicationShortcut)
        self._escape.activated.connect(self.reject)

    # The names from here on are FreeCAD's.

    def getStandardButtons(self) -> int:
        return int(QtGui.QDialogButtonBox.Ok | QtGui.QDialogButtonBox.Cancel)

    def accept(self) -> bool:
        """OK: starts the run; the panel stays until its end."""
        if self._job is None:
            self._start()
        return False

    def reject(self) -> bool:
        """Cancel: ends the run, or where there is none closes the panel."""
        if self._job is None:
            self._leave()
        else:
            self._job.child.cancel()
            self._text.setText(translated("Ending …"))
        return True

    def _start(self) -> None:
        options = {name: field.value() for name, field in self._fields.items()}
        try:
            self._job = Job(self._name, self._mesh, options)
            self._job.child.start(*self._job.files)
        except (Failure, OSError) as error:
            self._end(error)
            return
        self._rows.setEnabled(False)
        self._bar.setVisible(True)
        self._bar.setRange(0, 0)
        self._timer.start()

    def _look(self) -> None:
        assert self._job is not None
        child = self._job.child
        if not child.done():
            # Many stages do not know how long they take: the bar moves to and fro.
            known = child.share > 0
            self._bar.setRange(0, 100 if known else 0)
            self._bar.setValue(round(100 * child.share) if known else 0)
            self._text.setText(child.stage)
            return
        self._timer.stop()
        try:
            made = self._job.finish()
        except Exception as error:
            self._end(error)
        else:
            self._end(None)
            self._show(made)

    def _end(self, error: Exception | None) -> None:
        """Takes the run away: with an error the panel stays, for other options."""
        if self._job is not None:
            self._job.child.close()
            self._job = None
        self._rows.setEnabled(True)
        self._bar.setVisible(False)
        self._text.clear()
        if isinstance(error, Cancelled):
            App.Console.PrintMessage("carreau: cancelled\n")
        elif error is not None:
            self._text.setText("\n".join(complain(error)))

    def _show(self, made: Any) -> None:
        if isinstance(made, dict):
            self._text.setText("\n".join([*made["summary"], *made["warnings"]]))
            return
        self._leave()
        Gui.Selection.clearSelection()
        for thing in made:
            Gui.Selection.addSelection(thing)

    def _leave(self) -> None:
        self._timer.stop()
        self._escape.setEnabled(False)
        self._escape.deleteLater()
        Gui.Control.closeDialog()


class _Field:
    """The widget of an option."""

    def __init__(self, option: Option) -> None:
        self._option = option
        if option.choices:
            self.widget = QtGui.QComboBox()
            self.widget.addItems(option.choices)
            self.widget.setCurrentText(option.default)
        elif isinstance(option.default, bool):
            self.widget = QtGui.QCheckBox()
            self.widget.setChecked(option.default)
        elif isinstance(option.default, int):
            self.widget = QtGui.QSpinBox()
            self.widget.setRange(0, 10_000_000)
            self.widget.setValue(option.default)
        else:
            self.widget = QtGui.QLineEdit(option.default)
        self.widget.setToolTip(translated(option.tip))

    def value(self) -> Any:
        """What the user wants; None: what carreau does by itself."""
        if self._option.choices:
            return self.widget.currentText()
        if isinstance(self._option.default, bool):
            return self.widget.isChecked()
        if isinstance(self._option.default, int):
            return self.widget.value() or None
        return self.widget.text().strip() or None


def complain(error: Exception) -> list[str]:
    """Tells of a failure in the report view and in a message; the lines of both."""
    lines = error.lines() if isinstance(error, Failure) else [f"{type(error).__name__}: {error}"]
    App.Console.PrintError("carreau: " + "\n  ".join(lines) + "\n")
    box = QtGui.QMessageBox(QtGui.QMessageBox.Warning, "carreau", lines[0], QtGui.QMessageBox.Ok, Gui.getMainWindow())
    box.setInformativeText("\n".join(lines[1:]))
    # Without a loop of its own: what goes on in FreeCAD goes on.
    box.setAttribute(QtCore.Qt.WA_DeleteOnClose)
    box.setModal(True)
    box.show()
    return lines
