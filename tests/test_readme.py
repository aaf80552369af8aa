"""What the README lists by hand is what there is."""

import re
from pathlib import Path

import pytest

import mcsim
from mcsim.cli.commands import COMMANDS
from mcsim.papers import TABLES
from mcsim.sensor_terms import TERMS
from mcsim.tracks import TRACKS
from mcsim.vibration.excitations import EXCITATIONS

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
_KEY = re.compile(r"([a-z_]+)(?:: \{([a-z_, ]+)\})?")


def part(begins, ends):
    """The text from one phrase to the next."""
    return TEXT.partition(begins)[2].partition(ends)[0]


def keys(text):
    """Dotted keys of all code in a text: ``spikes: {rate, amplitude}`` are two."""
    found = set()
    for code in re.findall(r"`([^`]+)`", text):
        key, inner = _KEY.fullmatch(code).groups()
        found |= {f"{key}.{name}" for name in inner.split(", ")} if inner else {key}
    return found


@pytest.mark.parametrize(
    ("begins", "ends"),
    [
        ("| term | key |\n|---|---|\n", "\n\n"),
        ("each a built-in sensor's name\nor any of ", "; one value"),
    ],
)
def test_both_lists_of_sensor_keys_are_the_terms(begins, ends):
    elements = ("accelerometer", "gyroscope")
    there_are = {key for term in TERMS.values() for e in elements for key, _ in term.paths(e)}
    assert keys(part(begins, ends)) == there_are


def test_lists_of_shapes_are_complete():
    assert set(re.findall(r"`(\w+)`", part("| `trajectory` | `shape`: ", "; with"))) == set(TRACKS)
    said = part("A scenario is an excitation (`shape`: ", ") seen by")
    assert set(re.findall(r"`(\w+)`", said)) == set(EXCITATIONS)


def test_every_command_and_table_has_a_row():
    rows = part("| command | does |\n|---|---|\n", "\n\n")
    told = re.findall(r"`mcsim (\w+)(?: ([\w-]+))?", rows)
    assert {command for command, _ in told} == set(COMMANDS)
    assert {name for command, name in told if command == "table"} == set(TABLES)


def test_names_and_files_exist():
    for name in re.findall(r"mcsim\.([A-Za-z_]+)\b(?!\.)", TEXT):
        assert name in mcsim.__all__ or (ROOT / "mcsim" / name).is_dir(), name
    for link in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert link.startswith("http") or (ROOT / link).exists(), link


def test_the_table_of_rooms_names_folders_and_files():
    rows = part("| | rooms in `mcsim/`, in the order of the street |\n|---|---|\n", "\n\n")
    rooms = set(re.findall(r"`(\w+)`", rows)) - {"mechanisms"}
    assert {r for r in rooms if not list((ROOT / "mcsim").glob(f"{r}*"))} == set()
    folders = {p.name for p in (ROOT / "mcsim").iterdir() if (p / "__init__.py").exists()}
    assert folders <= rooms


def test_citation_and_changelog_name_this_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {mcsim.__version__}\n" in citation
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    latest = next(line for line in changes.splitlines() if line.startswith("## "))
    assert latest.split()[1] == mcsim.__version__
    assert latest.split()[-1] in citation
