"""Which texts of the sources a user sees, and which of them are not translated."""

from __future__ import annotations

import ast
import os
import re
import sys
from typing import Iterator

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "translations"))
import update  # noqa: E402

#: Calls and attributes whose texts are shown.
_SHOWN = {
    "QLabel", "QPushButton", "QCheckBox", "QListWidgetItem", "QTableWidgetItem", "setText", "setWindowTitle", "setToolTip", "setHorizontalHeaderLabels",
    "addRow", "addTab", "addItem", "addItems", "getItem", "getOpenFileName", "getSaveFileName", "warning", "information", "Problem",
    "PrintError", "PrintMessage", "PrintWarning", "openTransaction", "appendToolbar", "appendMenu", "Running", "_words", "_form",
}
_SHOWN_NAMES = {"Label", "MenuText", "ToolTip", "Verdict", "error", "TOOLTIP", "TOOLTIP_ARGS"}
#: The name of the add-on, and marks that are the same in all languages.
_SAME = re.compile(r"^(trunnion(: )?|<b>|</b>|X|Y|Z|[^A-Za-z]*| \(\*\.toml \*\.fcm\))$")
#: Texts of several words that no user sees: programs, keys of job files, types.
_UNSEEN = re.compile(
    r"^(G21 G90 .*|T| M6|machining centre|&nbsp;.*|Gui::InputField|Two side|<span style=.*|#.*|fixed-tilt|one-way|"
    r"User parameter:.*|mm\n|rm|\^.*|\\b.*|\\\(.*|.*\\b.*)$"
)


def strays(sources: dict[str, str] | None = None) -> list[str]:
    """Returns texts that pass by the translation, with file and line; `sources` are texts of files in place of the add-on's."""
    found = []
    for path in update.files() if sources is None else sources:
        if sources is None:
            with open(path, encoding="utf-8") as file:
                text = file.read()
        else:
            text = sources[path]
        tree = ast.parse(text)
        for line, words in [*_shown(tree), *_sentences(tree)]:
            found.append(f"{os.path.basename(path)}:{line}: {words!r}")
    return sorted(set(found))


def _name(node: ast.AST) -> str:
    return getattr(node, "id", "") or getattr(node, "attr", "")


def _literals(node: ast.AST) -> Iterator[tuple[int, str]]:
    """Yields the texts within an expression that are not in calls of the translation, nor keys and comparisons."""
    if isinstance(node, ast.Call) and _name(node.func) in update.CONTEXTS:
        return
    if isinstance(node, ast.Call):
        # What a call takes is its own affair, unless it joins texts.
        children = node.args if _name(node.func) in ("join", "format") else []
    elif isinstance(node, (ast.Subscript, ast.Compare, ast.Lambda)):
        children = []
    elif isinstance(node, ast.FormattedValue):
        children = [node.value]
    elif isinstance(node, ast.IfExp):
        children = [node.body, node.orelse]
    else:
        children = list(ast.iter_child_nodes(node))
    if isinstance(node, ast.Constant) and isinstance(node.value, str) and not _SAME.match(node.value.strip("\n")):
        yield node.lineno, node.value
    for child in children:
        yield from _literals(child)


def _shown(tree: ast.AST) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and _name(node.func) in _SHOWN:
            for argument in node.args:
                if not (isinstance(argument, ast.Constant) and str(argument.value).startswith("Gui::")):
                    yield from (one for one in _literals(argument) if not _UNSEEN.match(one[1]))
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if any(_name(target) in _SHOWN_NAMES for target in targets) and node.value is not None:
                yield from _literals(node.value)


def _sentences(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yields texts of at least two words, wherever they stand."""
    skipped: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and _name(node.func) in update.CONTEXTS:
            skipped.update(id(one) for one in ast.walk(node))
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            # A docstring.
            skipped.add(id(node.value))
    for node in ast.walk(tree):
        if id(node) in skipped or not isinstance(node, ast.Constant) or not isinstance(node.value, str):
            continue
        if re.search(r"[A-Za-z]{2,} +[A-Za-z]", node.value) and not _UNSEEN.match(node.value):
            yield node.lineno, node.value
