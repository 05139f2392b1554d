#!/usr/bin/env python3
"""Plants faults in a program one at a time, and prints how `trunnion check` finds them.

plant.py TRUNNION JOB PROGRAM [--only NAME] [--more OPTION]... [--verbose]

PROGRAM is a LinuxCNC or g93 program of the job that passes. Every kind of fault is planted in up to three blocks of the passes; a
fault counts as found if the check ends with exit 1 or 2. It is found at its line if a failure names a changed line or a neighbour
of one, and found elsewhere if only other lines, or none, are named.
"""

import argparse
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

VERDICTS = ("at its line", "elsewhere", "missed")
WORD = r"{}(-?\d+\.?\d*)"


def shifted(line, letter, by):
    """The line with one word changed by `by`, or None without such a word."""
    found = re.search(WORD.format(letter), line)
    if not found:
        return None
    value = float(found.group(1)) + by
    return line[: found.start()] + f"{letter}{value:.4f}" + line[found.end():]


def scaled(line, letter, by):
    found = re.search(WORD.format(letter), line)
    if not found:
        return None
    return line[: found.start()] + f"{letter}{float(found.group(1)) * by:.4f}" + line[found.end():]


def swapped_digits(line):
    """Two neighbouring digits of X exchanged."""
    found = re.search(r"X-?(\d)(\d)", line)
    if not found or found.group(1) == found.group(2):
        return None
    a, b = found.span(1)[0], found.span(2)[0]
    return line[:a] + line[b] + line[a] + line[b + 1:]


