"""Many at once: resumed, on processes, on a Dask cluster of which a worker is killed."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest
from conftest import PROGRAM

import trunnion
from trunnion import fleet

SETUP = dict(tool_length=120, origin=(-381, -254, -505))


@pytest.fixture
def programs(tmp_path):
    names = []
    for index in range(6):
        file = tmp_path / f"part{index}.ngc"
        file.write_bytes(PROGRAM.replace(b"X20", f"X{20 + index}".encode()))
        names.append(str(file))
    return names


def test_items_are_resumed_by_content(programs, tmp_path):
    results = tmp_path / "results"
    first = fleet.audit(programs[:4], "bc-trunnion", results=results, workers=0, **SETUP)
    assert len(first) == 4 and not results.joinpath("x").exists()
    rows = first.rows
    assert all(row["status"] == "done" and row["duration"] > 0 for row in rows)
    kept = {path.name: path.stat().st_mtime_ns for path in results.iterdir()}
    assert len(kept) == 4
    os.rename(programs[0], programs[0] + ".moved")
    os.rename(programs[0] + ".moved", programs[0])
    again = fleet.audit(programs, "bc-trunnion", results=results, workers=0, **SETUP)
    assert again.rows[:4] == rows and len(list(results.iterdir())) == 6
    assert {name: (results / name).stat().st_mtime_ns for name in kept} == kept
    # An edited program is another item.
    with open(programs[0], "ab") as out:
        out.write(b"(edited)\n")
    assert fleet.audit(programs, "bc-trunnion", results=results, workers=0, **SETUP).rows
    assert len(list(results.iterdir())) == 7


def test_all_that_a_cutter_states_is_part_of_the_key(programs, tmp_path):
    cutters = [dict(), dict(shank=[[30, 7]]), dict(shank=[[30, 8]]), dict(inner=2.0)]
    keys = {
        fleet.audit(programs[:1], "bc-trunnion", results=tmp_path, cutter=trunnion.Cutter.bull(3, 2, length=90, **more))._items[0]["key"]
        for more in cutters
    }
    assert len(keys) == len(cutters)


def test_machines_are_names_files_objects_and_dicts(programs, tmp_path):
    machine = trunnion.Machine("bc-trunnion", **SETUP)
    data = trunnion._trunnion.toml_data(machine.to_toml())
    file = tmp_path / "own.toml"
    file.write_text(machine.to_toml())
    shorter = machine.with_setup(tool_length=90)
    results, setup = tmp_path / "r", dict(SETUP, rotation=(0, 0, 0))

    def audited(*machines):
        return fleet.audit(programs[0], machines, results=results, workers=0, **setup)

    rows = audited("bc-trunnion", file, machine, data).rows
    assert [row["machine"] for row in rows] == ["bc-trunnion", str(file), "bc-trunnion (2)", "bc-trunnion (3)"]
    assert all(row["status"] == "done" and row["duration"] == rows[0]["duration"] for row in rows)
    # An equal machine is the same item, one with another setup or another file is not.
    kept = len(list(results.iterdir()))
    assert audited(trunnion.Machine("bc-trunnion", **SETUP), dict(data)).rows and len(list(results.iterdir())) == kept
    data["axis"]["X"]["vel"] /= 2
    assert audited(shorter, data).rows and len(list(results.iterdir())) == kept + 2
    # The setup of a Machine is that of its checks.
    alone = fleet.audit(programs[0], machine, workers=0)
    assert alone.rows[0]["duration"] == rows[0]["duration"] and alone.rows[0]["passed"]
    with pytest.raises(trunnion.InputError, match="chain"):
        fleet.audit(programs[0], {"schema": "trunnion-machine/1"})


def test_every_file_that_an_item_reads_is_part_of_its_key(tmp_path, job_folder):
    (tmp_path / "column.stl").write_text("solid a\nendsolid a\n")
    machine = job_folder / "machine.toml"
    machine.write_text(machine.read_text() + '\n[[body]]\nname = "column"\nlink = "b"\nkind = "stl"\nfile = "column.stl"\n')
    program, called, vise = (tmp_path / name for name in ("part.ngc", "pocket.ngc", "vise.stl"))
    program.write_text("o<pocket> call\nM2\n")
    for file in (called, vise):
        file.write_text("as it was")

    def keys():
        options = dict(fixture=[f"{vise}@10,0,0"], **SETUP)
        audits = fleet.audit(program, [machine, trunnion.Machine(machine)], results=tmp_path / "kept", **options)
        return [item["key"] for item in [*audits._items, *fleet.compare(job_folder / "job.toml", {"tolerance": [0.1]})._items]]

    for file, changed in ((called, 2), (vise, 2), (tmp_path / "column.stl", 3), (job_folder / "patch.json", 1)):
        before = keys()
        with open(file, "a") as out:
            out.write("\n")
        assert sum(a != b for a, b in zip(before, keys())) == changed, file


def test_programs_are_not_read_where_nothing_is_kept(programs, tmp_path, monkeypatch):
    def read(paths, options):
        raise AssertionError

    monkeypatch.setattr(fleet, "_programs", read)
    found = fleet.audit(programs, ["bc-trunnion", "ac-trunnion"], workers=0)
    assert len(found) == 2 * len(programs) and len({item["key"] for item in found._items}) == len(found)
    with pytest.raises(AssertionError):
        fleet.audit(programs, "bc-trunnion", results=tmp_path / "r")


def test_another_build_of_the_same_version_has_other_keys(programs, tmp_path):
    """Copies of the package: as it is, with another module, and with another line of Python."""
    script = (
        "import trunnion\n"
        f"found = trunnion.fleet.audit({programs[:1]!r}, 'bc-trunnion', results={str(tmp_path / 'r')!r})\n"
        "print(trunnion.__version__, trunnion.__file__, found._items[0]['key'])\n"
    )
    package, found = os.path.dirname(trunnion.__file__), []
    for change in (None, os.path.basename(trunnion._trunnion.__file__), "_verbs.py"):
        copy = tmp_path / str(change)
        shutil.copytree(package, copy / "trunnion", ignore=shutil.ignore_patterns("__pycache__"))
        if change:
            with open(copy / "trunnion" / change, "ab") as out:
                out.write(b"\n")
        words = [sys.executable, "-c", script]
        done = subprocess.run(words, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(copy)}, check=True)
        version, file, key = done.stdout.split()
        assert file.startswith(str(copy)) and version == trunnion.__version__
        found.append(key)
    (own,) = fleet.audit(programs[:1], "bc-trunnion", results=tmp_path / "r")._items
    assert found[0] == own["key"] and len(set(found)) == 3


def test_a_worker_with_another_build_does_not_answer(programs):
    (item,) = fleet.audit(programs[:1], "bc-trunnion", **SETUP)._items
    assert fleet._worked_by(fleet._build(), fleet._worked, item)["row"]["status"] == "done"
    refused = fleet._worked_by("another", fleet._worked, item)
    assert refused["lost"] and "install the same wheel" in refused["row"]["message"]


def test_failures_stand_beside_results(programs, tmp_path):
    with open(programs[1], "wb") as out:
        out.write(b"G1 X[2 +\n")
    found = fleet.audit(programs[:3], ["bc-trunnion", "no-such"], results=tmp_path / "r", workers=2, **SETUP)
    assert [row["status"] for row in found.rows] == ["done", "failed", "failed", "failed", "done", "failed"]
    assert "part1.ngc:1" in found.failed[1]["message"]
    assert len(found.to_pandas()) == 6 and "<table>" in found._repr_html_()
    # A table for the eye: every digit stands in the rows.
    assert not re.search(r"<td>\d+\.\d{8}", found._repr_html_())
    assert found.summaries[1] is None and found.summaries[0]["machine"] == "bc-trunnion"


def test_urls_keep_results(programs):
    pytest.importorskip("fsspec")
    place = "memory://fleet-results"
    rows = fleet.audit(programs[:2], "bc-trunnion", results=place, workers=0, **SETUP).rows
    assert fleet.audit(programs[:2], "bc-trunnion", results=place, workers=0, **SETUP).rows == rows


def test_what_is_no_place_and_no_client_is_refused(programs):
    for argument, wrong in (("client", 3), ("results", 3), ("results", "nowhere://folder"), ("workers", -1), ("workers", "two")):
        with pytest.raises(trunnion.ArgumentError) as found:
            fleet.audit(programs[:1], "bc-trunnion", **{argument: wrong})
        assert found.value.argument == argument and str(found.value).startswith(argument)


def test_cut_off_results_are_run_again(programs, tmp_path):
    found = fleet.audit(programs[:1], "bc-trunnion", results=tmp_path / "r", workers=0, **SETUP)
    rows = found.rows
    (file,) = (tmp_path / "r").iterdir()
    file.write_text(file.read_text()[:50])
    again = fleet.audit(programs[:1], "bc-trunnion", results=tmp_path / "r", workers=0, **SETUP)
    assert again.rows == rows and json.loads(file.read_text())


def test_jobs_are_compared(job_folder, tmp_path):
    found = fleet.compare(
        job_folder / "job.toml",
        {"tolerance": [0.02, 0.05], "cutter": [trunnion.Cutter.ball(12, length=120)]},
        results=tmp_path / "r",
        workers=2,
    )
    assert len(found) == 2 and found.to_dict()["tolerance"] == [0.02, 0.05]
    done = [row for row in found.rows if row["status"] == "done"]
    assert done and all(row["passes"] > 0 for row in done)
    # The job has an origin and a rotation; those of a Machine, where it has some, take their place.
    where = trunnion.Machine("bc-trunnion", origin=(-381, -254, -500), rotation=(0, 20, 0), deg=True)
    ranked = fleet.which_machine(job_folder / "job.toml", ["no-such", where], workers=0)
    assert [row["machine"] for row in ranked] == ["bc-trunnion", "no-such"] and ranked[0]["passed"]
    (item,) = fleet.compare(job_folder / "job.toml", {"machine": where})._items
    assert item["work"]["data"]["setup"]["origin"] == [-381, -254, -500]
    assert item["work"]["data"]["setup"]["rotation"] == pytest.approx([0, 20, 0])


def logged(item):
    """An item that leaves a line where it begins and where it ends, and takes a while."""
    log = item["work"]["log"]
    with open(log, "a") as out:
        out.write(f"begin {item['key']} {os.getpid()}\n")
    time.sleep(0.25)
    found = fleet._audited(item["work"])
    with open(log, "a") as out:
        out.write(f"end {item['key']} {os.getpid()}\n")
    return found


def test_a_killed_worker_loses_nothing(tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(fleet, "_worked", logged)
    log, names = tmp_path / "log", []
    log.touch()
    for index in range(24):
        file = tmp_path / f"part{index}.ngc"
        file.write_bytes(PROGRAM.replace(b"X20", f"X{20 + index}".encode()))
        names.append(str(file))
    cluster = distributed.LocalCluster(
        n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    )
    with cluster, distributed.Client(cluster) as client:
        client.upload_file(__file__)
        found = fleet.audit(names, "bc-trunnion", results=tmp_path / "results", client=client, **SETUP)
        for item in found._items:
            item["work"]["log"] = str(log)
        rows, killed = [], None
        for row in found:
            rows.append(row)
            if len(rows) == 3:
                killed = int(log.read_text().splitlines()[-1].split()[2])
                os.kill(killed, signal.SIGKILL)
    assert killed and len(rows) == 24 and all(row["status"] == "done" for row in rows)
    lines = [line.split() for line in log.read_text().splitlines()]
    ended = [key for what, key, _ in lines if what == "end"]
    # Nothing is lost, and nothing done is done again: a second begin is only that of the killed worker's item.
    assert set(ended) == {item["key"] for item in found._items}
    saved = list((tmp_path / "results").iterdir())
    assert len(saved) == 24
    begun = [key for what, key, _ in lines if what == "begin"]
    unfinished = {key for what, key, pid in lines if what == "begin" and int(pid) == killed}
    twice = {key for key in begun if begun.count(key) > 1}
    assert twice <= unfinished


def deadly(item):
    """An item that takes its worker with it the first time."""
    marker = item["work"]["program"] + ".died"
    if item["work"]["program"].endswith("part2.ngc") and not os.path.exists(marker):
        open(marker, "w").close()
        os.kill(os.getpid(), signal.SIGKILL)
    return fleet._audited(item["work"])


def test_processes_that_die_are_replaced(programs, monkeypatch):
    monkeypatch.setattr(fleet, "_worked", deadly)
    found = fleet.audit(programs, "bc-trunnion", workers=2, **SETUP)
    assert [row["status"] for row in found.rows] == ["done"] * 6


def always_deadly(item):
    """An item that takes every worker with it."""
    if item["work"]["program"].endswith("part2.ngc"):
        os.kill(os.getpid(), signal.SIGKILL)
    return fleet._audited(item["work"])


def test_an_item_that_kills_every_worker_fails_alone(programs, tmp_path, monkeypatch):
    monkeypatch.setattr(fleet, "_worked", always_deadly)
    results = tmp_path / "r"
    found = fleet.audit(programs[:4], "bc-trunnion", results=results, workers=2, **SETUP)
    assert [row["status"] for row in found.rows] == ["done", "done", "failed", "done"]
    assert "ended by signal 9 in the middle of this item" in found.failed[0]["message"]
    # What says nothing of the item is not kept: the next time it is tried again.
    assert len(list(results.iterdir())) == 3


@pytest.mark.filterwarnings("error::ResourceWarning", "error::pytest.PytestUnraisableExceptionWarning")
def test_a_fleet_leaves_no_file_open(programs):
    import gc

    assert all(row["status"] == "done" for row in fleet.audit(programs[:2], "bc-trunnion", workers=2, **SETUP).rows)
    gc.collect()


def test_leaving_the_loop_ends_the_workers(tmp_path, monkeypatch):
    monkeypatch.setattr(fleet, "_worked", logged)
    log, names = tmp_path / "log", []
    for index in range(20):
        names.append(tmp_path / f"part{index}.ngc")
        names[-1].write_bytes(PROGRAM.replace(b"X20", f"X{20 + index}".encode()))
    found = fleet.audit(names, "bc-trunnion", workers=2, **SETUP)
    for item in found._items:
        item["work"]["log"] = str(log)
    for row in found:
        assert row["status"] == "done"
        break
    begun = log.read_text().count("begin")
    assert begun < 10
    time.sleep(0.5)
    assert log.read_text().count("begin") == begun


def test_ctrl_c_ends_a_fleet(root):
    script = (
        "import os, signal, threading, trunnion\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        f"job = {str(root / 'examples/bezier-patch/job.toml')!r}\n"
        "trunnion.fleet.compare(job, {'tolerance': [0.01 + 0.001 * i for i in range(60)]}, workers=2).rows\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert done.stderr.rstrip().endswith("KeyboardInterrupt"), done.stderr


def test_a_script_needs_no_main_guard(programs, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import trunnion\n"
        "print('begins')\n"
        f"found = trunnion.fleet.audit({programs[:2]!r}, 'bc-trunnion', workers=2, tool_length=120, origin=(-381, -254, -505))\n"
        "print([row['status'] for row in found.rows])\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True)
    assert done.stdout == "begins\n['done', 'done']\n", done.stderr
