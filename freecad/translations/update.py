#!/usr/bin/env python3
"""Collects the texts of the add-on into trunnion_*.ts, and packs the translations into the .qm files that FreeCAD reads.

    python3 translations/update.py            brings .ts and .qm up to date; new texts come without a translation
    python3 translations/update.py --check    says what is not up to date, or not translated, and ends with 1

Texts stand in calls of `translated`, `marked` (context trunnion) and `described` (context App::Property).
"""

from __future__ import annotations

import ast
import os
import re
import struct
import sys
import xml.etree.ElementTree as xml
from typing import Iterator, NamedTuple

FOLDER = os.path.dirname(os.path.abspath(__file__))
SOURCES = os.path.dirname(FOLDER)
LANGUAGES = ("de",)
#: Context in which each function looks.
CONTEXTS = {"translated": "trunnion", "marked": "trunnion", "described": "App::Property"}


class Text(NamedTuple):
    """A text in its context."""

    context: str
    source: str


def files() -> Iterator[str]:
    """Yields the sources of the add-on."""
    yield os.path.join(SOURCES, "InitGui.py")
    yield os.path.join(SOURCES, "posts", "trunnion_post.py")
    for folder, _, names in sorted(os.walk(os.path.join(SOURCES, "trunnion_cam"))):
        yield from (os.path.join(folder, name) for name in sorted(names) if name.endswith(".py"))


def texts() -> list[Text]:
    """Returns every text that can be translated, once, in order."""
    found: dict[Text, None] = {}
    for path in files():
        with open(path, encoding="utf-8") as file:
            tree = ast.parse(file.read(), path)
        for node in ast.walk(tree):
            name = getattr(getattr(node, "func", None), "id", "")
            if name in CONTEXTS and isinstance(node.args[0], ast.Constant):
                found[Text(CONTEXTS[name], node.args[0].value)] = None
    return sorted(found)


def read(path: str) -> dict[Text, str]:
    """Returns the translations of a .ts file, "" where there is none yet."""
    if not os.path.exists(path):
        return {}
    found = {}
    for context in xml.parse(path).getroot().iter("context"):
        name = context.findtext("name", "")
        for message in context.iter("message"):
            translation = message.find("translation")
            done = translation is not None and translation.get("type") != "unfinished"
            found[Text(name, message.findtext("source", ""))] = (translation.text or "") if done else ""
    return found


def ts(language: str, translations: dict[Text, str]) -> str:
    """Returns the content of a .ts file."""
    root = xml.Element("TS", version="2.1", language=language, sourcelanguage="en")
    contexts: dict[str, xml.Element] = {}
    for text, translation in translations.items():
        if text.context not in contexts:
            contexts[text.context] = xml.SubElement(root, "context")
            xml.SubElement(contexts[text.context], "name").text = text.context
        message = xml.SubElement(contexts[text.context], "message")
        xml.SubElement(message, "source").text = text.source
        translated = xml.SubElement(message, "translation")
        if translation:
            translated.text = translation
        else:
            translated.set("type", "unfinished")
    xml.indent(root, space="    ")
    return '<?xml version="1.0" encoding="utf-8"?>\n<!DOCTYPE TS>\n' + xml.tostring(root, encoding="unicode") + "\n"


def qm(translations: dict[Text, str]) -> bytes:
    """Returns the content of a .qm file: hashes of the sources, and the messages that they stand for."""
    messages, hashes = b"", []
    for text, translation in translations.items():
        if not translation:
            continue
        hashes.append((_hash(text.source.encode()), len(messages)))
        fields = ((3, translation.encode("utf-16-be")), (8, b""), (6, text.source.encode()), (7, text.context.encode()))
        messages += b"".join(struct.pack(">BI", tag, len(content)) + content for tag, content in fields) + b"\x01"
    table = b"".join(struct.pack(">II", *entry) for entry in sorted(hashes))
    blocks = ((0x42, table), (0x69, messages))
    magic = bytes.fromhex("3cb86418caef9c95cd211cbf60a1bddd")
    return magic + b"".join(struct.pack(">BI", tag, len(content)) + content for tag, content in blocks)


def _hash(source: bytes) -> int:
    """Returns the ELF hash, by which Qt finds a source."""
    value = 0
    for byte in source:
        value = (value << 4) + byte
        high = value & 0xF0000000
        value = (value ^ (high >> 24)) & ~high if high else value
    return value & 0xFFFFFFFF or 1


def faults(translations: dict[Text, str]) -> list[str]:
    """Returns what is wrong: texts without a translation, and places for values that differ."""
    found = []
    for text, translation in translations.items():
        if not translation:
            found.append(f"not translated: {text.source}")
        elif sorted(re.findall(r"\{\w*\}", text.source)) != sorted(re.findall(r"\{\w*\}", translation)):
            found.append(f"other values than in the source: {translation}")
    return found


def main() -> int:
    """Brings all languages up to date, or checks them."""
    check = "--check" in sys.argv[1:]
    status = 0
    for language in LANGUAGES:
        path = os.path.join(FOLDER, f"trunnion_{language}.ts")
        known = read(path)
        translations = {text: known.get(text, "") for text in texts()}
        contents = {path: ts(language, translations).encode(), path[:-3] + ".qm": qm(translations)}
        for name, content in contents.items():
            before = open(name, "rb").read() if os.path.exists(name) else b""
            if before != content and check:
                print(f"{name} is not up to date: run translations/update.py")
                status = 1
            elif before != content:
                with open(name, "wb") as file:
                    file.write(content)
        for fault in faults(translations):
            print(f"{language}: {fault}")
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main())
