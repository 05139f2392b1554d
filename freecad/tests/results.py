"""Coloured meshes, jobs of several tools, several jobs in a document."""

from __future__ import annotations

import math

import models
import numpy as np
import standins
from documents import DocumentTest

import FreeCAD
import Part

from trunnion_cam import checking, compat, deviation, machines, operation, postprocessor, posting, units


class Base(DocumentTest):
    def plate(self):
        """A plate whose top is finished."""
        shape, faces = models.plate()
        job, body = models.document(shape, "endmill", 12.0)
        obj = operation.create(job, body, faces)
        obj.Along = "v"
        job.Document.recompute()
        return job, obj


class Deviations(Base):
    def test_a_finish_comes_with_a_coloured_mesh(self):
        _, obj = self.plate()
        mesh = obj.Pictures[1]
        self.assertTrue(mesh.isDerivedFrom("Mesh::Feature"))
        self.assertEqual(len(mesh.Height), mesh.Mesh.CountPoints)
        self.assertEqual(len(mesh.Colours), mesh.Mesh.CountPoints)
        self.assertAlmostEqual(mesh.Mesh.Area, 1200.0, delta=0.1)
        self.assertLess(max(map(abs, mesh.Height)), float(obj.Excess.Value))
        corners, _ = mesh.Mesh.Topology
        self.assertTrue(all(abs(corner.z - 8.0) < 1e-6 for corner in corners))

    def test_a_check_comes_with_one_and_the_next_replaces_it(self):
        job, obj = self.plate()
        found = checking.check(job)
        first = checking.show(job, found)
        self.assertAlmostEqual(first.Mesh.Area, obj.Base[0].Shape.Area, delta=1.0)
        # The top is cut, the bottom is not.
        corners = zip(first.Mesh.Topology[0], first.Height)
        cut = {round(at.z): math.isfinite(height) for at, height in corners if abs(at.x) < 10 and abs(at.y) < 10}
        self.assertEqual(cut, {8: True, 0: False})
        count = len(job.Document.Objects)
        checking.show(job, found)
        self.assertEqual(len(job.Document.Objects), count)

    def test_pictures_are_replaced_and_go_with_the_result(self):
        job, obj = self.plate()
        count = len(job.Document.Objects)
        obj.Excess = 0.03
        job.Document.recompute()
        self.assertEqual(len(job.Document.Objects), count)
        obj.Base[0].Shape = Part.makeSphere(5.0)
        job.Document.recompute()
        self.assertEqual((obj.Pictures, obj.SetupSheet, dict(obj.Programs)), ([], "", {}))

    def test_no_measured_point_is_lost_and_neighbours_share_their_edges(self):
        plate = Part.makePlane(30.0, 20.0)
        x, y = np.meshgrid(np.linspace(0, 30, 151), np.linspace(0, 20, 101))
        points = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
        heights = np.full(len(points), 0.001)
        heights[7777], heights[4444], heights[: 5 * 151] = 0.5, -0.3, np.nan
        found = deviation.of_shape(plate, deviation.Measured(points, heights), 0.02, 0.002)
        self.assertEqual((np.nanmax(found.heights), np.nanmin(found.heights)), (0.5, -0.3))
        worst = found.corners[np.nanargmax(found.heights)]
        self.assertLess(np.linalg.norm(worst - points[7777]), 0.5)
        at = np.argmin(np.linalg.norm(found.corners - [15.0, 0, 0], axis=1))
        self.assertTrue(np.isnan(found.heights[at]))
        self.assertFalse(np.isinf(found.heights).any())
        edges = np.sort(np.concatenate([found.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
        _, uses = np.unique(edges, axis=0, return_counts=True)
        self.assertEqual(((uses == 1) | (uses == 2)).sum(), len(uses))
        # Euler's formula for a disc: no crack within.
        self.assertEqual(len(found.corners) - len(uses) + len(found.triangles), 1)
        # Where nothing was measured, a corner says so.
        half = points[:, 0] < 12.0
        found = deviation.of_shape(plate, deviation.Measured(points[half], heights[half]), 0.02, 0.002)
        self.assertTrue(np.isinf(found.heights[found.corners[:, 0] > 16.0]).all())

    def test_the_nearest_of_others_is_that_of_brute_force(self):
        random = np.random.default_rng(7)
        points, others = random.random((200, 3)), random.random((900, 3))
        distances = np.linalg.norm(points[:, None] - others[None], axis=2)
        self.assertEqual(deviation.nearest(points, others, 0.25).tolist(), distances.argmin(axis=1).tolist())


class Tools(Base):
    #: First words of a change to tools 1 and 7 in each dialect.
    CHANGES = {
        "linuxcnc": "T{} M6", "g93": "T{} M6", "fanuc": "T{} M6", "fanuc-vector": "T{} M6", "haas": "T{} M6", "siemens": "T={} D1",
        "siemens-axes": "T={} D1", "heidenhain": "TOOL CALL {} Z", "heidenhain-axes": "TOOL CALL {} Z", "apt": "LOADTL/{}",
    }

    def two(self):
        """A block that is finished on top with a flat end mill, and on a slope with a ball end mill."""
        shape, (top, slope) = models.wedge()
        job, body = models.document(shape, "endmill", 12.0)
        first = operation.create(job, body, [top])
        controller = compat.create_controller("TC: ball", 7)
        compat.add_controller(job, controller)
        controller.Tool = compat.create_bit("ballend")
        controller.Tool.Diameter = 8.0
        controller.HorizFeed, controller.SpindleSpeed = 40.0, 9000.0
        second = operation.create(job, body, [slope], controller)
        second.ToolLength, second.Excess = 80.0, 0.05
        job.Document.recompute()
        return job, first, second

    def test_one_tool_finishes_and_another_the_rest(self):
        job, first, second = self.two()
        self.assertTrue(first.Kept and second.Kept, (first.Verdict, second.Verdict))
        found = checking.check(job)
        self.assertTrue(found.passed, [one.text for one in found.problems])
        self.assertEqual(set(found.program.tools), {1, 7})
        self.assertEqual(set(self.CHANGES), set(posting.DIALECTS))
        programs = {dialect: posting.post(job, dialect) for dialect in self.CHANGES}
        for dialect, text in programs.items():
            one, other = (self.CHANGES[dialect].format(number) for number in (1, 7))
            self.assertEqual((text.count(one), text.count(other)), (1, 1), dialect)
            self.assertLess(text.index(one), text.index(other), dialect)
            self.assertIn("6000", text[text.index(one) : text.index(other)], dialect)
            self.assertIn("9000", text[text.index(other) :], dialect)
        # What is posted is kept as well.
        asked = checking.question(job)
        posted = type(asked.program)(programs["linuxcnc"].splitlines(), [], asked.program.tools)
        again = checking.answer(asked._replace(program=posted))
        self.assertTrue(again.passed, [one.text for one in again.problems])
        # A part of the job alone, as FreeCAD hands it over where each tool has a file of its own.
        handed = [standins.Postable("fixture", "G54", None), standins.Postable("operation", "x", second)]
        self.assertEqual(postprocessor.export(handed, "-", ""), second.Programs["program.linuxcnc.ngc"])

    def test_what_cannot_be_one_program_is_said(self):
        job, first, second = self.two()
        second.ToolController.ToolNumber = 1
        self.refused(lambda: checking.question(job), "different tools with the number 1")
        second.ToolController.Tool = first.ToolController.Tool
        self.refused(lambda: checking.question(job), "lengths 50.0 and 80.0 mm")
        second.ToolController.ToolNumber = 7
        # An operation without a program is not left out in silence.
        second.Base = (second.Base[0], ["Face99"])
        job.Document.recompute()
        self.assertFalse(second.Path.Commands)
        self.refused(lambda: checking.question(job), "has no program", "Face99")
        self.refused(lambda: posting.post(job, "fanuc"), "has no program", "Face99")
        second.Active = False
        self.assertEqual(posting.post(job, "linuxcnc"), first.Programs["program.linuxcnc.ngc"])
        # Nor is a program posted that is older than the model.
        first.Base[0].Shape = Part.makeBox(42.0, 30.0, 8.0)
        self.refused(lambda: posting.post(job, "linuxcnc"), "older than the model")

    def test_another_speed_of_the_same_tool_needs_no_change(self):
        import Path

        job, _ = models.document(models.plate()[0], "endmill", 12.0)
        slow = compat.controllers(job)[0]
        fast = compat.create_controller("TC: fast", int(slow.ToolNumber))
        compat.add_controller(job, fast)
        fast.Tool, fast.SpindleSpeed = slow.Tool, 12000.0
        for controller in (slow, fast):
            custom = job.Document.addObject("Path::FeaturePython", "Custom")
            custom.addProperty("App::PropertyLink", "ToolController", "Base", "")
            custom.ToolController = controller
            custom.Path = Path.Path([Path.Command("G0", {"X": 0.0, "Y": 0.0, "Z": 30.0}), Path.Command("G1", {"X": 10.0, "F": 10.0})])
            compat.add_operation(job, custom)
        text = checking.question(job).program.text
        self.assertEqual(text.count("M6"), 1)
        self.assertIn("S12000 M3", text)


class Jobs(Base):
    def test_each_job_has_its_machine_and_its_operations(self):
        job, body = models.document(models.plate()[0], "endmill", 12.0)
        other_body = job.Document.addObject("Part::Feature", "Other")
        other_body.Shape = models.dome()[0]
        other = compat.create_job("Job2", [other_body])
        machines.create(other, "ac-trunnion")
        self.assertEqual([machines.machine_of(one).Machine for one in (job, other)], ["bc-trunnion", "ac-trunnion"])
        self.assertIn(body, compat.models(job))
        self.assertNotIn(body, compat.models(other))
        first = operation.create(job, body, models.plate()[1])
        self.assertEqual((compat.operations(job), compat.operations(other)), ([first], []))
        self.assertEqual(first.Machine, machines.machine_of(job))

    def test_a_machine_or_a_fixture_that_changes_plans_anew(self):
        job, obj = self.plate()
        key, machine = obj.InputKey, machines.machine_of(job)
        machine.Origin = machine.Origin + FreeCAD.Vector(1, 0, 0)
        job.Document.recompute()
        self.assertNotEqual(obj.InputKey, key)
        clamp = job.Document.addObject("Part::Box", "Clamp")
        clamp.Placement.Base = FreeCAD.Vector(-60, 0, 0)
        machine.Fixtures = [clamp]
        job.Document.recompute()
        key = obj.InputKey
        clamp.Placement.Base = FreeCAD.Vector(-61, 0, 0)
        job.Document.recompute()
        self.assertNotEqual(obj.InputKey, key)
        self.assertTrue(obj.Kept, obj.Verdict)

    def test_searches_leave_the_result_as_it_is(self):
        _, obj = self.plate()
        key = obj.InputKey
        self.assertTrue(operation.inputs(obj).step)
        self.assertEqual(obj.InputKey, key)

    def test_texts_of_lengths_and_feeds_read_back_in_all_units(self):
        schema = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Units").GetInt("UserSchema", 0)
        try:
            for one in range(len(FreeCAD.Units.listSchemas())):
                FreeCAD.Units.setSchema(one)
                for value in (0.002, 0.02, 12.7, -381.0, 0.0, 0.0005):
                    back = float(FreeCAD.Units.Quantity(units.length_text(value)).getValueAs("mm"))
                    self.assertAlmostEqual(back, value, delta=1e-5 * abs(value), msg=(one, units.length_text(value)))
                self.assertAlmostEqual(float(FreeCAD.Units.Quantity(units.feed_text(1200.0)).getValueAs("mm/min")), 1200.0, places=2)
            FreeCAD.Units.setSchema(3)
            self.assertEqual((units.length_text(25.4), units.feed_text(254.0)), ("1 in", "10 in/min"))
            FreeCAD.Units.setSchema(6)
            self.assertEqual((units.length_text(0.002), units.feed_text(254.0)), ("0.002 mm", "254 mm/min"))
        finally:
            FreeCAD.Units.setSchema(schema)

    def test_nothing_depends_on_the_units_of_the_user(self):
        schema = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Units").GetInt("UserSchema", 0)
        _, obj = self.plate()
        millimetres = operation.inputs(obj)
        try:
            # Inches.
            FreeCAD.Units.setSchema(3)
            self.assertEqual(operation.inputs(obj).job, millimetres.job)
            self.assertEqual(operation.key(obj), obj.InputKey)
        finally:
            FreeCAD.Units.setSchema(schema)
