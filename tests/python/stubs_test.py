# SPDX-License-Identifier: Apache-2.0
"""The stub of the compiled module says what the module has; every public name has a docstring with
the unit that its name promises; mypy --strict accepts the package and a program that uses it."""
import ast
import inspect
import pathlib
import re
import subprocess
import sys

import sarblock
from sarblock import _core

PACKAGE = pathlib.Path(sarblock.__file__).parent
STUB = ast.parse((PACKAGE / "_core.pyi").read_text(encoding="utf-8"))
UNITS = {"m": "[m]", "s": "[s]", "m2": "[m2]", "rad": "[rad]", "hz": "[Hz]"}
#: Plain functions and classes whose arguments have the units.
PUBLIC = [getattr(sarblock, name) for name in sarblock.__all__ if not name.startswith("_")]


def arguments_of(function):
    """Names of the arguments as pybind11 writes them into the docstring."""
    first = function.__doc__.splitlines()[0]
    inner = first[first.index("(") + 1 : first.rindex(") ->")]
    return re.findall(r"(?:^|, )(\w+)(?=:)", re.sub(r"\[[^\[\]]*\]", "", re.sub(r"\[[^\[\]]*\]", "", inner)))


def stubbed(nodes):
    return {node.name: node for node in nodes if isinstance(node, (ast.FunctionDef, ast.ClassDef))}


def test_the_stub_has_every_name_of_the_module_and_no_other():
    names = {name for name in dir(_core) if not name.startswith("_")}
    assert set(stubbed(STUB.body)) == names


def test_the_stub_has_the_arguments_of_every_function():
    for name, node in stubbed(STUB.body).items():
        if isinstance(node, ast.FunctionDef):
            assert [one.arg for one in node.args.args] == arguments_of(getattr(_core, name)), name


def test_the_stub_has_the_members_of_every_class():
    for name in ("Block", "Result"):
        real = {one for one in vars(getattr(_core, name)) if not one.startswith("_")}
        nodes = stubbed(stubbed(STUB.body)[name].body)
        assert set(nodes) == real, name
        for member, node in nodes.items():
            attribute = vars(getattr(_core, name))[member]
            is_property = any(getattr(one, "id", "") == "property" for one in node.decorator_list)
            assert is_property == isinstance(attribute, property), member
            if not is_property:
                assert [one.arg for one in node.args.args] == arguments_of(attribute), member


def classes():
    modules = [module for name, module in sys.modules.items() if name.startswith("sarblock.") and module is not _core]
    for module in modules:
        for name, value in vars(module).items():
            if inspect.isclass(value) and value.__module__ == module.__name__ and not name.startswith("_"):
                yield value


def test_every_public_member_has_a_docstring_with_its_unit():
    tested = 0
    for one in classes():
        if issubclass(one, tuple):
            continue
        for name, member in vars(one).items():
            if name.startswith("_"):
                continue
            text = inspect.getdoc(member)
            assert text, f"{one.__name__}.{name}"
            unit = UNITS.get(name.rsplit("_", 1)[-1]) if "_" in name else None
            if unit is not None and not name.startswith("to_"):
                # "The same of ..." has the unit of the line before.
                assert unit in text or text.startswith("The same"), f"{one.__name__}.{name}: no {unit}"
                tested += 1
    assert tested > 30


def test_every_public_function_has_a_docstring():
    for value in [*PUBLIC, *(v for n, v in vars(sarblock.leberl).items() if inspect.isfunction(v) and n[0] != "_")]:
        assert inspect.getdoc(value), value


def mypy(*arguments):
    return subprocess.run(
        ["/usr/bin/mypy", "--strict", "--cache-dir", "/dev/null", "--python-executable", sys.executable, *map(str, arguments)],
        capture_output=True, text=True, check=False, env={"MYPYPATH": str(PACKAGE.parent), "PATH": "/usr/bin:/bin"},
    )


def test_mypy_accepts_the_package_and_a_program():
    ended = mypy("-p", "sarblock")
    assert ended.returncode == 0, ended.stdout
    ended = mypy(pathlib.Path(__file__).parent / "sample_program.py")
    assert ended.returncode == 0, ended.stdout


def test_mypy_refuses_a_program_that_mistakes_a_type(tmp_path):
    (tmp_path / "wrong.py").write_text(
        "import sarblock\nblock = sarblock.read_block('b')\nname: int = block.name\nsarblock.adjust('b')\n",
        encoding="utf-8",
    )
    ended = mypy(tmp_path / "wrong.py")
    assert ended.returncode == 1
    assert ended.stdout.count("error:") == 2, ended.stdout
