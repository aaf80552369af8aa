"""What a compiled kernel depends on: its own sources and those it imports, and no others."""

import ast
import shutil
from pathlib import Path

import pytest

from mcsim.kernels import compilation
from mcsim.kernels.compilation import source_digest

FOLDER = Path(compilation.__file__).parent


@pytest.fixture
def kernels(tmp_path):
    """A copy of the kernels' sources."""
    return Path(shutil.copytree(FOLDER, tmp_path / "kernels", ignore=lambda *_: {"__pycache__"}))


def digests(folder):
    source_digest.cache_clear()
    return {path.stem: source_digest(path) for path in folder.glob("*.py")}


@pytest.mark.parametrize(
    ("leaf", "stale", "fresh"),
    [
        ("rotation", {"rotation", "planar", "strapdown"}, {"frame", "allan", "random"}),
        ("strapdown_steps", {"strapdown_steps", "strapdown_system", "strapdown"}, {"planar"}),
        ("random", {"random", "lanes", "frame", "planar"}, {"innovations", "allan"}),
        ("allan", {"allan"}, {"frame", "planar", "random", "strapdown"}),
        ("compilation", {"allan", "frame", "innovations", "random"}, {"__init__"}),
    ],
)
def test_an_edit_makes_stale_what_imports_the_module(kernels, leaf, stale, fresh):
    before = digests(kernels)
    source = kernels / f"{leaf}.py"
    source.write_text(source.read_text() + "\n# edited\n")
    after = digests(kernels)
    changed = {name for name in before if before[name] != after[name]}
    assert stale <= changed
    assert not fresh & changed


def test_a_system_s_kernel_covers_the_modules_that_fill_it_in(kernels):
    """The frame imports no system: what fills in its parts is named beside it."""
    frame, planar = kernels / "frame.py", kernels / "planar.py"

    def both():
        source_digest.cache_clear()
        return source_digest(frame), source_digest(frame, planar)

    alone, together = both()
    planar.write_text(planar.read_text() + "\n# edited\n")
    assert both()[0] == alone
    assert both()[1] != together


def _imported_from(node):
    if isinstance(node, ast.ImportFrom):
        return node.module
    return " ".join(a.name for a in node.names) if isinstance(node, ast.Import) else ""


def test_imports_stand_at_the_top(kernels):
    """Where they are looked for; a kernel module that imports elsewhere would go stale unseen."""
    for path in kernels.glob("*.py"):
        tree = ast.parse(path.read_text())
        anywhere = [n for n in ast.walk(tree) if "mcsim.kernels" in _imported_from(n)]
        assert all(node in tree.body for node in anywhere)
        first = [
            i for i, n in enumerate(tree.body) if isinstance(n, ast.FunctionDef | ast.ClassDef)
        ]
        last = [i for i, n in enumerate(tree.body) if n in anywhere]
        assert not first or not last or last[-1] < first[0]


def test_sources_outside_the_kernels_count_themselves_and_what_they_import(tmp_path):
    own = tmp_path / "own.py"
    own.write_text("from mcsim.kernels import lanes as l\nimport mcsim.kernels.allan\nimport os\n")
    names = {path.name for path in compilation.sources_of(own)}
    assert {"own.py", "lanes.py", "allan.py", "random.py", "compilation.py"} == names
