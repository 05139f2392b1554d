"""Programs, checks, posts, jobs."""

import json
import pickle
import shutil
import subprocess

import numpy as np
import pytest
from conftest import LOCATIONS, PROGRAM

import trunnion

SETUP = dict(tool_length=120, origin=(-381, -254, -505))


def test_a_cl_file_becomes_arrays(tmp_path):
    file = tmp_path / "part.cls"
    file.write_bytes(LOCATIONS)
    program = trunnion.read(file)
    assert len(program) == 4 and program.tip.shape == program.axis.shape == (4, 3)
    assert program.line.tolist() == [3, 4, 5, 6]
    np.testing.assert_allclose(program.feed, 1000 / 60)
    assert program.length == pytest.approx(np.linalg.norm(np.diff(program.tip, axis=0), axis=1).sum())
    assert not program.rapid.any()
    assert program.to_dict()["tip"] is program.tip
    assert list(program.to_pandas().columns)[:4] == ["line", "tip_0", "tip_1", "tip_2"]
    assert "<svg" in program._repr_html_()
    same = trunnion.read(LOCATIONS, suffix=".cls")
    np.testing.assert_array_equal(same.tip, program.tip)


def test_a_program_needs_its_machine_where_rotaries_move():
    program = trunnion.read(PROGRAM, machine="bc-trunnion", **SETUP)
    machine = trunnion.Machine("bc-trunnion", **SETUP)
    np.testing.assert_allclose(machine.forward(program.q)[0], program.tip, atol=1e-9)
    with pytest.raises(trunnion.InputError, match="moves rotary axes") as found:
        trunnion.read(PROGRAM)
    assert "machine" in found.value.remedy
    upright = trunnion.read(b"G21 G90\nG0 X0 Y0 Z5\nG1 Z0 F600\nG1 X20\nM2\n")
    assert upright.rapid.tolist() == [True, False, False] and upright.cutting_length == 25


def test_faults_of_a_program_have_lines():
    with pytest.raises(trunnion.InputError) as found:
        trunnion.read(b"G0 X0 Y0 Z0\nG1 X[2 +\n", dialect="linuxcnc")
    assert found.value.line == 2 and found.value.file == "program"


def test_a_check_finds_the_gouge(tmp_path, plane, root):
    part = tmp_path / "plane.json"
    part.write_text(
        json.dumps({"degree": [1, 1], "knots": [[0, 0, 1, 1]] * 2, "points": [[[0, 0, 0], [0, 10, 0]], [[20, 0, 0], [20, 10, 0]]]})
    )
    cutter = trunnion.Cutter.flat(12, length=50)
    found = trunnion.check(LOCATIONS, dialect="apt", part=part, cutter=cutter, tolerance=(0.02, 0.002), grid=0.5)
    assert not found.passed and any("program" in one or "line" in one for one in found.failures)
    assert found.height.min() < -0.04 and found.point.shape == (len(found.height), 3)
    assert found.line[np.argmin(found.height)] in (5, 6)
    assert len(found.to_pandas()) == len(found.height)
    assert "<svg" in found._repr_html_()
    # The same plane drawn standing, and turned back.
    standing = tmp_path / "standing.json"
    points = [[[0, 0, 0], [0, 0, -10]], [[20, 0, 0], [20, 0, -10]]]
    standing.write_text(json.dumps({"degree": [1, 1], "knots": [[0, 0, 1, 1]] * 2, "points": points}))
    again = trunnion.check(
        LOCATIONS, dialect="apt", part=standing, part_rotation=[90, 0, 0], deg=True, cutter=cutter, tolerance=(0.02, 0.002), grid=0.5
    )
    assert again.failures == found.failures and np.array_equal(again.height, found.height)
    # The same as the command line says, number by number.
    assert found.to_dict()["deviation"]["gouge"] == pytest.approx(-found.height.min(), abs=1e-9)


def test_keywords_are_named_in_messages():
    with pytest.raises(trunnion.InputError, match="tool_length") as found:
        trunnion.check(PROGRAM, machine="bc-trunnion")
    assert "--" not in str(found.value)
    with pytest.raises(trunnion.InputError, match="did you mean clearance"):
        trunnion.check(PROGRAM, machine="bc-trunnion", clearence=1)
    with pytest.raises(trunnion.InputError, match="did you mean tolerance"):
        trunnion.check(PROGRAM, machine="bc-trunnion", tolerence=1)


