"""Post processor of FreeCAD that calls trunnion; its argument is the dialect, such as --dialect=heidenhain."""

TOOLTIP = "Posts with trunnion: ten dialects for five-axis machines"
TOOLTIP_ARGS = "--dialect=NAME: linuxcnc, g93, fanuc, fanuc-vector, haas, siemens, siemens-axes, heidenhain, heidenhain-axes, apt"


def export(objects, filename, arguments=""):
    from trunnion_cam import postprocessor

    return postprocessor.export(objects, filename, arguments)
