"""Run by FreeCAD's window at its start: announces the workbench."""

import FreeCADGui as Gui


class CarreauWorkbench(Gui.Workbench):
    """Meshes to CAD models, quads and hexahedra."""

    # FreeCAD runs this file without its name: the paths come from the package.
    from carreau_freecad import resources

    MenuText = "carreau"
    ToolTip = "From meshes to CAD models, graded meshes, quads and hexahedra"
    Icon = resources.icon("carreau")

    def Initialize(self):
        from carreau_freecad import commands, preferences

        names = commands.register()
        preferences.register()
        self.appendToolbar("carreau", names)
        self.appendMenu("carreau", names)

    def ContextMenu(self, recipient):
        from carreau_freecad import commands

        self.appendContextMenu("carreau", commands.names())

    def GetClassName(self):
        return "Gui::PythonWorkbench"


Gui.addWorkbench(CarreauWorkbench())