def test_a_machine_brings_its_setup():
    machine = trunnion.Machine("bc-trunnion", **SETUP)
    with_machine = trunnion.check(PROGRAM, machine=machine).summary
    with_words = trunnion.check(PROGRAM, machine="bc-trunnion", **SETUP).summary
    assert with_machine == with_words
    # A part of the setup that is given takes the place of that of the machine, and of no other part.
    turned = trunnion.Machine("bc-trunnion", origin=(0, 0, 0), tool_length=120)
    assert trunnion.check(PROGRAM, machine=turned, origin=SETUP["origin"]).summary == with_words
    # A machine may be a dict as its file has it.
    data = trunnion._trunnion.toml_data(machine.to_toml())
    assert trunnion.check(PROGRAM, machine=data, **SETUP).summary == with_words
    assert trunnion.read(PROGRAM, machine=data, **SETUP).tip.tolist() == trunnion.read(PROGRAM, machine=machine).tip.tolist()


def test_the_solids_of_a_machine_are_found_from_everywhere(tmp_path, root, monkeypatch):
    corners = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]])
    faces = ["".join(f"vertex {x} {y} {z}\n" for x, y, z in corners[list(three)]) for three in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))]
    text = "".join(f"facet normal 0 0 0\nouter loop\n{face}endloop\nendfacet\n" for face in faces)
    (tmp_path / "column.stl").write_text(f"solid a\n{text}endsolid a\n")
    text = (root / "machines" / "bc-trunnion.toml").read_text()
    body = '\n[[body]]\nname = "column"\nlink = "b"\nkind = "stl"\nfile = "column.stl"\norigin = [900, 900, 900]\n'
    (tmp_path / "own.toml").write_text(text + body)
    data = trunnion._trunnion.toml_data(text + body)
    by_file = trunnion.Machine(tmp_path / "own.toml", **SETUP)
    monkeypatch.chdir(tmp_path)
    by_dict = trunnion.Machine(data, **SETUP)
    expected = trunnion.check(PROGRAM, machine="own.toml", **SETUP).summary
    assert trunnion.check(PROGRAM, machine=by_dict).summary == expected
    monkeypatch.chdir(root)
    assert trunnion.check(PROGRAM, machine=by_file).summary == expected
    with pytest.raises(trunnion.InputError, match="column.stl"):
        trunnion.check(PROGRAM, machine=by_dict)


def test_a_post_is_read_back(tmp_path):
    posted = trunnion.post(PROGRAM, "bc-trunnion", dialect="g93", **SETUP)
    assert posted.kept and "G93" in posted.text and posted.setup
    assert str(posted).startswith("output: g93 for bc-trunnion")
    assert posted.summary["motion"]["conserved"]
    file = tmp_path / "out.nc"
    again = trunnion.post(PROGRAM, trunnion.Machine("bc-trunnion", **SETUP), dialect="g93", output=file)
    body = [line for line in posted.text.splitlines() if line.startswith("G1")]
    assert body == [line for line in file.read_text().splitlines() if line.startswith("G1")]
    assert again.summary["output"] == str(file)
    # Its moves as arrays: those of the program that was posted.
    source = trunnion.read(PROGRAM, machine="bc-trunnion", **SETUP)
    np.testing.assert_allclose(posted.program.tip[-1], source.tip[-1], atol=1e-3)
    assert len(posted.to_pandas()) == len(posted.program) and posted._repr_html_().count("<svg") == 1
    for dialect in ("fanuc", "haas", "siemens", "heidenhain", "siemens-axes", "fanuc-vector"):
        other = trunnion.post(PROGRAM, trunnion.Machine("bc-trunnion", **SETUP), dialect=dialect)
        np.testing.assert_allclose(other.program.tip[-1], source.tip[-1], atol=2e-3, err_msg=dialect)


def test_the_command_line_says_the_same(tmp_path):
    binary = shutil.which("trunnion")
    if binary is None:
        pytest.skip("the program `trunnion` is not installed here")
    file = tmp_path / "part.ngc"
    file.write_bytes(PROGRAM)
    words = ["check", file, "--machine", "bc-trunnion", "--tool-length", "120", "--origin", "-381,-254,-505", "--json"]
    done = subprocess.run([binary, *words], capture_output=True, text=True)
    assert json.loads(done.stdout) == trunnion.check(file, machine="bc-trunnion", **SETUP).summary


