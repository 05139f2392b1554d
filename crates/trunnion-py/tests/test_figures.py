"""Figures of matplotlib: what they show is what the result has, and a notebook shows them."""

import numpy as np
import pytest
from conftest import LOCATIONS

import trunnion

pytest.importorskip("matplotlib", reason="matplotlib is not installed: pip install trunnion[plot]")

TABLE = {"s": [0, 1], "X": [0, 10], "X1": [10, 10], "X2": [0, 0], "B": [0, 1], "B1": [1, 1], "B2": [0, 0]}
BULL = trunnion.Cutter.bull(4, 2, length=60)


@pytest.fixture
def dome():
    net = [[[x, y, 12 - 0.01 * (x * x + y * y)] for y in (-30, -10, 10, 30)] for x in (-30, -10, 10, 30)]
    return trunnion.Part.from_net(net)


def test_axes_are_drawn_over_their_limits():
    plan = trunnion.plan(TABLE, {"X": (100, 1000, 20000), "B": (3, 30, 600)})
    figure = trunnion.plot.axes(plan, period=0.001)
    motion = plan.sample(0.001)
    for row, values, limits in zip(figure.axes, motion[2:], [(100, 3), (1000, 30), (20000, 600)]):
        assert [line.get_label() for line in row.lines[:2]] == ["X", "B"]
        for index, limit in enumerate(limits):
            np.testing.assert_allclose(row.lines[index].get_ydata(), values[:, index] / limit)
            assert abs(row.lines[index].get_ydata()).max() <= 1 + 1e-6


def test_strip_widths_are_drawn_pass_by_pass(dome):
    found = trunnion.cover(dome, BULL, excess=0.2, gouge=0.02, along="u", method="inclined", lead=5)
    (row,) = trunnion.plot.strip_width(found).axes
    assert len(row.lines) == len(found.passes)
    ends = [line.get_xdata()[-1] for line in row.lines]
    assert ends == sorted(ends)
    for line, one in zip(row.lines, found.passes):
        np.testing.assert_array_equal(line.get_ydata(), one["width"][: len(line.get_ydata())])


def test_the_error_curve_has_its_tolerance(dome):
    found = trunnion.position(dome.faces[0], BULL, at=(0.5, 0.5), feed=(0, 1), method="sturz")
    (row,) = trunnion.plot.error_curve(found, 0.01).axes
    np.testing.assert_array_equal(row.lines[0].get_ydata(), found.error_curve[:, 2])
    assert [line.get_ydata()[0] for line in row.lines[1:]] == [0.0, 0.01] and row.get_ylim() == (-0.005, 0.03)


def test_the_histogram_counts_every_point(tmp_path):
    part = tmp_path / "plane.json"
    part.write_text('{"degree": [1, 1], "knots": [[0, 0, 1, 1], [0, 0, 1, 1]], "points": [[[0, 0, 0], [0, 10, 0]], [[20, 0, 0], [20, 10, 0]]]}')
    found = trunnion.check(LOCATIONS, dialect="apt", part=part, cutter="R=0,r=3,L=40", tolerance=(0.02, 0.002), grid=0.5)
    (row,) = trunnion.plot.deviation(found, bins=30).axes
    assert len(row.patches) == 30
    assert sum(bar.get_height() for bar in row.patches) == np.isfinite(found.height).sum() > 0


def test_a_notebook_shows_a_figure():
    figure = trunnion.plot.axes(trunnion.plan(TABLE, {"X": (100, 1000, 20000), "B": (3, 30, 600)}))
    assert figure._repr_png_().startswith(b"\x89PNG")
    import matplotlib.pyplot

    # None stays open behind the back of a script.
    assert not matplotlib.pyplot.get_fignums()
