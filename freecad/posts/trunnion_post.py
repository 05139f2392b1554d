"""Post processor of FreeCAD that calls trunnion; its argument is the dialect, such as --dialect=heidenhain."""

from trunnion_cam import compat
from trunnion_cam.translate import translated

TOOLTIP = translated("Posts with trunnion: ten dialects for five-axis machines")
TOOLTIP_ARGS = translated(
    "--dialect=NAME, which is one of: {names}",
    names="linuxcnc, g93, fanuc, fanuc-vector, haas, siemens, siemens-axes, heidenhain, heidenhain-axes, apt",
)


def export(objects, filename, arguments=""):
    from trunnion_cam import postprocessor

    return postprocessor.export(objects, filename, arguments)


_found = compat.post_processor_class(__file__)
if _found is not None:
    # The name that FreeCAD looks for.
    Trunnion = _found
