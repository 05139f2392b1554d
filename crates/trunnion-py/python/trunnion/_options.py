"""Keywords of a call as options of the command line, and its messages in the words of Python."""

from __future__ import annotations

import functools
import math
import operator
import os
import re
import sys
from collections.abc import Mapping

from ._errors import ArgumentError, InputError, TrunnionError

# The name alone tells type checkers; the module `typing` would delay every worker.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Callable, Iterable, TypeVar

    _F = TypeVar("_F", bound=Callable[..., Any])

_FLAG = re.compile(r"--([a-z][a-z-]*)")
#: Options that state true or false, and are no switches.
_STATED = ("block_delete",)


class Scratch:
    """Folder for files of one call: made when the first needs it, and removed with them."""

    def __init__(self) -> None:
        self._folder: Any = None

    def __fspath__(self) -> str:
        if self._folder is None:
            import tempfile

            self._folder = tempfile.TemporaryDirectory()
        return str(self._folder.name)

    def holds(self, file: str) -> bool:
        """Returns true for a file in the folder."""
        return self._folder is not None and file.startswith(self._folder.name)

    def __enter__(self) -> "Scratch":
        return self

    def __exit__(self, *error: Any) -> None:
        if self._folder is not None:
            self._folder.cleanup()


def worded(text: str) -> str:
    """Names keywords in place of flags: `--tool-length L` becomes `tool_length`."""
    return _FLAG.sub(lambda found: found[1].replace("-", "_"), text)


def pythonic(function: _F) -> _F:
    """Words the exceptions of a verb with the keywords of its Python function."""

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except ArgumentError:
            raise
        except TrunnionError as error:
            again = type(error)(*map(worded, error.messages))
            raise again.with_traceback(error.__traceback__) from None

    return call  # type: ignore[return-value]


def number(name: str, value: Any) -> str:
    """Returns a finite number as an option."""
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        kind = type(value).__name__
        raise ArgumentError(f"{name} = {kind} is not a number", name, None, value) from None
    if found != found or found in (float("inf"), float("-inf")):
        raise ArgumentError(f"{name} = {found} is not a finite number", name, None, found)
    return repr(found)


def numbers(name: str, value: Any, count: int) -> str:
    """Returns `count` numbers as an option."""
    try:
        entries = [float(entry) for entry in value]
    except (TypeError, ValueError, OverflowError):
        kind = type(value).__name__
        raise ArgumentError(f"{name} = {kind} is not {count} numbers", name, None, kind) from None
    if len(entries) != count:
        shape = (len(entries),)
        raise ArgumentError(f"{name} = shape {shape} is not {(count,)}", name, None, shape)
    for index, entry in enumerate(entries):
        if entry != entry or entry in (float("inf"), float("-inf")):
            message = f"{name}[{index}] = {entry} is not a finite number"
            raise ArgumentError(message, name, (index,), entry)
    return ",".join(map(repr, entries))


def whole(name: str, value: Any, least: int = 0) -> int:
    """Returns a whole number, `least` or more, that fits in memory as an index."""
    try:
        found = operator.index(value)
    except TypeError:
        found = None
    if found is None or isinstance(value, bool) or not least <= found <= sys.maxsize:
        shown = type(value).__name__ if found is None or found > sys.maxsize else repr(value)
        raise ArgumentError(f"{name} = {shown} is not a whole number from {least} to {sys.maxsize}", name, None, value)
    return found


def truth(name: str, value: Any) -> bool:
    """Returns True or False, also those of numpy."""
    of_numpy = getattr(getattr(value, "dtype", None), "kind", "") == "b" and value.ndim == 0
    if isinstance(value, bool) or of_numpy:
        return bool(value)
    kind = type(value).__name__
    raise ArgumentError(f"{name} = {kind} is neither True nor False", name, None, value)


def word(name: str, value: Any) -> str:
    """Returns a text of one line as it is; the engine knows which there are."""
    if isinstance(value, str) and value.isprintable():
        return value
    shown = repr(value) if isinstance(value, str) else type(value).__name__
    raise ArgumentError(f"{name} = {shown} is not a word", name, None, value)


def radians(name: str, value: Any, deg: Any) -> float:
    """Returns an angle in radians."""
    angle = float(number(name, value))
    return math.radians(angle) if truth("deg", deg) else angle


