"""Every result: a dict, a DataFrame, an Arrow table, and a picture in a notebook."""

import numpy as np
import pytest
from conftest import LOCATIONS, PROGRAM

import trunnion

SETUP = dict(tool_length=120, origin=(-381, -254, -505))
BULL = trunnion.Cutter.bull(4, 2, length=60)
TABLE = {"s": [0, 1], "X": [0, 10], "X1": [10, 10], "X2": [0, 0]}
SQUARE = ([[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 4]], [[0, 1, 2], [0, 2, 3]])


def part(folder):
    net = [[[x, y, 12 - 0.01 * (x * x + y * y)] for y in (-30, -10, 10, 30)] for x in (-30, -10, 10, 30)]
    return trunnion.Part.from_net(net)


def plane(folder):
    file = folder / "plane.json"
    file.write_text('{"degree": [1, 1], "knots": [[0, 0, 1, 1], [0, 0, 1, 1]], "points": [[[0, 0, 0], [0, 10, 0]], [[20, 0, 0], [20, 10, 0]]]}')
    return file


TABLES = {
    "Program": lambda folder: trunnion.read(PROGRAM, machine="bc-trunnion", **SETUP),
    "Path": lambda folder: trunnion.Path.from_cl(LOCATIONS.decode()),
    "PostResult": lambda folder: trunnion.post(PROGRAM, "bc-trunnion", dialect="g93", **SETUP),
    "CheckResult": lambda folder: trunnion.check(
        LOCATIONS, dialect="apt", part=plane(folder), cutter="R=0,r=3,L=40", tolerance=(0.02, 0.002), grid=0.5
    ),
    "RunResult": lambda folder: trunnion.run(folder / "job.toml"),
    "Covering": lambda folder: trunnion.cover(part(folder), BULL, excess=0.2, gouge=0.02, along="u", method="inclined", lead=5),
    "DropResult": lambda folder: trunnion.drop_cutter(SQUARE, BULL, np.random.default_rng(3).uniform(-20, 20, (300, 2))),
    "Plan": lambda folder: trunnion.plan(TABLE, {"X": (100, 1000, 20000)}),
}
SHOWN = {
    "Machine": lambda folder: trunnion.Machine("bc-trunnion", **SETUP),
    "Part": part,
    "Job": lambda folder: trunnion.Job.read(folder / "job.toml"),
    "CutterLocation": lambda folder: trunnion.position(part(folder).faces[0], BULL, at=(0.5, 0.5), feed=(0, 1), method="sturz"),
    "SmoothPath": lambda folder: trunnion.Path.from_cl(LOCATIONS.decode()).smooth(),
}


@pytest.mark.parametrize("name", TABLES)
def test_a_result_is_a_table(name, job_folder):
    pytest.importorskip("pandas")
    result = TABLES[name](job_folder)
    assert type(result).__name__ == name and isinstance(result.to_dict(), dict)
    frame = result.to_pandas()
    assert len(frame) > 0
    pyarrow = pytest.importorskip("pyarrow")
    table = pyarrow.table(result)
    assert table.num_rows == len(frame) and table.column_names == list(frame.columns)


@pytest.mark.parametrize("name", [*TABLES, *SHOWN])
def test_a_notebook_shows_a_picture(name, job_folder):
    import xml.etree.ElementTree

    shown = {**TABLES, **SHOWN}[name](job_folder)._repr_html_()
    assert shown.count("<svg") == 1
    picture = xml.etree.ElementTree.fromstring(shown[shown.index("<svg") : shown.index("</svg>") + 6])
    assert len(list(picture.iter())) > 4


def test_a_picture_of_lowered_cutters_has_every_place():
    found = trunnion.drop_cutter(SQUARE, BULL, np.random.default_rng(3).uniform(-20, 20, (300, 2)))
    shown = found._repr_html_()
    assert shown.count("<circle") == np.isfinite(found.z).sum() and shown.count(">x<") == np.isnan(found.z).sum()
    nothing = trunnion.drop_cutter(SQUARE, BULL, [[90, 90]])
    assert "nothing below" in nothing._repr_html_() and "no places" in trunnion.drop_cutter(SQUARE, BULL, np.zeros((0, 2)))._repr_html_()