def test_a_batch_of_the_command_line_is_a_fleet(tmp_path):
    binary = shutil.which("trunnion")
    if binary is None:
        pytest.skip("the program `trunnion` is not installed here")
    programs = tmp_path / "programs"
    programs.mkdir()
    for name, content in (("a", PROGRAM), ("b", PROGRAM.replace(b"X40", b"X4000")), ("c", b"G1 X[2 +\n")):
        (programs / f"{name}.ngc").write_bytes(content)
    check = ["--", "--machine", "bc-trunnion", "--tool-length", "120", "--origin", "-381,-254,-505"]
    words = [binary, "batch", programs, "-o", tmp_path / "out", "--json", *check]
    items = json.loads(subprocess.run(words, capture_output=True, text=True).stdout)["items"]
    rows = trunnion.fleet.audit(sorted(programs.iterdir()), "bc-trunnion", workers=0, **SETUP).rows
    verdicts = {True: "kept", False: "broken", None: "failed"}
    assert [item["status"] for item in items] == [verdicts[row["passed"]] for row in rows] == ["kept", "broken", "failed"]
    assert ["\n".join(item["messages"]) for item in items] == [row["message"] for row in rows]


def test_a_job_runs(job_folder):
    stages = []
    result = trunnion.run(job_folder / "job.toml", progress=lambda stage, done, total: stages.append(stage))
    assert result.passed and not result.failures and not result.files
    assert stages and result.programs
    assert result.tip.shape == result.axis.shape and len(result.cutting) == len(result.tip)
    assert {"tip", "axis", "contact", "width"} <= set(result.passes[0])
    motion = result.sample(0.01, deg=True)
    assert motion.position.shape == (len(motion.t), 5) and motion.t[-1] == pytest.approx(result.duration, rel=1e-6)
    limits = result.limits(deg=True)
    assert (np.abs(motion.velocity) <= limits["velocity"] * (1 + 1e-6)).all()
    assert np.concatenate([one["height"] for one in result.maps]).size > 100
    assert result.cl.startswith(("PARTNO", "$$", "UNITS")) and "<svg" in result._repr_html_()
    # Its own program passes the check of the same job.
    name, text = next(iter(result.programs.items()))
    (job_folder / name).write_text(text)
    assert trunnion.check(job_folder / name, job=job_folder / "job.toml").passed


def test_a_job_in_code_is_the_job_of_the_file(job_folder, tmp_path):
    job = trunnion.Job.read(job_folder / "job.toml")
    assert job.check() == []
    assert "<svg" in job._repr_html_() and "widest" in job._repr_html_()
    assert "<svg" not in trunnion.Job({"name": "no part"})._repr_html_()
    again = trunnion.Job(job.data, job_folder)
    assert again.check() == []
    again.save(job_folder / "saved.toml")
    assert trunnion.Job.read(job_folder / "saved.toml").data == job.data
    wrong = job.replace({"tolerance.total": -1.0})
    with pytest.raises(trunnion.InputError, match="total") as found:
        wrong.check()
    assert found.value.line


def test_passes_are_shown_while_they_are_placed(job_folder):
    heard = []
    result = trunnion.run(job_folder / "job.toml", on_passes=lambda face, passes: heard.append((face, passes)))
    assert {face for face, _ in heard} == {one["face"] for one in result.passes}
    # The last word about a face is its passes; they are put in another order later.
    last = dict(heard)
    placed = sorted(one["tip"].tobytes() for passes in last.values() for one in passes)
    assert placed == sorted(one["tip"].tobytes() for one in result.passes)
    assert list(last.values())[0][0].keys() == result.passes[0].keys()

    def stop(face, passes):
        raise StopIteration(f"face {face}")

    with pytest.raises(StopIteration, match="face"):
        trunnion.run(job_folder / "job.toml", on_passes=stop)
    with pytest.raises(trunnion.ArgumentError, match="on_passes = int cannot be called"):
        trunnion.run(job_folder / "job.toml", on_passes=1)


