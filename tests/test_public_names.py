"""The package's own names: listed once, importable, described, and cheap to have."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path
from typing import Annotated, get_origin

import pytest

import mcsim
from mcsim import _MODULES, _WHERE
from mcsim.adding import KINDS

SOURCE = Path(mcsim.__file__)


def functions():
    return [name for name in _WHERE if inspect.isfunction(getattr(mcsim, name))]


def sections(name):
    """What a docstring in numpy's style says of a function, by heading."""
    lines = inspect.getdoc(getattr(mcsim, name)).splitlines()
    heads = [i - 1 for i, line in enumerate(lines) if line and not line.strip("-")]
    ends = [*heads[1:], len(lines)]
    return {lines[i]: lines[i + 2 : j] for i, j in zip(heads, ends, strict=True)}


def test_the_lists_of_names_are_one():
    errors = {name for name, kind in vars(mcsim.errors).items() if inspect.isclass(kind)}
    assert set(mcsim.__all__) == {*_WHERE, *_MODULES, *errors, "__version__"}
    assert mcsim.__all__ == sorted(mcsim.__all__, key=lambda name: (name[0].islower(), name))
    assert dir(mcsim) == sorted(mcsim.__all__)
    assert not _WHERE.keys() & _MODULES.keys()


def test_type_checkers_see_every_name():
    """They read the imports that never run; each from where the name comes from at run time."""
    guarded = next(node for node in ast.parse(SOURCE.read_text()).body if isinstance(node, ast.If))
    seen = {alias.name: node.module for node in guarded.body for alias in node.names}
    modules = {name: where.rpartition(".")[0] for name, where in _MODULES.items()}
    assert seen == _WHERE | modules


@pytest.mark.parametrize("name", mcsim.__all__)
def test_a_name_is_described(name):
    value = getattr(mcsim, name)
    listed = mcsim.__doc__.partition("Public names\n---")[2]
    if name != "__version__":
        assert f"``{name}" in listed
    if inspect.isclass(value) or inspect.ismodule(value) or inspect.isfunction(value):
        assert len(vars(value)["__doc__"] if inspect.isclass(value) else value.__doc__) > 30
    else:
        assert name == "__version__" or get_origin(value) is Annotated


#: Functions of what is valid already.
REFUSE_NOTHING = {"two_sided", "without_words"}


@pytest.mark.parametrize("name", functions())
def test_a_function_says_what_it_takes_gives_and_refuses(name):
    function, found = getattr(mcsim, name), sections(name)
    signature = inspect.signature(function)
    said = "\n".join(line for line in found["Parameters"] if not line.startswith(" "))
    words = said.replace(",", " ").replace("*", " ").split()
    assert set(signature.parameters) <= set(words)
    gives = signature.return_annotation not in ("None", None)
    assert ("Returns" in found) == gives
    assert all(found.values())
    raised = [line for line in found.get("Raises", ()) if line and not line.startswith(" ")]
    assert bool(raised) != (name in REFUSE_NOTHING)
    assert all(issubclass(getattr(mcsim, error), mcsim.McsimError) for error in raised)


def test_types_of_parts_say_their_fields():
    for kind in [*KINDS, "SensorKey", "Computed", "Setting", "Report", "IdleKey", "Results"]:
        made = getattr(mcsim, kind)
        said = inspect.getdoc(made)
        missing = [n for n in made.__dataclass_fields__ if n[0] != "_" and n not in said]
        assert not missing, kind


def test_the_package_alone_imports_nothing_heavy():
    code = (
        "import sys, mcsim; dir(mcsim);"
        "print({'numpy', 'numba', 'scipy', 'pandas', 'matplotlib', 'pydantic', 'click'}"
        " & sys.modules.keys())"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout == "set()\n"


def test_what_is_no_name_is_said():
    with pytest.raises(AttributeError, match="module 'mcsim' has no attribute 'rum'"):
        mcsim.rum  # noqa: B018
