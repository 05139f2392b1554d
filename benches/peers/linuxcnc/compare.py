#!/usr/bin/env python3
"""Compares every program of a folder as trunnion reads it with what LinuxCNC's interpreter makes of it.

compare.py FOLDER --peer PEER [--trunnion CLI] [--sub-dir FOLDER]... [-o RESULT.json] [--only TEXT] [--verbose]

PEER is the program of this folder (`cargo build --release`). LinuxCNC's interpreter `rs274` has to be installed; without it
nothing is compared and the script says so. See README.md for what is compared and what the verdicts mean.
"""
import argparse, collections, json, math, os, re, shutil, subprocess, sys, tempfile

CALL = re.compile(r"^\s*\d+ N[.\d]*\s*([A-Z][A-Z_0-9]*)\((.*)\)\s*$")
PLANES = {"XY": (0, 1, 2), "YZ": (1, 2, 0), "XZ": (2, 0, 1)}


class Machine:
    """Axis positions behind canonical calls, from zero, in mm; `slack` is what the digits of arcs hide."""

    def __init__(self):
        self.at, self.g5x, self.g92, self.tool = [0.0] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3
        self.turn, self.unit, self.plane, self.moves, self.splines = 0.0, 1.0, PLANES["XY"], [], 0
        self.slack = 1e-4
        self.probes = 0

    def axes(self, words):
        x, y, z = (word * self.unit + shift for word, shift in zip(words, self.g92))
        cos, sin = math.cos(self.turn), math.sin(self.turn)
        turned = [x * cos - y * sin, x * sin + y * cos, z]
        return [a + b + c for a, b, c in zip(turned, self.g5x, self.tool)]

    def words(self):
        x, y, z = (a - b - c for a, b, c in zip(self.at, self.g5x, self.tool))
        cos, sin = math.cos(self.turn), math.sin(self.turn)
        return [a - b for a, b in zip([x * cos + y * sin, -x * sin + y * cos, z], self.g92)]

    def go(self, kind, to, length=None):
        length = math.dist(self.at, to) if length is None else length
        if length > 1e-9:
            self.moves.append((kind, to, length))
        self.at = to

    def arc(self, values):
        u, v, w = self.plane
        start, end = self.words(), [0.0] * 3
        end[u], end[v], end[w] = values[0], values[1], values[5]
        center, rotation = (values[2] * self.unit, values[3] * self.unit), int(values[4])
        a0 = math.atan2(start[v] - center[1], start[u] - center[0])
        a1 = math.atan2(end[v] * self.unit - center[1], end[u] * self.unit - center[0])
        # Where the radii at both ends differ, the control runs a spiral from one to the other.
        radius = 0.5 * (math.hypot(end[u] * self.unit - center[0], end[v] * self.unit - center[1])
                        + math.hypot(start[u] - center[0], start[v] - center[1]))
        sweep = (a1 - a0) if rotation > 0 else (a0 - a1)
        sweep %= 2 * math.pi
        # Ends are given to four digits: less than that is a whole turn.
        if sweep * radius < 1.5e-4 * self.unit:
            sweep += 2 * math.pi
        sweep += 2 * math.pi * (abs(rotation) - 1)
        # The listing has four digits: start, centre and end are off by half of the last one each.
        self.slack += 1.5e-4 * self.unit * abs(sweep)
        along = end[w] * self.unit - start[w]
        self.go("cut", self.axes(end), math.hypot(radius * sweep, along))

    def take(self, name, text):
        numbers = [float(n) for n in re.findall(r"-?\d+\.?\d*", text)]
        if name == "USE_LENGTH_UNITS":
            self.unit = 25.4 if "INCH" in text else 1.0
        elif name == "SELECT_PLANE":
            self.plane = PLANES[re.search(r"_(XY|YZ|XZ)", text).group(1)]
        elif name == "SET_G5X_OFFSET":
            self.g5x = [n * self.unit for n in numbers[1:4]]
        elif name == "SET_G92_OFFSET":
            self.g92 = [n * self.unit for n in numbers[:3]]
        elif name == "SET_XY_ROTATION":
            self.turn = math.radians(numbers[0])
        elif name == "USE_TOOL_LENGTH_OFFSET":
            self.tool = [n * self.unit for n in numbers[:3]]
        elif name == "STRAIGHT_TRAVERSE":
            self.go("rapid", self.axes(numbers[:3]))
        elif name == "STRAIGHT_FEED":
            self.go("cut", self.axes(numbers[:3]))
        elif name == "RIGID_TAP":
            back = self.at
            self.go("cut", self.axes(numbers[:3]))
            self.go("cut", back)
        elif name == "ARC_FEED":
            self.arc(numbers)
        elif name == "NURBS_FEED":
            self.splines += 1
        elif name == "STRAIGHT_PROBE":
            self.probes += 1
            self.go("cut", self.axes(numbers[:3]))


