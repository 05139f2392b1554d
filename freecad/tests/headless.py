"""From models to programs and checks, without a window. Run: freecadcmd tests/headless.py"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import models  # noqa: E402
from documents import DocumentTest  # noqa: E402
import texts  # noqa: E402, F401  (makes translations/update.py known)
import language  # noqa: E402
import results  # noqa: E402
import versions  # noqa: E402

import FreeCAD  # noqa: E402
import Part  # noqa: E402

from trunnion_cam import checking, compat, machines, operation, postprocessor, posting, searching, shapes, tools  # noqa: E402
from trunnion_cam.engine import engine  # noqa: E402
from trunnion_cam.problem import Problem  # noqa: E402


class Base(DocumentTest):
    def finish(self, part, tool="ballend", diameter=8.0, **settings):
        shape, faces = part
        job, body = models.document(shape, tool, diameter)
        obj = operation.create(job, body, faces)
        obj.Along = "v"
        for name, value in settings.items():
            setattr(obj, name, value)
        job.Document.recompute()
        return job, obj


class Parts(Base):
    """Model, program, check: three parts."""

    def test_bump(self):
        self.follow(models.bump())

    def test_dome(self):
        self.follow(models.dome(), Method="ball")

    def test_plate(self):
        self.follow(models.plate(), tool="endmill", diameter=12.0)

    def follow(self, part, **settings):
        job, obj = self.finish(part, **settings)
        self.assertTrue(obj.Kept, obj.Verdict)
        names = {command.Name for command in obj.Path.Commands}
        self.assertTrue({"G0", "G1", "M6", "M3", "G43"} <= names, names)
        self.assertGreater(float(obj.Duration), 1.0)
        self.assertEqual(len(obj.Pictures), 2)
        found = checking.check(job)
        self.assertTrue(found.passed, [one.text for one in found.problems])
        # A block that cuts deeper is found, at its own command.
        commands = obj.Path.Commands
        cuts = [index for index, one in enumerate(commands) if one.Name == "G1" and "Z" in one.Parameters]
        middle = cuts[len(cuts) // 2]
        values = dict(commands[middle].Parameters)
        values["Z"] -= 0.4
        import Path

        commands[middle] = Path.Command("G1", values)
        obj.Path = Path.Path(commands)
        broken = checking.check(job)
        self.assertFalse(broken.passed)
        places = {one.place.command for one in broken.problems if one.place}
        self.assertTrue(places & set(range(middle - 2, middle + 3)), (middle, places))
        self.assertTrue(all(one.place.operation == obj.Name for one in broken.problems if one.place))


def run(job, output):
    """Runs a job by the command line where that is installed, and by the package elsewhere."""
    command = shutil.which("trunnion")
    if command is None:
        print("the command trunnion is not here: the package runs in its place")
        engine().run(job, output=output)
        return
    done = subprocess.run([command, "run", job, "-o", output], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


class Operation(Base):
    def test_the_program_is_that_of_the_command_line(self):
        job, obj = self.finish(models.plate(), tool="endmill", diameter=12.0, Dialects=["heidenhain"])
        obj.InputKey, kept = "", dict(obj.Programs)
        with tempfile.TemporaryDirectory() as folder:
            operation.write_job(operation.inputs(obj), folder)
            run(os.path.join(folder, "job.toml"), os.path.join(folder, "out"))
            for name, text in kept.items():
                with open(os.path.join(folder, "out", name), encoding="utf-8", newline="") as file:
                    self.assertEqual(file.read(), text, name)
        self.assertEqual(set(kept), {"program.linuxcnc.ngc", "program.heidenhain.h"})

    def test_it_is_computed_when_something_changes_and_only_then(self):
        job, obj = self.finish(models.plate(), tool="endmill", diameter=12.0)
        calls = []
        compute = operation.compute
        operation.compute = lambda *args, **more: calls.append(1) or compute(*args, **more)
        try:
            obj.touch()
            job.Document.recompute()
            self.assertEqual(calls, [])
            obj.Excess = 0.03
            job.Document.recompute()
            self.assertEqual(calls, [1])
            obj.Base[0].Shape = Part.makeBox(42.0, 30.0, 8.0, FreeCAD.Vector(-20, -15, 0))
            job.Document.recompute()
            self.assertEqual(calls, [1, 1])
            self.assertTrue(obj.Kept and obj.ViewObject is None)
        finally:
            operation.compute = compute

    def test_save_and_open_keep_everything(self):
        job, obj = self.finish(models.plate(), tool="endmill", diameter=12.0)
        key, count = obj.InputKey, len(obj.Path.Commands)
        text = obj.Path.toGCode()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "job.FCStd")
            job.Document.saveAs(path)
            FreeCAD.closeDocument(job.Document.Name)
            doc = FreeCAD.openDocument(path)
            again = doc.getObject("FiveAxisFinish")
            self.assertEqual(again.Path.toGCode(), text)
            self.assertEqual((again.InputKey, len(again.Path.Commands), again.Kept), (key, count, True))
            self.assertIsInstance(again.Proxy, operation.FiveAxisFinish)
            self.assertEqual(len(again.Programs["program.linuxcnc.ngc"]) > 100, True)
            again.touch()
            doc.recompute()
            self.assertEqual(again.InputKey, key)

    def test_a_job_of_another_generation_is_checked_and_posted_and_gets_words(self):
        job, obj = self.finish(models.plate(), tool="endmill", diameter=12.0)
        body, faces = obj.Base
        # FreeCAD finds the module of the proxy no more.
        job.Proxy = None
        count = len(job.Document.Objects)
        self.assertTrue(checking.check(job).passed)
        self.assertEqual(posting.post(job, "linuxcnc"), obj.Programs["program.linuxcnc.ngc"])
        self.assertEqual(compat.models(job), job.Model.Group)
        self.refused(lambda: operation.create(job, body, faces), "another version of FreeCAD", "help:", "new job")
        self.assertEqual(len(job.Document.Objects), count)

    def test_what_is_older_is_planned_by_the_recompute_that_is_asked_for(self):
        job, obj = self.finish(models.plate(), tool="endmill", diameter=12.0)
        # As a machine file that was edited, or another version of FreeCAD, leaves it: nothing is marked.
        obj.InputKey = "of before"
        obj.purgeTouched()
        self.refused(lambda: posting.post(job, "linuxcnc"), "older than the model", "recompute")
        job.Document.recompute()
        self.assertEqual(obj.InputKey, operation.key(obj))
        self.assertEqual(posting.post(job, "linuxcnc"), obj.Programs["program.linuxcnc.ngc"])

    def test_undo_takes_the_operation_away(self):
        shape, faces = models.plate()
        job, body = models.document(shape, "endmill", 12.0)
        job.Document.UndoMode = 1
        job.Document.openTransaction("finish")
        name = operation.create(job, body, faces).Name
        job.Document.commitTransaction()
        job.Document.undo()
        self.assertIsNone(job.Document.getObject(name))
        self.assertEqual([one.Name for one in compat.operations(job)], [])


class Words(Base):
    """What cannot work is said in words, and the document stays whole."""

    def test_selections(self):
        doc = FreeCAD.newDocument("words")
        box, other = doc.addObject("Part::Box", "A"), doc.addObject("Part::Box", "B")
        mesh, sketch = doc.addObject("Mesh::Feature", "M"), doc.addObject("Sketcher::SketchObject", "S")
        doc.recompute()
        self.refused(lambda: shapes.selected_faces([]), "nothing is selected", "help:")
        self.refused(lambda: shapes.selected_faces([(mesh, [])]), "M is a mesh")
        self.refused(lambda: shapes.selected_faces([(sketch, ["Edge1"])]), "S is a sketch")
        self.refused(lambda: shapes.selected_faces([(box, ["Face1"]), (other, ["Face1"])]), "2 bodies", "A, B")
        self.refused(lambda: shapes.selected_faces([(box, ["Edge1"])]), "no face is selected, but Edge1")
        self.assertEqual(shapes.selected_faces([(box, ["Face2", "Face1"])])[1], ["Face2", "Face1"])

    def test_a_model_that_changed_under_an_operation(self):
        job, obj = self.finish(models.plate(), tool="endmill", diameter=12.0)
        self.assertTrue(obj.Path.Commands)
        obj.Base[0].Shape = Part.makeSphere(5.0)
        job.Document.recompute()
        self.assertEqual(len(obj.Path.Commands), 0)
        self.assertIn("no face of the part, which has 1", obj.Verdict)
        self.assertFalse(obj.Kept)
        obj.Base[0].Shape = models.plate()[0]
        job.Document.recompute()
        self.assertTrue(obj.Kept, obj.Verdict)

    def test_tools_and_machines(self):
        job, obj = self.finish(models.plate(), tool="endmill", diameter=12.0)
        obj.ToolController.Tool = compat.create_bit("drill")
        job.Document.recompute()
        self.assertIn("tools of the shape drill are not placed", obj.Verdict)
        self.assertIn("ballend", obj.Verdict)
        self.refused(lambda: machines.load("no-such-machine"), "no-such-machine", "bc-trunnion")
        obj.ToolController.Tool = compat.create_bit("endmill")
        machines.machine_of(job).Origin = FreeCAD.Vector(0, 0, 400)
        job.Document.recompute()
        self.assertFalse(obj.Kept)
        self.assertIn("travel", obj.Verdict)
        self.assertEqual(len(obj.Path.Commands), 0)

    def test_a_bull_nose_has_its_corner(self):
        job, _ = models.document(models.plate()[0], "bullnose", 12.0)
        controller = compat.controllers(job)[0]
        table = tools.tool_table(controller, 90.0)
        self.assertEqual(table["kind"], "bull")
        self.assertTrue(0 < table["corner_radius"] < 6.0)


class Programs(Base):
    def test_other_operations_are_checked_too(self):
        shape, _ = models.plate()
        job, body = models.document(shape, "endmill", 12.0)
        import Path

        custom = job.Document.addObject("Path::FeaturePython", "Custom")
        custom.addProperty("App::PropertyLink", "ToolController", "Base", "")
        custom.addProperty("App::PropertyBool", "Active", "Base", "")
        custom.ToolController, custom.Active = compat.controllers(job)[0], True
        moves = [("G0", {"X": -30.0, "Y": 0.0, "Z": 30.0}), ("G0", {"Z": 8.0}), ("G1", {"X": 30.0, "F": 10.0}), ("G0", {"Z": 30.0})]
        custom.Path = Path.Path([Path.Command(name, values) for name, values in moves])
        compat.add_operation(job, custom)
        found = checking.check(job)
        self.assertTrue(found.passed, [one.text for one in found.problems])
        self.assertIn("G1 X30 F600", found.program.text)
        moves[1] = ("G0", {"Z": 6.5})
        custom.Path = Path.Path([Path.Command(name, values) for name, values in moves])
        broken = checking.check(job)
        self.assertFalse(broken.passed)
        self.assertTrue(any("gouge" in one.text and one.place and one.place.operation == "Custom" for one in broken.problems), broken.problems)
        self.assertIn("TX", posting.post(job, "heidenhain") + "TX")
        self.assertIn("L ", posting.post(job, "heidenhain"))

    def test_operations_of_freecad_are_checked_and_posted(self):
        shape, (floor, hole) = models.pocketed()
        job, _ = models.document(shape, "endmill", 6.0)
        profile, drilling = models.ordinary(job, "Profile", []), models.ordinary(job, "Drilling", [hole])
        # FreeCAD states the offset of a centre across the plane, too.
        arcs = [one for one in profile.Path.Commands if one.Name in ("G2", "G3")]
        self.assertTrue(arcs and all("K" in one.Parameters for one in arcs))
        found = checking.check(job)
        self.assertTrue(found.passed, [one.text for one in found.problems])
        self.assertEqual({one.operation for one in found.program.places if one}, {profile.Name, drilling.Name})
        self.assertRegex(found.program.text, r"\nG[23] X.* I.* J")
        self.assertRegex(found.program.text, r"\nG81 ")
        self.assertIn("TOOL CALL 1 Z", posting.post(job, "heidenhain"))
        # What a pocket gouges is a finding with its line, whatever this version makes of the pocket.
        pocket = models.ordinary(job, "PocketShape", [floor])
        profile.Active = drilling.Active = False
        self.assertTrue(all(one.place.operation == pocket.Name for one in checking.check(job).problems))
        self.assertTrue(posting.post(job, "siemens"))

    def test_arcs_keep_what_counts_in_their_plane(self):
        import Path

        job, _ = models.document(models.plate()[0], "endmill", 12.0)
        custom = job.Document.addObject("Path::FeaturePython", "Custom")
        custom.addProperty("App::PropertyLink", "ToolController", "Base", "")
        custom.ToolController = compat.controllers(job)[0]
        arc = {"X": 10.0, "Y": 0.0, "Z": 30.0, "I": 5.0, "J": 0.0, "K": 0.0}
        planes = [Path.Command(name) for name in ("G17", "G18", "G19")]
        custom.Path = Path.Path([one for plane in planes for one in (plane, Path.Command("G2", arc))])
        compat.add_operation(job, custom)
        arcs = [line.split()[4:] for line in checking.question(job).program.lines if line.startswith("G2 ")]
        self.assertEqual(arcs, [["I5", "J0"], ["I5", "K0"], ["I5", "J0", "K0"]])

    def test_fixtures_are_kept_off(self):
        job, obj = self.finish(models.plate(), tool="endmill", diameter=12.0)
        clamp = job.Document.addObject("Part::Feature", "Clamp")
        clamp.Shape = Part.makeBox(10.0, 10.0, 14.0, FreeCAD.Vector(-21, -5, 0))
        before = checking.check(job)
        self.assertTrue(before.passed)
        machines.machine_of(job).Fixtures = [clamp]
        found = checking.check(job)
        self.assertFalse(found.passed)
        self.assertTrue(any("fixture" in one.text for one in found.problems), [one.text for one in found.problems])
        # Planned anew, the passes keep off; what the clamp covers is left.
        job.Document.recompute()
        obj.touch()
        job.Document.recompute()
        self.assertNotIn("runs into", obj.Verdict)

    def test_the_post_processor_of_freecad(self):
        job, obj = self.finish(models.plate(), tool="endmill", diameter=12.0)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "part.ngc")
            text = postprocessor.export([obj], path, "")
            with open(path, encoding="utf-8") as file:
                self.assertEqual(file.read(), text)
            self.assertEqual(text, obj.Programs["program.linuxcnc.ngc"])
            with self.assertRaises(Problem):
                postprocessor.export([obj], "-", "--no-such=1")
            installed = posting.install_post_processor(folder)
            self.assertTrue(installed.endswith("trunnion_post.py"))

    def test_a_machine_of_freecad(self):
        data, remarks = machines.convert_fcm(models.fcm(), machines.CLASSES["hobby"])
        self.assertEqual(data["chain"], ["w", "C", "A", "b", "X", "Y", "Z", "t"])
        self.assertEqual(data["axis"]["C"]["vel"], 120.0)
        self.assertTrue(any("jog" in remark for remark in remarks))
        machine = engine().Machine(data)
        tip, axis = machine.forward([0, 0, 0, 0, 90], deg=True)
        self.assertAlmostEqual(abs(axis[1]), 1.0)
        with self.assertRaises(Problem):
            machines.convert_fcm("[1]", machines.CLASSES["hobby"])
        axes = json.loads(models.fcm())["machine"]["axes"]
        del axes["C"]
        with self.assertRaises(Problem):
            machines.convert_fcm(json.dumps({"machine": {"axes": axes}}), machines.CLASSES["hobby"])

    def test_setup_and_origin(self):
        job, obj = self.finish(models.dome(), Method="ball")
        obj.InputKey = ""
        summary = searching.best_setup(operation.inputs(obj))
        self.assertIn("before", summary)
        for machine in ("ac-trunnion", "bc-trunnion", "gantry-ca-fork"):
            self.assertEqual(searching.quick_origin(job, machine), searching.usual_origin(job, machine))

    def test_two_diameters_are_compared(self):
        _, obj = self.finish(models.bump(), Method="ball")
        obj.InputKey = ""
        stages = []
        over = {"tool.diameter": [6.0, 8.0]}
        rows = searching.compare(operation.inputs(obj), over, lambda stage, done, total: stages.append(stage))
        self.assertEqual([(row["tool.diameter"], row["status"], row["passed"]) for row in rows], [(6.0, "done", True), (8.0, "done", True)])
        self.assertGreater(rows[0]["cutting_length"], rows[1]["cutting_length"])
        self.assertGreater(len(set(stages)), 2)

    def test_the_page_of_a_simulation_has_the_program(self):
        _, obj = self.finish(models.bump(), Method="ball")
        obj.InputKey = ""
        with tempfile.TemporaryDirectory() as folder:
            with open(searching.simulate(operation.inputs(obj), folder), encoding="utf-8") as page:
                text = page.read()
        self.assertGreater(len(text), 500_000)
        self.assertIn("</html>", text)


if __name__ in ("__main__", "headless"):
    modules = (sys.modules[__name__], language, results, versions)
    suite = unittest.TestSuite(unittest.defaultTestLoader.loadTestsFromModule(module) for module in modules)
    wanted = os.environ.get("TRUNNION_ONLY")
    if wanted:
        suite = unittest.TestSuite(one for module in suite for case in module for one in case if wanted in one.id())
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    # FreeCAD ends with 0 whatever a script says: the last line is the verdict.
    print("ALL PASSED" if result.wasSuccessful() and result.testsRun else "FAILED")
    sys.stdout.flush()
    os._exit(0 if result.wasSuccessful() else 1)
