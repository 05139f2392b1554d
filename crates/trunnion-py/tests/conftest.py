"""Files that several tests use."""

import os
import pathlib
import shutil

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
#: Reference cases that are not part of the repository.
SHARED = pathlib.Path(os.environ.get("TRUNNION_SHARED", ROOT.parent / "shared"))


@pytest.fixture(scope="session")
def root():
    return ROOT


@pytest.fixture(scope="session")
def shared():
    if not (SHARED / "cases").is_dir():
        pytest.skip("the reference cases are not here: set TRUNNION_SHARED to their folder")
    return SHARED


@pytest.fixture
def patch():
    return ROOT / "fixtures" / "bezier-patch" / "patch.json"


@pytest.fixture
def job_folder(tmp_path):
    """A small job that runs in seconds: job.toml, patch.json and the machine."""
    source = ROOT / "fixtures" / "small-patch"
    for name in ("job.toml", "patch.json"):
        shutil.copy(source / name, tmp_path / name)
    shutil.copy(ROOT / "machines" / "bc-trunnion.toml", tmp_path / "machine.toml")
    return tmp_path


PROGRAM = b"""G21 G90 G94
T1 M6
M3 S1000
G43 H1
G0 X0 Y0 Z50 B0 C0
G1 Z5 F600
G1 X20 Y10 B10 C5 F600
G1 X40 Y0 B0 C0
M2
"""

LOCATIONS = b"""UNITS/MM
FEDRAT/1000,MMPM
GOTO/-5,5,0.01,0,0,1
GOTO/10,5,0.01,0,0,1
GOTO/10,5,-0.05,0,0,1
GOTO/25,5,0.01,0,0,1
FINI
"""


@pytest.fixture
def plane():
    import trunnion

    return trunnion.Part.from_net([[[0, 0, 0], [0, 10, 0]], [[20, 0, 0], [20, 10, 0]]], degree=(1, 1))