def run(command, cwd, seconds):
    """Exit code, text and errors; the code is None behind the time limit."""
    def text(data):
        return (data or b"").decode("utf-8", "replace")
    try:
        done = subprocess.run(command, cwd=cwd, capture_output=True, timeout=seconds, stdin=subprocess.DEVNULL)
        return done.returncode, text(done.stdout), text(done.stderr)
    except subprocess.TimeoutExpired as late:
        return None, text(late.stdout), text(late.stderr)


def interpreter(program, scene, seconds):
    command = ["rs274", "-g", "-i", scene["ini"], "-v", scene["var"], "-t", scene["table"], program]
    for name in (scene["var"], scene["var"] + ".bak"):
        if os.path.exists(name):
            os.remove(name)
    code, out, errors = run(command, scene["cwd"], seconds)
    # Codes of the machine's own (M100 to M199) are programs of the control, which the interpreter alone does not have: go on.
    if re.search(r"^Unknown m code used: M1\d\d", errors, re.M):
        code, out, errors = run(command[:1] + ["-n", "0"] + command[1:], scene["cwd"], seconds)
        errors = re.sub(r"^Unknown m code used: M1\d\d\n.*\n", "", errors, flags=re.M)
    machine = Machine()
    for line in out.splitlines():
        call = CALL.match(line)
        if call:
            machine.take(call.group(1), call.group(2))
    errors = [line for line in errors.splitlines() if line.strip() and not line.startswith(("executing", "link (updating"))]
    ended = "PROGRAM_END" in out
    return code, machine, errors, ended


def letters(text):
    text = re.sub(r"\([^)]*\)|;.*", "", text.upper())
    used = [a for a in "ABC" if re.search(a + r"\s*[-+0-9.#\[]", text)]
    return "XYZ" + "".join((used + [a for a in "ACB" if a not in used])[:2])


def reading(peer, program, scene, seconds):
    if not os.path.isfile(program):
        return 0, [], []
    with open(program, "rb") as file:
        text = file.read().decode("utf-8", "replace")
    command = [peer, program, letters(text), "--tools", scene["table"], "25.4", "--ini", scene["ini"]]
    for folder in scene["folders"]:
        command += ["--sub-dir", folder]
    command += ["--block-delete", "true"]
    code, out, errors = run(command, scene["cwd"], seconds)
    moves = []
    for line in out.splitlines():
        kind, x, y, z, length, _ = line.split()
        moves.append((kind, [float(x), float(y), float(z)], float(length)))
    return code, moves, errors.splitlines()


def lengths(moves):
    return [sum(length for kind, _, length in moves if kind == which) for which in ("cut", "rapid")]


def scene_of(program, work, extra):
    """Configuration and tool table: those that the folder's own test gives to the interpreter, or plain ones."""
    folder = os.path.dirname(program)
    script = os.path.join(folder, "test.sh")
    script = open(script).read() if os.path.exists(script) else ""
    def named(flag, ending):
        found = re.search(flag + r"\s+(\S+" + ending + ")", script) if "rs274" in script else None
        path = found and os.path.join(folder, found.group(1))
        return path if path and os.path.exists(path) else None
    ini, table = named("-i", ".ini"), named("-t", ".tbl")
    if not table:
        table = os.path.join(work, "plain.tbl")
        with open(table, "w") as file:
            for number in range(1, 300):
                file.write(f"T{number} P{number} Z0 D0.25\n")
    folders = [folder] + extra
    if not ini:
        ini = os.path.join(work, "plain.ini")
        with open(ini, "w") as file:
            # Codes that switch kinematics are remapped to a subprogram without motion.
            remaps = "".join(f"REMAP = M{code} modalgroup=10 ngc=nothing\n" for code in (428, 429, 430, 438, 439))
            with open(os.path.join(work, "nothing.ngc"), "w") as sub:
                sub.write("o<nothing> sub\no<nothing> endsub\nM2\n")
            file.write(f"[RS274NGC]\nPARAMETER_FILE = {work}/plain.var\nSUBROUTINE_PATH = {':'.join([work] + folders)}\n{remaps}"
                       "[TRAJ]\nCOORDINATES = X Y Z A B C U V W\nLINEAR_UNITS = mm\nANGULAR_UNITS = degree\n")
    return {"cwd": folder, "ini": ini, "table": table, "folders": folders, "var": os.path.join(work, "run.var")}


