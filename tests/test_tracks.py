"""What holds of every shape of track, and of one that is added from outside."""

from __future__ import annotations

import copy
from typing import Any, Literal

import jsonschema
import numpy as np
import pytest

import mcsim
from mcsim import Scenario, run
from mcsim.errors import InputError
from mcsim.scenario.fields import Length
from mcsim.scenario.paths import find_scalar, scalars
from mcsim.scenario_file.schema import scenario_schema
from mcsim.systems import notes_of
from mcsim.systems.planar.scenario import PlanarScenario
from mcsim.tracks import TRACKS, drive_of
from mcsim.trajectory.curves import ClothoidCurve
from tests.conftest import BASE, BASE_YAML, scenario

#: One of each shape; those that may need it are given with all their keys.
EXAMPLES: dict[str, dict[str, Any]] = {
    "straight": {"length": "30 m", "speed": "10 m/s"},
    "half_cosine": {"length": "50 m", "width": "5 m", "speed": "20 m/s", "side_slip": "0.05 rad"},
    "quintic": {"length": "50 m", "width": "-5 m", "speed": "20 m/s", "deceleration": "2 m/s^2"},
    "nonic": {"length": "50 m", "width": "5 m", "speed": "20 m/s"},
    "double_lane_change": {"length": "30 m", "width": "3 m", "gap": "10 m", "speed": "15 m/s"},
    "curve": {"radius": "40 m", "angle": "2 rad", "clothoid": "15 m", "speed": "12 m/s"},
    "waypoints": {
        "points": [["3 m", "1 m"], ["20 m", "8 m"], ["40 m", "5 m"], ["60 m", "20 m"]],
        "speed": "8 m/s",
    },
    "recorded": {
        "file": "drive.csv",
        "columns": {"time": "t in s", "x": "x in m", "y": "y in m"},
        "duration": "15 s",
    },
}


@pytest.fixture
def folder(tmp_path):
    """Holds the recorded drive: an S at a speed that changes."""
    t = np.arange(0.0, 20.0, 0.1)
    rows = [f"{a:.1f},{8 * a + np.sin(a / 3):.6f},{4 * np.sin(a / 4):.6f}" for a in t]
    (tmp_path / "drive.csv").write_text("\n".join(["t,x,y", *rows]) + "\n")
    return tmp_path


def planar(name: str, folder: Any = ".", **more: Any) -> Scenario:
    """The base scenario on a track of that shape."""
    tree = copy.deepcopy(BASE) | {"trajectory": {"shape": name, **EXAMPLES[name]}, **more}
    return Scenario.from_dict(tree, folder=folder)


def leaves(tree: Any, path: str) -> dict[str, Any]:
    """The scalars of a tree by their paths."""
    items = tree.items() if isinstance(tree, dict) else enumerate(tree)
    found: dict[str, Any] = {}
    for key, value in items:
        below = f"{path}.{key}"
        found |= leaves(value, below) if isinstance(value, dict | list) else {below: value}
    return found


def test_every_shape_has_an_example():
    assert list(EXAMPLES) == list(TRACKS)


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_block_reads_back_from_what_it_writes(name):
    base = planar(name).base
    assert type(base.trajectory) is TRACKS[name].block
    written = base.model_dump(mode="json", exclude_none=True)
    assert Scenario.from_dict(written).base == base
    assert Scenario.from_dict(written).base.trajectory.shape == name


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_scalar_of_a_block_can_be_swept_and_set(name):
    base = planar(name).base
    written = base.model_dump(mode="json", exclude_none=True)["trajectory"]
    for path, value in leaves(written, "trajectory").items():
        assert find_scalar(PlanarScenario, path) is not None, path
        swept = planar(name, sweep={path: [value]})
        assert swept.points[0].model.trajectory == base.trajectory, path
        assert planar(name).with_values({path: value}).base == base, path


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_schema_knows_every_shape_and_its_keys(name):
    validator = jsonschema.Draft7Validator(scenario_schema())
    tree = copy.deepcopy(planar(name).document.tree)
    assert not list(validator.iter_errors(tree))
    tree["trajectory"]["lenhgt"] = "3 m"
    assert list(validator.iter_errors(tree))


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_unknown_key_is_told_with_those_of_the_shape_alone(name, scenario_file):
    keys = "".join(f", {key}: {value}" for key, value in EXAMPLES[name].items() if key != "lead")
    line = f"trajectory: {{shape: {name}{keys}, ledd: 1 s}}".replace("'", '"')
    text = "\n".join(line if "trajectory:" in old else old for old in BASE_YAML.splitlines())
    with pytest.raises(InputError) as told:
        Scenario.from_yaml(scenario_file(text))
    known = ", ".join(TRACKS[name].block.model_fields)
    assert str(told.value).endswith(
        f'case.yaml:2: trajectory.ledd: unknown key "ledd"; did you mean "lead"? '
        f"(known here: {known})"
    )


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_missing_key_is_told(name):
    needed = {k for k, f in TRACKS[name].block.model_fields.items() if f.is_required()} - {"shape"}
    assert needed
    for key in needed:
        tree = copy.deepcopy(planar(name).document.tree)
        del tree["trajectory"][key]
        with pytest.raises(InputError, match=rf"trajectory\.{key}: is missing"):
            Scenario.from_dict(tree)


