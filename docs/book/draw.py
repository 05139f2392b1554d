#!/usr/bin/env python3
"""Draws the concept pictures of the book as SVG: python3 docs/book/draw.py (standard library only)."""
import math
from pathlib import Path

OUT = Path(__file__).parent / "src" / "images"
DARK, GREY, BLUE, RED, GREEN, SAND = "#222", "#8a9099", "#1f5fa8", "#c0392b", "#1e8449", "#f4d9a8"


class Drawing:
    def __init__(self, width, height, title):
        self.size = (width, height)
        self.parts = [f"<title>{title}</title>", f'<rect width="{width}" height="{height}" fill="#fff"/>']

    def path(self, points, colour=DARK, width=2, fill="none", dash="", close=False, opacity=1):
        d = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + ("z" if close else "")
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<path d="{d}" fill="{fill}" fill-opacity="{opacity}" stroke="{colour}" stroke-width="{width}"{dashes}/>'
        )

    def arrow(self, start, end, colour=DARK, width=2, both=False):
        self.path([start, end], colour, width)
        for tip, tail in [(end, start)] + ([(start, end)] if both else []):
            a = math.atan2(tip[1] - tail[1], tip[0] - tail[0])
            wings = [(tip[0] - 10 * math.cos(a + w), tip[1] - 10 * math.sin(a + w)) for w in (0.4, -0.4)]
            self.path([wings[0], tip, wings[1]], colour, 1, fill=colour, close=True)

    def text(self, x, y, words, colour=DARK, size=15, anchor="start"):
        self.parts.append(f'<text x="{x}" y="{y}" fill="{colour}" font-size="{size}" text-anchor="{anchor}">{words}</text>')

    def dot(self, x, y, colour=DARK, radius=4.5):
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{colour}"/>')

    def save(self, name):
        width, height = self.size
        body = "\n".join(self.parts)
        (OUT / f"{name}.svg").write_text(
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'font-family="Helvetica, Arial, sans-serif">\n{body}\n</svg>\n'
        )


def arc(cx, cy, radius, start, end, steps=60):
    angles = [start + (end - start) * i / steps for i in range(steps + 1)]
    return [(cx + radius * math.cos(a), cy + radius * math.sin(a)) for a in angles]


def cutter_location():
    d = Drawing(760, 430, "Cutter location and cutter contact")
    surface = [(x, 330 + 40 * math.sin((x - 60) / 150)) for x in range(40, 721, 10)]
    d.path(surface + [(720, 410), (40, 410)], GREY, 1, fill="#e4e7ea", close=True)
    d.path(surface, DARK, 2.5)
    # A bull-nose cutter of R 70, r 40, leaning forward by 14 degrees about its tip.
    lean, tip = math.radians(14), (392.0, 346.0)
    def ground(x):
        return 330 + 40 * math.sin((x - 60) / 150)
    def place(rho, z):
        return (tip[0] + rho * math.cos(lean) + z * math.sin(lean), tip[1] + rho * math.sin(lean) - z * math.cos(lean))
    corner = [(70 + 40 * math.sin(a), 40 - 40 * math.cos(a)) for a in [i * math.pi / 60 for i in range(31)]]
    # Lift the tool until it touches the surface at one point: the contact.
    underside = [place(sign * rho, z) for sign in (-1, 1) for rho, z in corner]
    sunk, contact = max((y - ground(x), (x, y)) for x, y in underside)
    tip = (tip[0], tip[1] - sunk)
    contact = (contact[0], contact[1] - sunk)
    right = [place(*p) for p in corner] + [place(110, 240)]
    left = [place(-x, z) for x, z in reversed(corner)]
    d.path([place(-110, 240)] + left + right, "#a67c2d", 2, fill=SAND, close=True, opacity=0.85)
    d.arrow(place(0, 0), place(0, 300), BLUE, 3)
    d.text(place(0, 300)[0] + 10, place(0, 300)[1] + 12, "tool axis (unit vector)", BLUE)
    d.dot(*tip, BLUE)
    d.text(tip[0] - 30, tip[1] + 18, "tip", BLUE)
    d.dot(*contact, RED)
    slope = math.atan((ground(contact[0] + 1) - ground(contact[0] - 1)) / 2)
    d.arrow(contact, (contact[0] + 120 * math.sin(slope), contact[1] - 120 * math.cos(slope)), RED)
    d.text(contact[0] + 14, contact[1] - 100, "surface normal", RED)
    d.text(contact[0] - 40, contact[1] + 40, "cutter contact (CC)", RED)
    d.arrow((90, 120), (190, 120), GREEN, 3)
    d.text(90, 106, "feed", GREEN)
    d.text(60, 420, "cutter location (CL) = tip + tool axis", BLUE)
    d.save("cutter-location")


