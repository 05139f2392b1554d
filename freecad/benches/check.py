"""Check of a job whose program has 10 000 lines: time of the library alone, and of the add-on around it.

    TRUNNION_SITE=VENV/lib/python3.11/site-packages freecadcmd benches/check.py

Prints both and their difference, three times. Nothing is judged here.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests"))
import models  # noqa: E402

import Path  # noqa: E402

from trunnion_cam import checking, compat  # noqa: E402
from trunnion_cam.engine import engine  # noqa: E402

LINES = 10_000


def job_of_lines(lines: int):
    """A job whose only operation runs to and fro over a plate."""
    job, body = models.document(models.plate()[0], "ballend", 8.0)
    rows = 50
    commands = [Path.Command("G0", {"X": -20.0, "Y": -15.0, "Z": 40.0, "B": 0.0, "C": 0.0})]
    for index in range(lines - 10):
        row, place = divmod(index, lines // rows)
        share = place / (lines // rows)
        x = 20.0 * (2.0 * share - 1.0) * (1 if row % 2 == 0 else -1)
        values = {"X": x, "Y": -15.0 + 30.0 * row / rows, "Z": 8.5, "F": 20.0}
        commands.append(Path.Command("G1", values))
    commands.append(Path.Command("G0", {"Z": 40.0}))
    operation = job.Document.addObject("Path::FeaturePython", "Lines")
    operation.addProperty("App::PropertyLink", "ToolController", "Base", "")
    operation.ToolController = compat.controllers(job)[0]
    operation.Path = Path.Path(commands)
    compat.add_operation(job, operation)
    return job


def library_alone(asked) -> float:
    """Returns the time of the library on the same question [s]."""
    with tempfile.TemporaryDirectory() as folder:
        options = dict(asked.options)
        for name, content in asked.files.items():
            path = os.path.join(folder, name)
            with open(path, "wb") as file:
                file.write(content)
            options["part" if name.startswith("part") else "stock"] = path
        begun = time.perf_counter()
        engine().check(asked.program.text.encode(), **options)
        return time.perf_counter() - begun


def main() -> None:
    job = job_of_lines(LINES)
    asked = checking.question(job)
    print(f"BENCH {len(asked.program.lines)} lines")
    for _ in range(3):
        alone = library_alone(asked)
        begun = time.perf_counter()
        found = checking.check(job)
        whole = time.perf_counter() - begun
        begun = time.perf_counter()
        checking.show(job, found)
        shown = time.perf_counter() - begun
        corners = found.drawn.mesh.CountPoints
        print(f"BENCH library {alone:.2f} s, add-on {whole:.2f} s, beyond it {whole - alone:.2f} s, mesh of {corners} corners shown in {shown:.2f} s")


main()
sys.stdout.flush()
os._exit(0)
