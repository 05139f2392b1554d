"""Every text that a user sees is translated."""

from __future__ import annotations

import os
import unittest

import models  # noqa: F401
import texts
import update
from PySide import QtCore


class Texts(unittest.TestCase):
    def test_no_text_passes_by(self):
        self.assertEqual(texts.strays(), [])
        stray = {
            "label.setText('Hello')": "Hello",
            "row = QLabel(f'{x} done')": " done",
            "a = 'two words'": "two words",
            "obj.Label = 'Thing'": "Thing",
            "raise Problem(translated('fine'), 'bad')": "bad",
            "form.setWindowTitle('a' if b else translated('c'))": "a",
        }
        for source, word in stray.items():
            self.assertEqual(texts.strays({"a.py": source}), [f"a.py:1: {word!r}"])
        for source in ("label.setText(translated('Hello'))", "QLabel(f'{a}: {b}')", "print('x')", "'A docstring of words.'"):
            self.assertEqual(texts.strays({"a.py": source}), [])

    def test_translations_are_whole_and_up_to_date(self):
        for language in update.LANGUAGES:
            path = os.path.join(update.FOLDER, f"trunnion_{language}.ts")
            known = update.read(path)
            self.assertEqual(set(known), set(update.texts()))
            self.assertEqual(update.faults(known), [])
            with open(path[:-3] + ".qm", "rb") as file:
                self.assertEqual(file.read(), update.qm({text: known[text] for text in update.texts()}))
        wrong = {update.Text("trunnion", "{a} is"): "{b} ist", update.Text("trunnion", "more"): ""}
        self.assertEqual(len(update.faults(wrong)), 2)

    def test_qt_reads_them(self):
        translator = QtCore.QTranslator()
        self.assertTrue(translator.load(os.path.join(update.FOLDER, "trunnion_de.qm")))
        known = update.read(os.path.join(update.FOLDER, "trunnion_de.ts"))
        self.assertGreater(len(known), 200)
        for text, translation in known.items():
            self.assertEqual(translator.translate(text.context, text.source), translation)
