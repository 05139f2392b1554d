"""Examples of docstrings and documents run; stubs say what the module has."""

import doctest
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys

import pytest

import trunnion

MODULES = ["trunnion", *(f"trunnion.{one.name}" for one in pkgutil.iter_modules(trunnion.__path__))]


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_docstrings(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if name in ("trunnion.plot", "trunnion._figure"):
        pytest.importorskip("matplotlib")
    module = importlib.import_module(name)
    finder = doctest.DocTestFinder(exclude_empty=True)
    native = [trunnion.Machine, trunnion.Part, trunnion.Face, trunnion.Cutter] if name == "trunnion._trunnion" else []
    tests = finder.find(module, name)
    for kind in native:
        tests += [
            test
            for attribute in [kind, *vars(kind).values()]
            for test in finder.find(getattr(attribute, "__func__", attribute), getattr(attribute, "__name__", "class"))
            if test.examples
        ]
    runner = doctest.DocTestRunner(optionflags=doctest.IGNORE_EXCEPTION_DETAIL | doctest.ELLIPSIS)
    for test in {test.name + test.docstring: test for test in tests}.values():
        runner.run(test)
    assert runner.failures == 0, f"{runner.failures} examples say something else"


def public():
    for name in trunnion.__all__:
        thing = getattr(trunnion, name)
        if name not in ("__version__", "fleet", "plot"):
            yield name, thing
    for kind in (trunnion.Machine, trunnion.Part, trunnion.Face, trunnion.Cutter):
        for name, thing in vars(kind).items():
            if not name.startswith("_"):
                yield f"{kind.__name__}.{name}", thing


@pytest.mark.parametrize("name, thing", list(public()))
def test_everything_public_is_documented(name, thing):
    assert (thing.__doc__ or "").strip(), name


#: Methods that results share, and those of a run, which takes too long for an example.
_ALIKE = {"to_dict", "to_pandas", "save", "sample", "limits"}


def callables():
    named = [(name, getattr(trunnion, name)) for name in trunnion.__all__ if name not in ("__version__", "fleet", "plot")]
    for module in (trunnion.fleet, trunnion.plot):
        named += [(f"{module.__name__}.{name}", getattr(module, name)) for name in module.__all__]
    for name, thing in named:
        if not isinstance(thing, type):
            yield name, thing
        elif not issubclass(thing, Exception):
            methods = [(one, getattr(thing, one)) for one in vars(thing) if not one.startswith("_")]
            yield from ((f"{name}.{one}", method) for one, method in methods if callable(method))


def test_every_function_has_an_example():
    bare = [name for name, thing in callables() if ">>>" not in (inspect.getdoc(thing) or "")]
    assert not [name for name in bare if name.rpartition(".")[2] not in _ALIKE]
    assert len(list(callables())) > 80


@pytest.mark.parametrize("document", ["README.md", "docs/book/src/reference/python.md", "crates/trunnion-py/README.md"])
def test_lines_of_documents(document, root, tmp_path, monkeypatch):
    text = (root / document).read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    assert blocks, document
    monkeypatch.chdir(root)
    space = {"__name__": "document"}
    for block in blocks:
        exec(compile(block, document, "exec"), space)


def test_stubs_say_what_the_module_has(tmp_path):
    pytest.importorskip("mypy.stubtest")
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "trunnion._trunnion", "--ignore-disjoint-bases"],
        capture_output=True, text=True, cwd=tmp_path,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_is_typed(tmp_path):
    pytest.importorskip("mypy")
    script = tmp_path / "script.py"
    script.write_text(
        "import trunnion\n"
        "machine = trunnion.Machine('bc-trunnion', tool_length=120.0)\n"
        "q = machine.inverse([[0, 0, 0]], [[0, 0, 1]])\n"
        "plan = trunnion.plan({'s': [0, 1]}, {'X': (1, 2, 3)}, 'jerk', None)\n"
        "seconds: float = plan.duration + plan.lower_bound\n"
        "length: float = trunnion.read('a.cls').length\n"
    )
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", str(script)], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_name_is_found_where_it_stands():
    """Names that are loaded with their first use: all of them, and nothing else."""
    lazy = [name for names in trunnion._PLACES.values() for name in names]
    native = {"Cutter", "Face", "Machine", "Part", "__version__", "built_in"}
    assert sorted([*lazy, *native, "fleet", "plot"]) == sorted(trunnion.__all__)
    code = "import trunnion; from trunnion import *; print(set(trunnion.__all__) - set(globals()), dir(trunnion))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("set() ") and "'position'" in done.stdout
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        trunnion.nothing


def test_importing_is_quick():
    # numpy is loaded with the first array, not with the package.
    code = "import sys, trunnion; print('numpy' in sys.modules, 'pandas' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.split() == ["False", "False"], done.stderr