@pytest.mark.parametrize("name", EXAMPLES)
def test_position_and_heading_are_continuous_and_have_the_stated_derivatives(name, folder):
    drive = drive_of(planar(name).base.trajectory, folder)
    t = np.linspace(-drive.lead, drive.end, 4001)
    step = t[1] - t[0]
    motion = drive.motion(t)
    moved = np.hypot(np.diff(motion.along), np.diff(motion.across))
    assert moved.max() <= 1.01 * motion.speed.max() * step
    # Heading may turn by side-slip alone where the manoeuvre begins or ends: not in these.
    assert np.abs(np.diff(motion.heading)).max() <= 1.01 * np.abs(motion.yaw_rate).max() * step
    away = np.min(
        np.abs(t[:, None] - [0.0, *drive.manoeuvre.jumps, drive.manoeuvre.duration]), axis=1
    )
    inner = t[(away > 1e-3) & (t > t[0]) & (t < t[-1])]
    h = 1e-4
    before, here, after = drive.motion(inner - h), drive.motion(inner), drive.motion(inner + h)
    for name_, rate in (
        ("along", here.velocity_along),
        ("across", here.velocity_across),
        ("heading", here.yaw_rate),
    ):
        slope = (getattr(after, name_) - getattr(before, name_)) / (2.0 * h)
        np.testing.assert_allclose(slope, rate, atol=1e-4)


class Spiral(mcsim.DrivenTrackBlock):
    """A clothoid in and out, written by a user."""

    shape: Literal["spiral"]
    size: Length
    """Length of each half."""
    tightest: Length = 40.0
    """Radius in the middle."""


def _spiral(block: Spiral) -> ClothoidCurve:
    return ClothoidCurve(block.tightest, block.size / block.tightest, block.size)


SPIRAL = BASE_YAML.replace(
    "{shape: half_cosine, length: 50 m, width: 5 m, speed: 20 m/s, deceleration: 0 m/s^2}",
    "{shape: spiral, size: 30 m, speed: 15 m/s}",
).replace("sensors.gyroscope.noise_density: [", "trajectory.size: [20 m, 30 m] # ")


@pytest.fixture
def spiral():
    """A shape that is added, and taken off the list afterwards."""
    mcsim.add(mcsim.Track("spiral", Spiral, mcsim.along(_spiral)))
    yield
    TRACKS.remove("spiral")


@pytest.mark.usefixtures("spiral")
def test_a_shape_from_outside_runs_from_a_scenario_to_its_table(scenario_file):
    scenario = Scenario.from_yaml(scenario_file(SPIRAL))
    results = run(scenario.with_values({"monte_carlo.realizations": 50}))
    assert set(results.table["trajectory.size [m]"]) == {20.0, 30.0}
    assert np.isfinite(results.table["value"]).all()
    end = drive_of(scenario.base.trajectory, scenario.folder).motion(np.array([10.0]))
    assert end.course[0] == pytest.approx(30.0 / 40.0)


@pytest.mark.usefixtures("spiral")
def test_a_shape_from_outside_is_in_schema_paths_and_messages(scenario_file):
    assert "trajectory.tightest" in scalars(PlanarScenario)
    tree = Scenario.from_yaml(scenario_file(SPIRAL)).document.tree
    jsonschema.Draft7Validator(scenario_schema()).validate(tree)
    with pytest.raises(InputError, match=r':2: trajectory\.shape: "spirall" .* mean "spiral"'):
        Scenario.from_yaml(scenario_file(SPIRAL.replace("shape: spiral", "shape: spirall")))
    with pytest.raises(InputError, match=r":2: trajectory\.size: is missing; write for example"):
        Scenario.from_yaml(scenario_file(SPIRAL.replace("size: 30 m, ", "").split("sweep:")[0]))


def test_a_shape_that_was_taken_away_is_unknown(scenario_file):
    assert "trajectory.tightest" not in scalars(PlanarScenario)
    with pytest.raises(InputError, match=r'"spiral" is not a shape of track \(known: straight'):
        Scenario.from_yaml(scenario_file(SPIRAL.split("sweep:")[0]))


def test_a_shape_whose_block_has_another_name_is_refused():
    with pytest.raises(InputError, match=r'Spiral must say `shape: Literal\["helix"\]`'):
        mcsim.add(mcsim.Track("helix", Spiral, mcsim.along(_spiral)))
    assert "helix" not in TRACKS


@pytest.mark.parametrize(
    ("lead", "rate", "said"),
    [("0 s", "60 Hz", False), ("0 s", "64 Hz", False), ("0 s", "63 Hz", True),
     ("0.1 s", "63 Hz", False), ("10 ms", "63 Hz", True)],
)  # fmt: skip
def test_a_drive_that_ends_between_two_samples_says_so(lead, rate, said):
    """A straight of 2.5 s: 157.5 intervals at 63 Hz; a lead of one interval holds a sample."""
    block = {"shape": "straight", "length": "50 m", "speed": "20 m/s", "lead": lead}
    s = scenario({"trajectory": block, "sensors.rate": rate})
    notes = notes_of(s.base, s.folder)
    assert len(notes) == said
    assert all("ends between two samples" in note for note in notes)