def angles(name: str, value: Any, count: int, deg: bool) -> str:
    """Returns angles as an option, which is in degrees."""
    text = numbers(name, value, count)
    if deg:
        return text
    return ",".join(repr(math.degrees(float(entry))) for entry in text.split(","))


def mapping(name: str, value: Any, what: str) -> Mapping[Any, Any]:
    """Returns a mapping as it is, and refuses everything else; `what` it should hold stands in the message."""
    if isinstance(value, Mapping):
        return value
    kind = type(value).__name__
    raise ArgumentError(f"{name} = {kind} is no dict of {what}", name, None, kind)


def sequence(name: str, value: Any, what: str) -> list[Any]:
    """Returns the entries of a list, tuple, array or the like, and refuses everything else."""
    if not isinstance(value, (str, bytes, bytearray, Mapping)):
        try:
            return list(value)
        except TypeError:
            pass
    kind = type(value).__name__
    raise ArgumentError(f"{name} = {kind} is no list of {what}", name, None, kind)


def choice(name: str, value: Any, known: tuple[str, ...]) -> str:
    """Returns one of several words."""
    if isinstance(value, str) and value in known:
        return value
    shown = repr(value) if isinstance(value, str) else type(value).__name__
    raise ArgumentError(f"{name} = {shown} is not one of {', '.join(known)}", name, None, shown)


def instance(name: str, value: Any, kind: type, remedy: str) -> Any:
    """Returns an object of a class of the package."""
    if isinstance(value, kind):
        return value
    given = type(value).__name__
    message = f"{name} = {given} is no {kind.__name__}\n  help: {remedy}"
    raise ArgumentError(message, name, None, given)


def as_cutter(value: Any) -> Any:
    """Returns a Cutter."""
    from ._trunnion import Cutter

    return instance("cutter", value, Cutter, "make one: trunnion.Cutter.ball(10)")


def faces_option(value: Any) -> list[str]:
    """Returns numbers of faces as an option; none without numbers."""
    numbers = [number(f"faces[{index}]", one) for index, one in enumerate(sequence("faces", value, "numbers of faces"))]
    for index, one in enumerate(numbers):
        if not float(one).is_integer():
            raise ArgumentError(f"faces[{index}] = {one} is no whole number", "faces", (index,), one)
    return ["--faces=" + ",".join(str(int(float(one))) for one in numbers)] if numbers else []


def path(name: str, value: Any) -> str:
    """Returns a path as an option."""
    try:
        found = os.fspath(value)
    except TypeError:
        kind = type(value).__name__
        raise ArgumentError(f"{name} = {kind} is not a path", name, None, kind) from None
    found = os.fsdecode(found)
    # Bytes that are no UTF-8 came as surrogates.
    if "\0" in found or not found or any("\ud800" <= one <= "\udfff" for one in found):
        raise ArgumentError(f"{name} = {found!r} is not a path in UTF-8", name, None, found)
    # A path that begins with a minus would be taken for an option.
    return os.path.join(os.curdir, found) if found.startswith("-") else found


def as_machine(machine: Any) -> Any:
    """Returns the Machine of a dict; a Machine, a name and a path as they are."""
    from ._trunnion import Machine

    return Machine(machine) if isinstance(machine, Mapping) else machine


def machine_file(machine: Any, folder: Scratch | str) -> str:
    """Returns name or file of a machine as an option; a Machine that no file has is written into the folder."""
    from ._trunnion import Machine

    machine = as_machine(machine)
    if not isinstance(machine, Machine):
        return path("machine", machine)
    try:
        if _text_of(machine.source) == machine.to_toml():
            return str(machine.source)
    except InputError:
        # It was made from a dict, imported or calibrated.
        pass
    name = os.path.join(folder, "machine.toml")
    with open(name, "w", encoding="utf-8") as out:
        out.write(machine_text(machine))
    return name


def _text_of(source: str) -> str:
    """Returns the text of a built-in machine or of a machine file."""
    from ._trunnion import Machine, built_in

    # Reading a machine takes a tenth of a short check, and a file may have changed since.
    return _built_in_text(source) if source in built_in() else Machine(source).to_toml()


@functools.cache
def _built_in_text(name: str) -> str:
    from ._trunnion import Machine

    return Machine(name).to_toml()


def machine_text(machine: Any) -> str:
    """Returns the file of a Machine for any folder: the solids of its bodies are named by their whole path."""
    from . import _trunnion

    text: str = machine.to_toml()
    data = _trunnion.toml_data(text)
    solids = [body for body in data.get("body", []) if "file" in body]
    if not solids:
        return text
    for body in solids:
        body["file"] = os.path.abspath(os.path.join(os.path.dirname(machine.source), body["file"]))
    return str(_trunnion.toml_text(data))


