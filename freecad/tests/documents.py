"""Tests that leave no document behind."""

from __future__ import annotations

import unittest

import models  # noqa: F401  (makes the add-on known)

import FreeCAD

from trunnion_cam.problem import Problem


class DocumentTest(unittest.TestCase):
    def tearDown(self):
        for name in list(FreeCAD.listDocuments()):
            FreeCAD.closeDocument(name)

    def refused(self, call, *words):
        with self.assertRaises(Problem) as found:
            call()
        for word in words:
            self.assertIn(word, str(found.exception))
