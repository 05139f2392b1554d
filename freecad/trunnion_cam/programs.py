"""Programs as commands of FreeCAD paths, and paths as programs with the place of every line."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any, Iterator, NamedTuple

from . import compat
from .problem import Problem
from .translate import translated

_WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))")
_COMMENT = re.compile(r"\([^)]*\)|;.*")
#: Motion that stays in force.
_MOTION = {"G0", "G1", "G2", "G3"}
#: Offset of an arc's centre across the plane, by the code of the plane.
_ACROSS = {"G17": "K", "G18": "J", "G19": "I"}
#: Order of the words of a line; others stand before F.
_ORDER = "XYZABCUVWIJKRPQLHDT?F"
#: Ends of a program; another operation may follow.
_ENDS = {"M2", "M02", "M30"}


def commands(text: str) -> list[Any]:
    """Returns a LinuxCNC program as `Path.Command` objects; F in mm/s, as paths have it."""
    import Path

    found, motion = [], "G1"
    for line in text.splitlines():
        for comment in _COMMENT.findall(line):
            # FreeCAD itself joins blanks when it reads a path.
            text_of = " ".join(comment.strip("();").split())
            found += [Path.Command(f"({text_of})")] if text_of else []
        words = _WORD.findall(_COMMENT.sub("", line).upper())
        codes = [letter + _tidy(value) for letter, value in words if letter in "GM"]
        values = {letter: float(value) for letter, value in words if letter not in "GMN"}
        if "F" in values:
            values["F"] /= 60.0
        moves = [code for code in codes if code in _MOTION]
        motion = moves[-1] if moves else motion
        others = sorted((code for code in codes if code not in _MOTION), key=lambda code: code == "G53")
        places = {letter for letter in values if letter in "XYZABC"}
        for code in others:
            # Paths are in mm: FreeCAD drops G21 when it reads them again.
            if code == "G21":
                continue
            # T and S belong to M6 and M3, H to G43, P to G64.
            own = {letter: values.pop(letter) for letter in _OWN.get(code, "") if letter in values}
            found.append(Path.Command(code, own))
        if places and "G53" in others:
            # One command a line: the motion first, which stays in force, then its place in machine coordinates.
            found[-1:] = [Path.Command(motion), Path.Command("G53", values)]
        elif places:
            found.append(Path.Command(motion, values))
        elif values and not others:
            found.extend(Path.Command(letter + _tidy(repr(value))) for letter, value in values.items() if letter in "TS")
    return found


_OWN = {"M6": "T", "M3": "S", "M4": "S", "G43": "H", "G64": "PQ", "G4": "P"}


def _tidy(value: str) -> str:
    number = float(value)
    return str(int(number)) if number == int(number) else f"{number:g}"


class Place(NamedTuple):
    """Where a line of a program comes from: operation, number of its command, the tip before and after the move [mm]."""

    operation: str
    command: int
    start: tuple[float, float, float]
    tip: tuple[float, float, float]


@dataclass
class Program:
    """A program of the operations of a job, for LinuxCNC.

    Attributes:
        lines: the text.
        places: for each line, from 1, where it comes from; None for what is added.
        tools: controllers by tool number.
    """

    lines: list[str] = field(default_factory=list)
    places: list[Place | None] = field(default_factory=list)
    tools: dict[int, Any] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """The program."""
        return "\n".join(self.lines) + "\n"

    def place(self, line: int) -> Place | None:
        """Returns where a line comes from, or where the next one before it does."""
        for index in range(min(line, len(self.places)) - 1, -1, -1):
            if self.places[index] is not None:
                return self.places[index]
        return None

    def add(self, line: str, place: Place | None = None) -> None:
        """Adds a line."""
        self.lines.append(line)
        self.places.append(place)


def program_of(operations: list[Any]) -> Program:
    """Returns the program of active operations, one after the other."""
    program = Program()
    program.add("G21 G90 G94 G17 G40 G49 G80 G54")
    in_spindle: Any = None
    cuts = 0
    for operation in operations:
        base = compat.base_operation(operation)
        if not getattr(base, "Active", True) or not operation.Path.Commands:
            continue
        controller = getattr(base, "ToolController", None)
        if controller is None:
            continue
        number = _register(program, controller)
        own_head = any(command.Name in ("M6", "M06") for command in operation.Path.Commands)
        program.add(f"({_comment(operation.Label)})")
        if not own_head:
            for line in _change(in_spindle, controller):
                program.add(line)
        in_spindle = controller
        cuts += _add(program, operation)
    if not cuts:
        raise Problem(
            translated("no active operation of the job moves a tool"), translated("recompute the operations, and look for their messages")
        )
    program.add("M5")
    program.add("M2")
    return program


def _comment(text: str) -> str:
    return re.sub(r"[()\r\n]", " ", text)


def _register(program: Program, controller: Any) -> int:
    """Notes the controller of a tool number, and returns the number; raises Problem if it stands for two tools."""
    number = int(controller.ToolNumber)
    known = program.tools.setdefault(number, controller)
    if known.Name != controller.Name and compat.bit_size(known.Tool) != compat.bit_size(controller.Tool):
        raise Problem(
            translated("{first} and {second} are different tools with the number {number}", first=known.Label, second=controller.Label, number=number),
            translated("give each tool a number of its own in its tool controller"),
        )
    return number


def _change(before: Any, controller: Any) -> Iterator[str]:
    """Yields the lines between operations of two controllers; `before` is None for the first."""
    number = int(controller.ToolNumber)
    turn = "M4" if str(controller.SpindleDir) == "Reverse" else "M3"
    spindle = f"S{float(controller.SpindleSpeed):g} {turn}"
    if before is None or int(before.ToolNumber) != number:
        yield f"T{number} M6"
        yield spindle
        yield f"G43 H{number}"
    elif before.Name != controller.Name:
        # Another speed of the same tool.
        yield spindle


def _add(program: Program, operation: Any) -> int:
    """Adds the commands of an operation, and returns how many of them move."""
    tip, moves, plane = [0.0, 0.0, 0.0], 0, "G17"
    for index, command in enumerate(operation.Path.Commands):
        if command.Name.startswith("("):
            program.add(f"({_comment(command.Name.strip('()'))})")
            continue
        if command.Name in _ENDS:
            continue
        plane = command.Name if command.Name in _ACROSS else plane
        values = dict(command.Parameters)
        if not values.get(_ACROSS[plane]):
            # FreeCAD states it with every arc, where it says nothing; controls refuse it.
            values.pop(_ACROSS[plane], None)
        start = (tip[0], tip[1], tip[2])
        for slot, letter in enumerate("XYZ"):
            tip[slot] = values.get(letter, tip[slot])
        moves += bool(set(values) & set("XYZABC"))
        if "F" in values:
            # Paths have mm/s; a move without feed says 0.
            values["F"] *= 60.0
            if values["F"] <= 0 or command.Name in ("G0", "G00"):
                del values["F"]
        letters = sorted(values, key=lambda letter: (_ORDER.find(letter) % len(_ORDER), letter))
        words = [command.Name, *(letter + number(values[letter]) for letter in letters)]
        program.add(" ".join(words), Place(operation.Name, index, start, (tip[0], tip[1], tip[2])))
    return moves


def number(value: float) -> str:
    """Returns a number as programs write it, to a millionth."""
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text