def strip():
    d = Drawing(760, 330, "Strip width and scallop")
    def surface(x):
        return 250 - 0.00025 * (x - 380) ** 2
    xs = range(30, 731, 5)
    d.path([(x, surface(x)) for x in xs], DARK, 2.5)
    d.path([(x, surface(x) - 26) for x in xs], GREY, 1.5, dash="6 4")
    d.text(640, surface(640) - 34, "tolerance", GREY)
    d.text(640, surface(640) + 24, "surface")
    for centre in (230, 530):
        cut = [(x, surface(x) - 26 * ((x - centre) / 150) ** 2) for x in range(centre - 190, centre + 191, 5)]
        d.path(cut, "#a67c2d", 2.5)
        d.text(centre, surface(centre) - 110, "pass", "#a67c2d", anchor="middle")
        d.arrow((centre, surface(centre) - 100), (centre, surface(centre) - 8), "#a67c2d")
        d.arrow((centre - 150, 300), (centre + 150, 300), BLUE, 2, both=True)
        d.text(centre, 320, "strip width", BLUE, anchor="middle")
    d.dot(380, surface(380) - 26, RED)
    d.arrow((380, 92), (380, surface(380) - 34), RED)
    d.text(250, 82, "scallop: the strips meet at the tolerance", RED)
    d.save("strip")


def deviation():
    d = Drawing(760, 300, "Gouge and excess")
    base = 170
    d.path([(40, base - 50), (720, base - 50), (720, base + 16), (40, base + 16)], "none", 0, fill="#e8f3ec", close=True)
    d.path([(40, base), (720, base)], DARK, 2.5)
    d.path([(40, base - 50), (720, base - 50)], GREEN, 1.5, dash="6 4")
    d.path([(40, base + 16), (720, base + 16)], RED, 1.5, dash="6 4")
    def height(x):
        return base - 26 - 18 * math.sin(x / 23) + 62 * math.exp(-(((x - 330) / 26) ** 2)) - 58 * math.exp(-(((x - 560) / 30) ** 2))
    d.path([(x, height(x)) for x in range(40, 721, 2)], BLUE, 2.5)
    d.text(44, base - 58, "total: largest excess", GREEN)
    d.text(44, base + 34, "gouge: deepest cut", RED)
    d.text(600, base - 6, "nominal surface")
    d.arrow((330, 262), (330, height(330) + 6), RED)
    d.text(330, 280, "gouge (negative)", RED, anchor="middle")
    d.arrow((560, 44), (560, height(560) - 6), "#a67c2d")
    d.text(560, 36, "excess beyond the tolerance", "#a67c2d", anchor="middle")
    d.text(640, base - 70, "finished part", BLUE)
    d.save("deviation")


