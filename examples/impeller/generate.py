"""Writes impeller.step, a half-open impeller of six ruled blades on a hub. Run: python3 generate.py

Every face is one Bezier surface with its four border curves; lengths in mm. The shape is our own: profiles of hub and tip,
and the angle along the blade, are the control points below.
"""

import math
import pathlib

BLADES = 6
# Control points of the profiles from inlet to outlet: radius and height.
HUB = [(13, 34), (15, 18), (24, 7), (42, 4)]
TIP = [(20, 42), (23, 30), (30, 20), (42, 16)]
ANGLE = [0, 14, 30, 44]  # along the blade, degrees
LEAN = 4  # of the tip against the hub, degrees
THICK = (2.6, 1.4)  # at hub and tip
FOOT = 0.3  # share of the height that is left to smaller cutters, for the fillet at the hub
SECTORS = 6
CENTRE = 6  # radius of the bore


class Writer:
    """Entities of a STEP file."""

    def __init__(self):
        self.lines = []

    def add(self, text):
        self.lines.append(f"#{len(self.lines) + 1} = {text};")
        return f"#{len(self.lines)}"

    def point(self, at):
        return self.add("CARTESIAN_POINT('',(" + ",".join(f"{x:.9f}" for x in at) + "))")

    def curve(self, points):
        names = ",".join(self.point(at) for at in points)
        size = len(points)
        return self.add(
            f"B_SPLINE_CURVE_WITH_KNOTS('',{size - 1},({names}),.UNSPECIFIED.,.F.,.F.,({size},{size}),(0.,1.),.UNSPECIFIED.)"
        )

    def face(self, net):
        """Face over a Bezier surface; the cross product of its directions points out of the part."""
        rows = ",".join("(" + ",".join(self.point(at) for at in row) + ")" for row in net)
        (m, n) = (len(net), len(net[0]))
        surface = self.add(
            f"B_SPLINE_SURFACE_WITH_KNOTS('',{m - 1},{n - 1},({rows}),.UNSPECIFIED.,.F.,.F.,.F.,"
            f"({m},{m}),({n},{n}),(0.,1.),(0.,1.),.UNSPECIFIED.)"
        )
        ring = [[row[0] for row in net], list(net[-1]), [row[-1] for row in net][::-1], list(net[0])[::-1]]
        edges = []
        for side in ring:
            ends = [self.add(f"VERTEX_POINT('',{self.point(at)})") for at in (side[0], side[-1])]
            edge = self.add(f"EDGE_CURVE('',{ends[0]},{ends[1]},{self.curve(side)},.T.)")
            edges.append(self.add(f"ORIENTED_EDGE('',*,*,{edge},.T.)"))
        loop = self.add(f"EDGE_LOOP('',({','.join(edges)}))")
        bound = self.add(f"FACE_BOUND('',{loop},.T.)")
        return self.add(f"ADVANCED_FACE('',({bound}),{surface},.T.)")


def around(radius, height, angle):
    return (radius * math.cos(angle), radius * math.sin(angle), height)


def arc(radius, height, start, turn):
    """Control points of a cubic that is a circle to within a millionth of its radius."""
    handle = 4 / 3 * math.tan(turn / 4)
    ends = [around(radius, height, start), around(radius, height, start + turn)]
    first = (ends[0][0] - handle * ends[0][1], ends[0][1] + handle * ends[0][0], height)
    last = (ends[1][0] + handle * ends[1][1], ends[1][1] - handle * ends[1][0], height)
    return [ends[0], first, last, ends[1]]


def border(profile, thick, lean, side, turn):
    """Control points of the border of a blade's side at hub or tip."""
    return [
        around(r, z, turn + math.radians(angle + lean) + side * 0.5 * thick / r)
        for (r, z), angle in zip(profile, ANGLE)
    ]


def mixed(a, b, share):
    return [tuple(x + share * (y - x) for x, y in zip(p, q)) for p, q in zip(a, b)]


def blade(writer, turn):
    """Sides of a blade, then what is below them, then its top."""
    sides = {}
    for side in (1, -1):
        hub = border(HUB, THICK[0], 0, side, turn)
        tip = border(TIP, THICK[1], LEAN, side, turn)
        sides[side] = (hub, mixed(hub, tip, FOOT), tip)

    def ruled(low, high, side):
        net = [[a, b] for a, b in zip(low, high)]
        return writer.face(net[::-1] if side > 0 else net)

    walls = [ruled(sides[side][1], sides[side][2], side) for side in (1, -1)]
    feet = [ruled(sides[side][0], sides[side][1], side) for side in (1, -1)]
    ends = [
        writer.face([[sides[1][0][at], sides[1][2][at]], [sides[-1][0][at], sides[-1][2][at]]][:: -1 if at else 1])
        for at in (0, -1)
    ]
    return walls, [*feet, *ends, ruled(sides[1][2], sides[-1][2], 1)]


def hub(writer):
    faces = []
    bore = [(CENTRE, 34), (HUB[0][0], 34)]
    rim = [HUB[-1], (HUB[-1][0], 0)]
    for sector in range(SECTORS):
        turn = 2 * math.pi / SECTORS
        for profile in (bore, HUB, rim):
            faces.append(writer.face([arc(r, z, sector * turn, turn) for r, z in profile]))
    return faces


def main():
    writer = Writer()
    blades = [blade(writer, 2 * math.pi * k / BLADES) for k in range(BLADES)]
    walls = [wall for pair, _ in blades for wall in pair]
    others = [face for _, rest in blades for face in rest]
    faces = [*walls, *others, *hub(writer)]
    shell = writer.add(f"OPEN_SHELL('',({','.join(faces)}))")
    model = writer.add(f"SHELL_BASED_SURFACE_MODEL('',({shell}))")
    length = writer.add("( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )")
    angle = writer.add("( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) )")
    solid = writer.add("( NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT() )")
    near = writer.add(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-07),{length},'','')")
    context = writer.add(
        "( GEOMETRIC_REPRESENTATION_CONTEXT(3) "
        f"GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({near})) "
        f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid})) REPRESENTATION_CONTEXT('','') )"
    )
    shape = writer.add(f"MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',({model}),{context})")
    product = writer.add("APPLICATION_CONTEXT('automotive design')")
    discipline = writer.add(f"PRODUCT_CONTEXT('',{product},'mechanical')")
    name = writer.add(f"PRODUCT('impeller','impeller','',({discipline}))")
    formation = writer.add(f"PRODUCT_DEFINITION_FORMATION('','',{name})")
    stage = writer.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{product},'design')")
    design = writer.add(f"PRODUCT_DEFINITION('design','',{formation},{stage})")
    defined = writer.add(f"PRODUCT_DEFINITION_SHAPE('','',{design})")
    writer.add(f"SHAPE_DEFINITION_REPRESENTATION({defined},{shape})")
    header = (
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('impeller'),'2;1');\n"
        "FILE_NAME('impeller.step','2000-01-01T00:00:00',(''),(''),'','','');\n"
        "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"
    )
    text = header + "\n".join(writer.lines) + "\nENDSEC;\nEND-ISO-10303-21;\n"
    pathlib.Path(__file__).with_name("impeller.step").write_text(text, encoding="utf-8")


main()