def verdict(theirs, ours):
    code, machine, errors, ended = theirs
    our_code, moves, our_errors = ours
    if our_code is None:
        return ("both endless" if code is None else "over a minute"), ""
    if our_code not in (0, 2):
        return "panic", " / ".join(our_errors[:2])
    # A file of subprograms alone has no end; the interpreter says so behind the last move.
    unended = bool(errors) and errors[0].startswith("File ended with no percent sign")
    failed = code is None or (bool(errors) and not unended)
    if our_code == 2:
        kind = "refused by both" if failed or unended else "refused"
        return kind, our_errors[0] if our_errors else "?"
    if failed and code is None:
        return "only theirs endless", ""
    if failed:
        return "refused by theirs only", " / ".join(errors[:2])
    if machine.splines:
        return "splines", ""
    a, b = lengths(machine.moves), lengths(moves)
    slack = 1e-4 * machine.unit * 2 * len(machine.moves) ** 0.5 + machine.slack
    place = next((k for k, (one, two) in enumerate(zip(machine.moves, moves))
                  if one[0] != two[0] or max(abs(p - q) for p, q in zip(one[1], two[1])) > 0.006
                  or abs(one[2] - two[2]) > 0.01 + 1e-4 * one[2]), None)
    same = all(abs(p - q) <= slack + 1e-6 * p for p, q in zip(a, b))
    note = f"cut {a[0]:.3f} {b[0]:.3f} rapid {a[1]:.3f} {b[1]:.3f}"
    if place is not None or len(machine.moves) != len(moves):
        note += f"; moves {len(machine.moves)} {len(moves)}"
        if place is not None:
            note += f", first other at {place + 1}: {machine.moves[place]} {moves[place]}"
    # The stand-alone interpreter draws a probe 0.01 inch back from the end that it was given.
    if not same and machine.probes:
        return "probes", note
    return ("same" if same else "different"), note


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--peer", required=True)
    parser.add_argument("--trunnion")
    parser.add_argument("--sub-dir", action="append", default=[])
    parser.add_argument("-o", "--output")
    parser.add_argument("--only", default="")
    parser.add_argument("--verbose", action="store_true")
    args = parser.parse_args()
    if not shutil.which("rs274"):
        print("rs274 is not installed: nothing compared")
        return 0
    extra = [os.path.abspath(folder) for folder in args.sub_dir]
    peer = os.path.abspath(args.peer)
    programs = sorted(os.path.join(top, name) for top, _, names in os.walk(os.path.abspath(args.folder)) for name in names
                      if name.lower().endswith((".ngc", ".nc")))
    programs = [program for program in programs if args.only in program and os.path.isfile(program)]
    results = []
    with tempfile.TemporaryDirectory() as work:
        for program in programs:
            scene = scene_of(program, work, extra)
            theirs = interpreter(program, scene, 20)
            ours = reading(peer, program, scene, 60)
            kind, note = verdict(theirs, ours)
            name = os.path.relpath(program, args.folder)
            results.append({"program": name, "verdict": kind, "note": note, "moves": len(ours[1]), "theirs": theirs[2][:2]})
            if args.verbose or kind not in ("same", "refused by both"):
                print(f"{kind:24}{name}: {note}", flush=True)
    print()
    for kind, count in collections.Counter(result["verdict"] for result in results).most_common():
        print(f"{count:5}  {kind}")
    if args.output:
        with open(args.output, "w") as file:
            json.dump(results, file, indent=1)
    return 0


sys.exit(main())
