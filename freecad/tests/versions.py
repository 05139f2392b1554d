"""What differs between versions of FreeCAD, against stand-ins with their names and signatures."""

from __future__ import annotations

import enum
import importlib
import os
import types
import unittest
import unittest.mock
from xml.etree import ElementTree

import models
import standins
import update

import FreeCAD

from trunnion_cam import compat
from trunnion_cam.problem import Problem


class Versions(unittest.TestCase):
    def test_each_generation_makes_jobs_controllers_and_bits(self):
        places = {"0.20": "PathScripts.", "1.0": "Path.", "1.1": "Path."}
        for version, place in places.items():
            with self.subTest(version), standins.generation(version) as document:
                job = compat.create_job("Job", ["Body"])
                self.assertTrue(job.made.startswith(place))
                self.assertTrue(compat.is_job(job))
                self.assertEqual(compat.models(job)[-1], "Body")
                controller = compat.create_controller("TC", 4)
                self.assertTrue(controller.made.startswith(place))
                compat.add_controller(job, controller)
                self.assertEqual([one.ToolNumber for one in compat.controllers(job)], [4])
                compat.add_operation(job, "finish")
                self.assertEqual(compat.operations(job), ["finish"])
                for shape in ("endmill", "ballend", "bullnose"):
                    self.assertEqual(compat.bit_shape(compat.create_bit(shape)), shape)
                self.assertEqual([kind for kind, _ in document.added], ["Part::FeaturePython"] * 3)

    def test_without_a_cam_workbench_words_say_so(self):
        with unittest.mock.patch.object(importlib, "import_module", side_effect=ModuleNotFoundError):
            with self.assertRaises(Problem) as found:
                compat.create_job("Job", ["Body"])
        self.assertIn("install FreeCAD with its CAM", str(found.exception))

    def test_shapes_and_corners_of_all_generations(self):
        bit = types.SimpleNamespace
        shapes_of = {
            "endmill": bit(BitShape="/usr/share/freecad/endmill.fcstd", ShapeName="endmill001"),
            "bullnose": bit(ShapeType="Bullnose", ShapeID="bullnose"),
            "torus": bit(ShapeType="Custom", ShapeID="torus"),
            "threadmill": bit(BitShape="C:\\Tools\\thread-mill.fcstd"),
            "": bit(),
        }
        for shape, one in shapes_of.items():
            self.assertEqual(compat.bit_shape(one), shape)
        self.assertEqual(compat.corner_radius(bit(FlatRadius=4.0), 12.0), 2.0)
        self.assertEqual(compat.corner_radius(bit(TorusRadius=1.5), 12.0), 1.5)
        self.assertEqual(compat.corner_radius(bit(CornerRadius=1.0, TorusRadius=1.5), 12.0), 1.0)
        self.assertIsNone(compat.corner_radius(bit(), 12.0))

    def test_operations_under_dress_ups(self):
        base = types.SimpleNamespace(ToolController="TC", Base=("Body", ["Face1"]))
        self.assertIs(compat.base_operation(types.SimpleNamespace(Base=types.SimpleNamespace(Base=base))), base)
        self.assertIs(compat.base_operation(types.SimpleNamespace(Base=[base])), base)

    def test_what_a_post_processor_is_handed(self):
        own = types.SimpleNamespace(Name="Op", Document="document")
        self.assertIs(compat.document_object(own), own)
        self.assertIs(compat.document_object(standins.Postable("operation", "Op", own)), own)
        self.assertIsNone(compat.document_object(standins.Postable("fixture", "G54", None)))
        self.assertIsNone(compat.document_object(types.SimpleNamespace(Label="G54", Path=None)))

    def test_a_script_that_fails_writes_nothing(self):
        for version in ("0.20", "1.1"):
            with standins.generation(version):
                self.assertIsNone(compat.post_processor_class("trunnion_post.py"))
        with standins.generation("1.0"):
            made = compat.post_processor_class("trunnion_post.py")
            self.assertEqual(made(["one"]).script_path, "trunnion_post.py")
            self.assertEqual(made(["one", "other"]).export(), [("one", "G0"), ("other", "G0")])
            self.assertEqual(made(["one", "broken"]).export(), [])

    def test_buttons_of_both_windows(self):
        class Old(enum.IntFlag):
            Ok, Cancel, Close = 1024, 4194304, 2097152

        class New(enum.Flag):
            Ok, Cancel, Close = 1024, 4194304, 2097152

        for flags, wanted in ((Old, 1024 | 4194304), (New, New.Ok | New.Cancel)):
            window = types.SimpleNamespace(QDialogButtonBox=flags)
            with unittest.mock.patch.object(importlib, "import_module", return_value=window):
                found = compat.standard_buttons("Ok", "Cancel")
            self.assertEqual(found, wanted)
            self.assertEqual(type(found), int if flags is Old else New)

    def test_the_package_file_is_one_that_every_version_reads(self):
        # FreeCAD 1.0 loads nothing of an add-on whose dependencies have a type that it does not know.
        path = os.path.join(models.FOLDER, "package.xml")
        package = ElementTree.parse(path)
        needed = package.findall(".//{*}depend")
        self.assertEqual([(one.get("type"), one.text) for one in needed], [("python", "trunnion")])
        self.assertEqual(FreeCAD.Metadata(path).Name, "trunnion")

    def test_nothing_else_names_what_differs(self):
        for path in update.files():
            with open(path, encoding="utf-8") as file:
                text = file.read()
            if not path.endswith("compat.py"):
                self.assertNotRegex(text, r"PathScripts|Path\.(Main|Op|Tool|Post|Base)\b|BitShape|ShapeType|int\(QtGui\.", path)
