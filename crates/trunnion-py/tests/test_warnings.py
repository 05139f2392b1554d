"""Remarks of the engine are Python warnings at the caller's line; nothing is written past them."""

import subprocess
import sys
import warnings

import pytest
from conftest import PROGRAM

import trunnion

SETUP = dict(tool_length=120, origin=(-381, -254, -505))
#: A dwell is left out; no tool length is in force.
REMARKABLE = PROGRAM.replace(b"G43 H1\n", b"").replace(b"M2", b"G4 P1\nM2").replace(b"Z50", b"Z200").replace(b"Z5 ", b"Z150 ")


def calls(tmp_path):
    file = tmp_path / "remarkable.ngc"
    file.write_bytes(REMARKABLE)
    return {
        "read": lambda: trunnion.read(REMARKABLE, machine="bc-trunnion", **SETUP),
        "read of a file": lambda: trunnion.read(file, machine="bc-trunnion", **SETUP),
        "Path.read": lambda: trunnion.Path.read(REMARKABLE, machine="bc-trunnion", **SETUP),
        "post": lambda: trunnion.post(REMARKABLE, "bc-trunnion", dialect="g93", **SETUP),
        "PostResult.program": lambda: trunnion.post(REMARKABLE, "bc-trunnion", dialect="g93", **SETUP),
    }


@pytest.mark.parametrize("name", ["read", "read of a file", "Path.read", "post", "PostResult.program"])
def test_remarks_are_warnings_at_the_callers_line(name, tmp_path, capfd):
    call = calls(tmp_path)[name]
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        call()
    said = [str(one.message) for one in found]
    assert any("no tool length is in force" in one for one in said) and any("left out: 1 dwells" in one for one in said)
    assert all(issubclass(one.category, trunnion.TrunnionWarning) and one.filename == __file__ for one in found)
    # Words of Python, and no file that nobody knows.
    assert not any("--" in one or "/tmp" in one.replace(str(tmp_path), "") for one in said)
    assert capfd.readouterr() == ("", "")


def test_remarks_stay_with_the_result():
    with pytest.warns(trunnion.TrunnionWarning) as found:
        program = trunnion.read(REMARKABLE, machine="bc-trunnion", **SETUP)
    assert program.warnings == [str(one.message) for one in found]
    assert "give tool_length 0" in program.warnings[0] and program.warnings[0].startswith("program:5: ")
    with pytest.warns(trunnion.TrunnionWarning) as found:
        posted = trunnion.post(REMARKABLE, "bc-trunnion", dialect="g93", **SETUP)
    assert posted.warnings == [str(one.message) for one in found] and "give from_tool_length 0" in posted.warnings[0]


def test_remarks_about_a_cl_file_are_warnings(capfd):
    with pytest.warns(trunnion.TrunnionWarning, match="program:2:1: WOBBLE") as found:
        program = trunnion.read(b"UNITS/MM\nWOBBLE/9\nFEDRAT/600,MMPM\nGOTO/0,0,0\nGOTO/9,0,0\nFINI\n", suffix=".cls")
    assert len(found) == len(program.warnings) and capfd.readouterr() == ("", "")


def test_a_refusal_has_the_remarks_that_may_be_its_reason(capfd):
    program = b"G21 G90 G54 G94\nT1 M6\nG0 X0 Y0 Z20 B0 C0\nG1 Z-60 F100\nM2\n"
    with pytest.raises(trunnion.InputError) as found:
        trunnion.post(program, "bc-trunnion", dialect="linuxcnc", **SETUP)
    assert found.value.line == 4 and "Z = " in found.value.message
    assert "no tool length is in force" in found.value.messages[1]
    assert capfd.readouterr() == ("", "")


def test_a_program_may_take_warnings_as_errors(tmp_path):
    script = tmp_path / "strict.py"
    script.write_text(
        "import trunnion\n"
        f"trunnion.read({REMARKABLE!r}, machine='bc-trunnion', tool_length=120, origin=(-381, -254, -505))\n"
    )
    done = subprocess.run([sys.executable, "-W", "error", str(script)], capture_output=True, text=True)
    assert done.returncode == 1 and "trunnion.TrunnionWarning" in done.stderr.replace("_errors.", "")
    # By default the line of the script is shown.
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True)
    assert done.returncode == 0 and f"{script}:2: TrunnionWarning: " in done.stderr


@pytest.mark.filterwarnings("ignore")
def test_no_call_writes_past_the_interpreter(job_folder, root, capfd):
    job = job_folder / "job.toml"
    program = trunnion.run(job, output=job_folder / "out").programs
    trunnion.check(next(iter(program.values())).encode(), job=job)
    trunnion.check(REMARKABLE, machine="bc-trunnion", **SETUP)
    trunnion.Job.propose(root / "fixtures" / "corpus" / "gate" / "cone.step", "ac-trunnion")
    trunnion.Job.read(job).setups(tilt=(0, 5), towards=(0, 0))
    trunnion.Machine.from_control(root / "fixtures/machine-descriptions/siemens-table.mpf")
    trunnion.plan(root / "examples/axis-path/path.csv", root / "examples/axis-path/limits.toml")
    trunnion.fleet.audit([REMARKABLE], "bc-trunnion", workers=0, **SETUP).rows
    assert capfd.readouterr() == ("", "")