def blocks(lines):
    """Numbers of feed blocks in the first half of each pass: behind it the tool may already lead off."""
    heads = [i for i, line in enumerate(lines) if line.startswith("(pass")] + [len(lines)]
    for head, end in zip(heads, heads[1:]):
        for i in range(head + 4, (head + end) // 2):
            if re.match(r"G1 .*B-?\d.*C-?\d.*F", lines[i]):
                yield i


def on_lines(lines, change, chosen):
    for i in chosen:
        new = change(lines[i])
        if new is not None and new != lines[i]:
            yield i, lines[:i] + [new] + lines[i + 1:]


def everywhere(lines, pattern, by):
    new = [re.sub(pattern, by, line) for line in lines]
    if new != lines:
        yield 0, new


def faults(lines, rng):
    chosen = rng.sample(list(blocks(lines)), 12)
    head = next(i for i, line in enumerate(lines) if line.startswith("S"))
    def some(change, most=3):
        return list(on_lines(lines, change, chosen))[:most]
    def insert(text, where):
        return [(i, lines[:i] + [text] + lines[i:]) for i in where]
    def whole(pattern, by):
        return list(everywhere(lines, pattern, by))
    passes = [i for i, line in enumerate(lines) if line.startswith("(pass")]
    yield "block 0.02 mm lower", some(lambda l: shifted(l, "Z", -0.02))
    yield "block 0.1 mm higher", some(lambda l: shifted(l, "Z", 0.1))
    yield "X of a block 0.1 mm aside", some(lambda l: shifted(l, "X", 0.1))
    yield "sign of X", some(lambda l: scaled(l, "X", -1.0))
    yield "sign of Z", some(lambda l: scaled(l, "Z", -1.0))
    yield "sign of B in a block", some(lambda l: scaled(l, "B", -1.0))
    yield "sign of B everywhere", whole(r"B-?(\d)", r"B-\1")
    yield "sign of C everywhere", [(0, [re.sub(r"C(-?)(\d)", lambda m: ("C" if m[1] else "C-") + m[2], l) for l in lines])]
    yield "B 0.5 deg more", some(lambda l: shifted(l, "B", 0.5))
    yield "C 0.5 deg more", some(lambda l: shifted(l, "C", 0.5))
    yield "two digits of X exchanged", some(swapped_digits)
    yield "decimal point of Z lost", some(lambda l: re.sub(r"Z(-?\d+)\.(\d)", r"Z\1\2", l))
    yield "inches", whole(r"^G21", "G20")
    yield "incremental", whole(r"\bG90\b", "G91")
    yield "work offset 2", whole(r"\bG54\b", "G55")
    yield "G92 in front of the cuts", insert("G92 X0.1", [passes[0]])
    yield "G52-like shift by G10 L2", insert("G10 L2 P1 X-380.9", [head])
    yield "no tool length", whole(r"^G43 H1$", "")
    yield "another length word", whole(r"^G43 H1$", "G43 H2")
    yield "length off in a cut", insert("G49", [chosen[0]])
    yield "another tool", whole(r"^T1 M6", "T2 M6")
    yield "no tool call", whole(r"^T1 M6$", "")
    yield "spindle never starts", whole(r" M3$", "")
    yield "spindle turns the other way", whole(r" M3$", " M4")
    yield "spindle stops in a cut", insert("M5", [chosen[1]])
    yield "no speed", whole(r"^S\d+ M3", "M3")
    yield "coolant never on", whole(r"^M8$", "")
    yield "coolant off in a cut", insert("M9", [chosen[2]])
    yield "smoothing of 1 mm", whole(r"^G64.*", "G64 P1")
    yield "smoothing without bound", whole(r"^G64.*", "G64")
    yield "TCP never on", whole(r"^M428$", "")
    switched = any(line == "M428" for line in lines)
    yield "TCP off in a cut", insert("M429", [chosen[3]]) if switched else []
    yield "TCP on in a cut", [] if switched else insert("M428", [chosen[3]])
    yield "rapid in a cut", some(lambda l: re.sub(r"^G1", "G0", re.sub(r" F\S+", "", l)))
    # One block of many hardly moves the tool off its path, and one written twice does not at all: several are a fault.
    yield "blocks exchanged", [(i, lines[:i] + [lines[i + 1], lines[i]] + lines[i + 2:]) for i in chosen[:3] if re.match(r"G1", lines[i + 1])]
    yield "ten blocks deleted", [(i, lines[:i] + lines[i + 10:]) for i in chosen[:3]]
    yield "pass deleted", [(passes[3], lines[:passes[3]] + lines[passes[4]:])]
    yield "F a thousand times", whole(r"F(\d+\.?\d*)", lambda m: f"F{float(m[1]) * 1000:.3f}")
    yield "F a thousandth", whole(r"F(\d+\.?\d*)", lambda m: f"F{float(m[1]) / 1000:.6f}")
    yield "F of a block ten times", some(lambda l: scaled(l, "F", 10.0))
    yield "no F", whole(r" F\S+", "")
    last = max(i for i, line in enumerate(lines) if line.startswith("(pass"))
    yield "cut at the end", [(chosen[4], lines[: last + 8] + ["M5", "M9", "M2"])]
    yield "no end", whole(r"^M2$|^M30$", "")
    yield "arc plane and an arc", some(lambda l: re.sub(r"^G1", "G2", l) + " I0.1 J0")
    yield "block skipped", some(lambda l: "/" + l, 1)
    yield "file cut off", [(chosen[5], lines[:chosen[5]])]
    yield "X and Y exchanged everywhere", [(0, [re.sub(r"X(\S+) Y(\S+)", r"X\2 Y\1", l) for l in lines])]
    yield "all Z 0.03 mm higher", [(0, [shifted(l, "Z", 0.03) or l if re.match(r"G1", l) else l for l in lines])]
    yield "all Z 0.01 mm lower", [(0, [shifted(l, "Z", -0.01) or l if re.match(r"G1", l) else l for l in lines])]


def changed(lines, text, planted):
    """Numbers of the lines that differ, and of their neighbours; of what was put in or left out, the border."""
    if len(lines) == len(text):
        own = [i + 1 for i, (old, new) in enumerate(zip(lines, text)) if old != new]
    else:
        own = [planted + 1]
    return {line + by for line in own for by in (-1, 0, 1)}


def named(done):
    """Numbers of the lines that failures and errors name."""
    text = done.stdout + done.stderr
    told = [line for line in text.splitlines() if line.startswith(("broken:", "error:"))]
    return {int(n) for line in told for pair in re.findall(r"lines? (\d+)|\.ngc:(\d+)", line) for n in pair if n}, told


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("trunnion")
    parser.add_argument("job")
    parser.add_argument("program")
    parser.add_argument("--only", default="")
    parser.add_argument("--more", action="append", default=[])
    parser.add_argument("--verbose", action="store_true")
    args = parser.parse_args()
    lines = Path(args.program).read_text().splitlines()
    job = Path(args.job).resolve()
    counts = dict.fromkeys(VERDICTS, 0)
    with tempfile.TemporaryDirectory() as folder:
        def check(text):
            path = Path(folder) / "planted.ngc"
            path.write_text("\n".join(text) + "\n")
            command = [args.trunnion, "check", str(path), "--job", str(job), "--grid", "0.5", *args.more]
            return subprocess.run(command, cwd=folder, capture_output=True, text=True)
        clean = check(lines)
        if clean.returncode:
            sys.exit(f"the program itself does not pass:\n{clean.stdout}{clean.stderr}")
        for name, planted in faults(lines, random.Random(1)):
            if args.only not in name:
                continue
            if not planted:
                print(f"{'not possible here':18}{name}", flush=True)
            for line, text in planted:
                done = check(text)
                places, told = named(done)
                if done.returncode not in (1, 2):
                    verdict = "missed"
                    told = [w for w in (done.stdout + done.stderr).splitlines() if w.startswith("warning")]
                elif places & changed(lines, text, line):
                    verdict = "at its line"
                else:
                    verdict = "elsewhere"
                counts[verdict] += 1
                if args.verbose or verdict != "at its line":
                    print(f"{verdict:18}{name}, line {line + 1}, exit {done.returncode}: {told[:2]}", flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in counts.items()))
    return counts["missed"] > 0


sys.exit(main())
