"""Run by FreeCAD at its start, with and without a window: the folder is on the path, nothing else is needed."""
