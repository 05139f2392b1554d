"""Many at once: resumed, on processes, on a Dask cluster of which a worker is killed."""

import json
import os
import signal
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


def test_all_that_a_cutter_states_is_part_of_the_key(programs):
    cutters = [dict(), dict(shank=[[30, 7]]), dict(shank=[[30, 8]]), dict(inner=2.0)]
    keys = {
        fleet.audit(programs[:1], "bc-trunnion", cutter=trunnion.Cutter.bull(3, 2, length=90, **more))._items[0]["key"]
        for more in cutters
    }
    assert len(keys) == len(cutters)


def test_failures_stand_beside_results(programs, tmp_path):
    with open(programs[1], "wb") as out:
        out.write(b"G1 X[2 +\n")
    found = fleet.audit(programs[:3], ["bc-trunnion", "no-such"], results=tmp_path / "r", workers=2, **SETUP)
    assert [row["status"] for row in found.rows] == ["done", "failed", "failed", "failed", "done", "failed"]
    assert "part1.ngc:1" in found.failed[1]["message"]
    assert len(found.to_pandas()) == 6 and "<table>" in found._repr_html_()
    assert found.summaries[1] is None and found.summaries[0]["machine"] == "bc-trunnion"


def test_urls_keep_results(programs):
    pytest.importorskip("fsspec")
    place = "memory://fleet-results"
    rows = fleet.audit(programs[:2], "bc-trunnion", results=place, workers=0, **SETUP).rows
    assert fleet.audit(programs[:2], "bc-trunnion", results=place, workers=0, **SETUP).rows == rows


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
    ranked = fleet.which_machine(job_folder / "job.toml", ["no-such", "bc-trunnion"], workers=0)
    assert [row["machine"] for row in ranked] == ["bc-trunnion", "no-such"]


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


def test_an_item_that_kills_every_worker_fails_alone(programs, monkeypatch):
    monkeypatch.setattr(fleet, "_worked", always_deadly)
    found = fleet.audit(programs[:4], "bc-trunnion", workers=2, **SETUP)
    assert [row["status"] for row in found.rows] == ["done", "done", "failed", "done"]
    assert "BrokenProcessPool" in found.failed[0]["message"]
