"""Workbench of the add-on; called by FreeCAD at start with a window."""

import FreeCADGui


class TrunnionWorkbench(FreeCADGui.Workbench):
    """Five-axis finishing, checks and posts for jobs of the CAM workbench."""

    def __init__(self):
        import os

        import trunnion_cam
        from trunnion_cam.translate import translated

        # FreeCAD runs this file without a name of its own.
        folder = os.path.dirname(os.path.dirname(trunnion_cam.__file__))
        FreeCADGui.addLanguagePath(os.path.join(folder, "translations"))
        FreeCADGui.updateLocale()
        self.__class__.Icon = os.path.join(folder, "resources", "icons", "trunnion.svg")
        self.__class__.MenuText = "trunnion"
        self.__class__.ToolTip = translated("Five-axis finishing, checks with guaranteed bounds, and posts")

    def Initialize(self):
        """Adds the commands to menu and toolbar."""
        from trunnion_cam.gui import commands

        names = commands.register()
        self.appendToolbar("trunnion", names)
        self.appendMenu("trunnion", names)

    def GetClassName(self):
        """A workbench in Python."""
        return "Gui::PythonWorkbench"


FreeCADGui.addWorkbench(TrunnionWorkbench())
