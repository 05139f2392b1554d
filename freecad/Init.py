"""Called by FreeCAD at start, with and without a window."""