def stated(name: str, value: Any) -> str:
    """Returns a text, number or path as it stands in an option; the engine knows what it should be."""
    plain = isinstance(value, (str, int, float, os.PathLike)) or getattr(value, "ndim", None) == 0
    text = ""
    try:
        if plain:
            text = os.fsdecode(value) if isinstance(value, os.PathLike) else str(value)
    except ValueError:
        # Python refuses to write numbers of thousands of digits.
        plain = False
    if plain and "\0" not in text and not any("\ud800" <= one <= "\udfff" for one in text):
        return text
    shown = repr(text) if isinstance(value, str) else type(value).__name__
    raise ArgumentError(f"{name} = {shown} is no number and no text in UTF-8", name, None, value)


def write(file: str, text: str) -> None:
    """Writes a text file."""
    try:
        with open(file, "w", encoding="utf-8") as out:
            out.write(text)
    except OSError as error:
        raise InputError(f"{file}: {error.strerror}\n  help: choose another file or folder") from None


def per_tool(name: str, value: Any, one: Callable[[str, Any], str]) -> list[str]:
    """Returns a value, or one for each tool number, as repeated options."""
    flag = "--" + name.replace("_", "-")
    if isinstance(value, Mapping):
        return [f"{flag}={stated(name, number)}={one(name, each)}" for number, each in value.items()]
    return [f"{flag}={one(name, value)}"]


def cutter_words(value: Any) -> str:
    """Returns a cutter as the option `R=10,r=6,L=120`."""
    if isinstance(value, str):
        return word("cutter", value)
    cutter = as_cutter(value)
    sides = (("taper", cutter.taper_angle(deg=True) or None), ("barrel", cutter.barrel_radius), ("corner", cutter.corner_radius))
    stated = [f"{name}={value!r}" for name, value in sides if value is not None]
    if stated:
        words = ",".join([f"r={cutter.minor_radius!r}", f"D={2 * cutter.radius!r}", *stated, f"L={cutter.length!r}"])
    else:
        words = f"R={cutter.major_radius!r},r={cutter.minor_radius!r},L={cutter.length!r}"
    return words if cutter.inner is None else f"{words},inner={cutter.inner!r}"


def shank_words(cutter: Any) -> str:
    """Returns the profile above the cutting part as an option; empty without one."""
    if isinstance(cutter, str):
        return ""
    return ",".join(f"{height!r}:{radius!r}" for height, radius in cutter.shank.tolist())


def others(verb: str, known: Iterable[str], extra: Mapping[str, Any], function: Any = None) -> list[str]:
    """Returns further keywords of a verb as options: True is a switch, a list a repeated option.

    A slip of a keyword that `function` has in its signature ends up here as well, and is recognised.
    """
    words: list[str] = []
    for name, value in extra.items():
        if name not in known:
            import difflib
            import inspect

            named = inspect.signature(function).parameters if function is not None else ()
            near = difflib.get_close_matches(name, [*known, *named], 1)
            remedy = f"did you mean {near[0]}?" if near else "known are " + ", ".join(sorted(known))
            raise InputError(f"{verb} has no keyword {name}\n  help: {remedy}")
        flag = "--" + name.replace("_", "-")
        for one in value if isinstance(value, (list, tuple)) else [value]:
            if name in _STATED and isinstance(one, bool):
                words.append(f"{flag}={str(one).lower()}")
            elif one is True:
                words.append(flag)
            elif one is not None and one is not False:
                words.append(f"{flag}={stated(name, one)}")
    return words


def as_file(argument: str, value: Any, suffix: str, folder: Scratch) -> str:
    """Returns the path of a file, or of a temporary one with the bytes given."""
    if isinstance(value, (bytes, bytearray, memoryview)):
        if os.sep in word("suffix", suffix):
            raise ArgumentError(f"suffix = {suffix!r} is no ending of a file\n  help: write suffix=\".cls\"", "suffix", None, suffix)
        name = os.path.join(folder, "content" + suffix)
        try:
            with open(name, "wb") as out:
                out.write(value)
        except OSError as error:
            raise ArgumentError(f"suffix = {suffix!r} is no ending of a file: {error.strerror}", "suffix", None, suffix) from None
        return name
    return path(argument, value)
