"""Pictures in space, drawn without a window."""

import numpy as np
import pytest
from conftest import LOCATIONS, PROGRAM

import trunnion

pyvista = pytest.importorskip("pyvista", reason="pyvista is not installed: pip install trunnion[view]")


@pytest.fixture
def dome():
    net = [[[x, y, 12 - 0.01 * (x * x + y * y)] for y in (-30, -10, 10, 30)] for x in (-30, -10, 10, 30)]
    return trunnion.Part.from_net(net)


BULL = trunnion.Cutter.bull(4, 2, length=40)


def colours(scene):
    """Number of pixels of each kind: warm ones of the tool, blue ones of the passes, grey ones of the part."""
    picture = scene.screenshot(return_img=True).astype(int)
    scene.close()
    red, green, blue = (picture[..., index] for index in range(3))
    grey = (abs(red - green) < 12) & (abs(green - blue) < 12) & (red < 240)
    return {"tool": int((red - blue > 40).sum()), "passes": int((blue - red > 40).sum()), "part": int(grey.sum())}


def test_part_passes_and_tool_are_seen(dome):
    covering = trunnion.cover(dome, BULL, excess=0.2, gouge=0.02, along="u", method="inclined", lead=5)
    alone = colours(trunnion.plot.view(dome, off_screen=True))
    passes = colours(trunnion.plot.view(dome, covering, off_screen=True))
    both = colours(trunnion.plot.view(dome, covering, cutter=BULL, at=len(covering.passes[0]["tip"]) // 2, off_screen=True))
    assert alone["part"] > 10_000
    assert passes["passes"] > alone["passes"] + 1000
    assert both["tool"] > passes["tool"] + 1000


def test_the_tool_stands_on_its_location():
    path = trunnion.Path([[0, 0, 0], [10, 5, 1]], [[0, 0, 1], [0.6, 0, 0.8]])
    scene = trunnion.plot.view(result=path, cutter=BULL, at=-1, off_screen=True)
    tool = scene.meshes[-1]
    scene.close()
    # Heights above the tip along the tool axis, and distances from it, are those of the cutter.
    offset = np.asarray(tool.points) - path.tip[-1]
    height = offset @ path.axis[-1]
    radius = np.linalg.norm(offset - np.outer(height, path.axis[-1]), axis=1)
    assert height.min() == pytest.approx(0.0, abs=1e-4) and height.max() == pytest.approx(40.0, abs=1e-4)
    assert radius.max() == pytest.approx(6.0, abs=1e-4)


def test_deviation_of_a_run_is_coloured(job_folder):
    result = trunnion.run(job_folder / "job.toml")
    scene = trunnion.plot.view(trunnion.Part.read(job_folder / "patch.json"), result, off_screen=True)
    (name,) = scene.scalar_bars.keys()
    low, high = scene.scalar_bars[name].GetLookupTable().GetTableRange()
    heights = np.concatenate([one["height"] for one in result.maps])
    scene.close()
    assert name == "deviation, mm" and high == -low == pytest.approx(np.nanmax(np.abs(heights)))


def test_deviation_of_a_check_is_coloured(job_folder):
    plane = job_folder / "plane.json"
    plane.write_text('{"degree": [1, 1], "knots": [[0, 0, 1, 1], [0, 0, 1, 1]], "points": [[[0, 0, 0], [0, 10, 0]], [[20, 0, 0], [20, 10, 0]]]}')
    found = trunnion.check(LOCATIONS, dialect="apt", part=plane, cutter="R=0,r=3,L=40", tolerance=(0.02, 0.002), grid=0.5)
    scene = trunnion.plot.view(trunnion.Part.read(plane), found, off_screen=True)
    cloud = scene.meshes[-1]
    scene.close()
    cut = np.isfinite(found.height)
    np.testing.assert_array_equal(cloud.points, found.point[cut].astype(cloud.points.dtype))
    np.testing.assert_array_equal(cloud["deviation, mm"], found.height[cut])


def test_a_face_and_the_moves_of_a_post_are_drawn(dome):
    face = colours(trunnion.plot.view(dome.faces[0], off_screen=True))
    assert face == colours(trunnion.plot.view(dome, off_screen=True)) and face["part"] > 10_000
    posted = trunnion.post(PROGRAM, "bc-trunnion", dialect="g93", origin=(-381, -254, -505), tool_length=120)
    scene = trunnion.plot.view(result=posted, off_screen=True)
    tips = np.concatenate([mesh.points for mesh in scene.meshes])
    scene.close()
    np.testing.assert_allclose(np.unique(tips, axis=0), np.unique(posted.program.tip, axis=0), atol=1e-4)


def test_a_triangulated_part_is_drawn(tmp_path):
    stl = tmp_path / "wedge.stl"
    stl.write_text(
        "solid w\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 3\nendloop\nendfacet\nendsolid w\n"
    )
    assert colours(trunnion.plot.view(trunnion.Part.read(stl), off_screen=True))["part"] > 1000


def test_an_index_without_a_location_is_refused():
    path = trunnion.Path([[0, 0, 0], [10, 5, 1]])
    for at in (2, -3, "x", True, 1.0, None, 10**400):
        with pytest.raises(trunnion.ArgumentError, match="one of 2 cutter locations"):
            trunnion.plot.view(result=path, cutter=BULL, at=at, off_screen=True)