def test_outputs_are_written_where_asked(job_folder):
    result = trunnion.run(job_folder / "job.toml", output=job_folder / "out")
    names = {path.name for path in (job_folder / "out").iterdir()}
    assert {"report.html", "summary.json", "motion.csv", "toolpath.cls", "setup.txt"} <= names
    assert {file.name for file in result.files} == names


def test_ctrl_c_stops_a_run(job_folder):
    class Enough(Exception):
        pass

    def stop(stage, done, total):
        raise Enough

    with pytest.raises(Enough):
        trunnion.run(job_folder / "job.toml", progress=stop)


def test_signals_are_heard(job_folder, root):
    import os
    import signal
    import sys
    import time

    # A shell in the background leaves SIGINT ignored, and Python keeps it so.
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    job = str(root / "examples/bezier-patch/job.toml")
    script = f"{heard}; import trunnion; print('ready', flush=True); trunnion.run({job!r})"
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout.readline() == b"ready\n"
    time.sleep(0.5)
    start = time.monotonic()
    os.kill(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert b"KeyboardInterrupt" in errors and time.monotonic() - start < 20


def test_tqdm_is_moved(job_folder):
    tqdm = pytest.importorskip("tqdm").tqdm
    bar = tqdm(total=1, disable=False)
    trunnion.check(LOCATIONS, dialect="apt", cutter="R=0,r=3,L=40", stock="box:-10,0,-10,30,10,0", progress=bar)
    bar.close()


def test_results_go_to_arrow_and_share_their_memory(tmp_path):
    program = trunnion.read(LOCATIONS, suffix=".cls")
    # Parts of an array are views of it: nothing is copied.
    assert np.shares_memory(program.tip, program.to_dict()["tip"])
    plan = trunnion.plan({"s": [0, 1], "X": [0, 10], "X1": [10, 10], "X2": [0, 0]}, {"X": (100, 1000)}, "optimal")
    assert np.shares_memory(plan.s, plan.speed.base) and np.shares_memory(plan.s, plan.t.base)
    pyarrow = pytest.importorskip("pyarrow")
    pytest.importorskip("pandas")
    table = pyarrow.table(program)
    assert table.num_rows == 4 and table["tip_0"].to_pylist() == program.tip[:, 0].tolist()
    assert pyarrow.table(plan).column_names == ["s", "t", "speed", "acceleration"]


def test_errors_can_be_sent_to_other_processes():
    with pytest.raises(trunnion.InputError) as found:
        trunnion.Machine("bc-trunnion").forward([[0, 0, 0, 0, np.nan]])
    again = pickle.loads(pickle.dumps(found.value))
    assert again.argument == "q" and again.index == (0, 4) and str(again) == str(found.value)


def test_a_proposed_job_runs(root, tmp_path):
    part = root / "fixtures" / "corpus" / "gate" / "cone.step"
    job = trunnion.Job.propose(part, "ac-trunnion")
    assert job.data["part"]["faces"] and job.data["part"]["file"] == str(part)
    assert job.check() == [] and job.data["machine"]["file"] == "ac-trunnion"
    first = job.data["part"]["faces"][:1]
    assert trunnion.Job.propose(part, faces=first).data["part"]["faces"] == first
    turned = trunnion.Job.propose(part, "ac-trunnion", rotation=[np.pi, 0, 0])
    assert turned.data["part"]["rotation"] == [180, 0, 0] and turned.data["part"]["faces"] != job.data["part"]["faces"]
    result = job.run(output=tmp_path / "out")
    assert result.passed, result.failures
    with pytest.raises(trunnion.InputError, match="has no face 99"):
        trunnion.Job.propose(part, faces=[99])


def test_setups_of_a_job_are_searched(job_folder):
    job = trunnion.Job.read(job_folder / "job.toml")
    found = job.setups(tilt=(0, 30), towards=(0, 0))
    assert found["found"] and found["after"]["least_angle"] >= found["before"]["least_angle"]
    # A job that was changed in memory is searched as it is now, wherever its files are.
    turned = job.replace({"setup.rotation": [0, 5, 0]}).setups(tilt=(0, 10), towards=(0, 0))
    assert turned["before"]["tilt"] == pytest.approx(5)
    with pytest.raises(trunnion.InputError, match="tilt"):
        job.setups(tilt=(10, 0))
