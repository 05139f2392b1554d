"""Five-axis machining with trunnion inside FreeCAD.

Lengths are mm, angles degrees, feeds mm/min, except in properties of FreeCAD, which have their own units.
"""