def branches():
    d = Drawing(760, 360, "Branches of the inverse and the singular cone")
    cx, cy, radius = 210, 230, 150
    d.path(arc(cx, cy, radius, math.pi, 2 * math.pi), GREY, 1.5)
    d.arrow((cx, cy), (cx, cy - 190), RED, 2.5)
    d.text(cx + 10, cy - 182, "singular direction", RED)
    cone = math.radians(14)
    d.path([(cx, cy)] + arc(cx, cy, radius, -math.pi / 2 - cone, -math.pi / 2 + cone), RED, 1, fill=RED, close=True, opacity=0.15)
    a = math.radians(-40)
    d.arrow((cx, cy), (cx + radius * math.cos(a), cy + radius * math.sin(a)), BLUE, 3)
    d.text(cx + 118, cy - 104, "tool axis", BLUE)
    d.path(arc(cx, cy, 70, -math.pi / 2, a), BLUE, 1.5)
    d.text(cx + 26, cy - 78, "tilt", BLUE)
    d.text(cx - 150, cy + 40, "Near the singular direction the rotary axis")
    d.text(cx - 150, cy + 60, "next to the workpiece must turn fast.")
    d.path([(450, 310), (450, 60)], DARK, 1.5)
    d.path([(450, 310), (730, 310)], DARK, 1.5)
    d.text(440, 52, "C", anchor="end")
    d.text(736, 314, "s")
    first = [(450 + x, 230 - 60 * math.tanh((x - 130) / 40)) for x in range(0, 271, 3)]
    second = [(x, y - 90 if x < 580 else y - 90) for x, y in first]
    d.path(first, BLUE, 2.5)
    d.path(second, GREEN, 2.5, dash="7 4")
    d.text(600, 150, "branch 1: (B, C)", BLUE)
    d.text(560, 70, "branch 2: (-B, C + 180)", GREEN)
    d.save("branches")


def feed():
    d = Drawing(760, 330, "Speed profile below its limits")
    d.path([(60, 290), (60, 30)], DARK, 1.5)
    d.path([(60, 290), (730, 290)], DARK, 1.5)
    d.text(52, 28, "v", anchor="end")
    d.text(734, 294, "s")
    def limit(x):
        return 290 - (190 - 110 * math.exp(-(((x - 290) / 60) ** 2)) - 70 * math.exp(-(((x - 560) / 45) ** 2)))
    d.path([(x, limit(x)) for x in range(60, 721, 4)], RED, 2, dash="7 4")
    speed = []
    for x in range(60, 721, 4):
        ramp = min(1.0, (x - 60) / 120, (720 - x) / 120)
        ease = ramp * ramp * (3 - 2 * ramp)
        worst = max(limit(min(720, max(60, x + w))) for w in range(-60, 61, 6))
        speed.append((x, 290 - ease * (290 - worst) * 0.97))
    d.path(speed, BLUE, 3)
    d.text(420, 80, "limit of velocity and acceleration of all axes", RED)
    d.text(330, 262, "planned speed, jerk kept", BLUE)
    d.save("feed")


def budget():
    d = Drawing(760, 170, "Split of the tolerance")
    shares = [("strip", 0.66, "#cfe0f3"), ("path", 0.08, "#e8f3ec"), ("linearisation", 0.1, SAND), ("rounding", 0.06, "#f6d5d0"), ("control", 0.1, "#e4e7ea")]
    x = 40.0
    for index, (name, share, colour) in enumerate(shares):
        width = 680 * share
        d.path([(x, 70), (x + width, 70), (x + width, 110), (x, 110)], DARK, 1, fill=colour, close=True)
        middle = x + width / 2
        y = 95 if share > 0.3 else (60 if index % 2 else 130)
        d.text(f"{middle:.1f}", y, name, anchor="middle")
        x += width
    d.arrow((40, 24), (720, 24), BLUE, 2, both=True)
    d.text(380, 18, "tolerance.total", BLUE, anchor="middle")
    d.arrow((40 + 680 * 0.66, 150), (720, 150), RED, 2, both=True)
    d.text(40 + 680 * 0.83, 166, "d: everything after the strips", RED, anchor="middle")
    d.save("budget")


if __name__ == "__main__":
    for draw in (cutter_location, strip, deviation, branches, feed, budget):
        draw()
