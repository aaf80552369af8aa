"""Shapes, statistics, excitations from outside, by public names: from YAML to table and picture."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.special import ellipe

import mcsim
from mcsim.cli.main import exit_code
from mcsim.cli.own import run_own
from mcsim.statistics import STATISTICS
from mcsim.systems import problem_of
from mcsim.tracks import TRACKS
from mcsim.vibration.excitations import EXCITATIONS

EXAMPLE = Path(__file__).parent.parent / "docs" / "examples" / "winding_road.py"
SCENARIO = EXAMPLE.with_suffix(".yaml")
KNOCK = """
from typing import Literal
import numpy as np
import mcsim

class Knock(mcsim.ExcitationBlock):
    shape: Literal["knock"]
    amplitude: mcsim.fields.Acceleration

def acceleration(block, time, duration):
    return block.amplitude * (time < 0.5 * duration)

mcsim.add(mcsim.Excitation("knock", Knock, acceleration))
"""
KNOCKED = """
case: vibration
title: A knock
sensor: MPU-9250
rate: 740 Hz
duration: 4 s
excitation: {shape: knock, amplitude: 3 m/s²}
"""


@pytest.fixture(autouse=True)
def _forget():
    yield
    for parts, name in ((TRACKS, "winding"), (STATISTICS, "magnitude"), (EXCITATIONS, "knock")):
        if name in parts:
            parts.remove(name)


def test_a_winding_road_is_as_long_as_its_closed_form():
    """Arc length of a sine: a complete elliptic integral of the second kind per wave."""
    run_own(EXAMPLE)
    scenario = mcsim.Scenario.from_yaml(SCENARIO).with_values({"sweep": None})
    p = problem_of(scenario.base, scenario.folder)
    slope = 2.0 * np.pi / 60.0 * 2.0
    length = 2 * 60.0 * 2.0 / np.pi * np.sqrt(1.0 + slope**2) * ellipe(slope**2 / (1 + slope**2))
    lead = 20.0 * 0.1
    assert p.n_samples * p.interval == pytest.approx((length + 2 * lead) / 20.0, abs=p.interval)
    # Whole waves: the end lies straight ahead, and at the turning points the course is along.
    truth = p.truth
    assert truth.across[-1] == pytest.approx(0.0, abs=1e-9)
    assert truth.along[-1] - truth.along[0] == pytest.approx(120.0 + 2 * lead, abs=0.2)
    assert truth.across.max() == pytest.approx(4.0, abs=1e-3)


@pytest.mark.slow
def test_a_track_and_a_statistic_run_from_a_scenario_to_table_and_picture(tmp_path):
    few = ["--realizations", "500", "--set", "trajectory.wavelength=30 m"]
    out = ["--output", str(tmp_path), "--quiet", *few]
    assert exit_code(["run", str(SCENARIO), "--with", str(EXAMPLE), *out]) == 0
    folder = tmp_path / "winding_road"
    assert (folder / "figure.png").stat().st_size > 10_000
    table = pd.read_csv(folder / "table.csv").query("error == 'heading'")
    values = table.pivot_table("value", list(table.columns[:2]), "statistic")
    assert len(values) == 10
    # Of normal errors without a mean, within five standard errors.
    ratio = values["magnitude"] / (np.sqrt(2.0 / np.pi) * values["rms"])
    assert np.abs(ratio - 1.0).max() < 5 * np.sqrt(np.pi / 2 - 1) / np.sqrt(500)
    assert "winding" in str(mcsim.schema())


@pytest.mark.slow
def test_an_excitation_runs_from_a_scenario_to_table_and_picture(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("own.py").write_text(KNOCK, encoding="utf-8")
    Path("case.yaml").write_text(KNOCKED, encoding="utf-8")
    command = ["--with", "own.py", "vibration", "case.yaml", "--output", "out", "--quiet"]
    assert exit_code(command) == 0
    folder = next(Path("out").rglob("table.csv")).parent
    assert (folder / "figure.png").stat().st_size > 10_000
    assert json.loads((folder / "provenance.json").read_text())["command"] == "vibration"
    log = pd.read_csv(folder / "log.csv")
    half = len(log) // 2
    fall = log.iloc[:half].mean(numeric_only=True) - log.iloc[half:].mean(numeric_only=True)
    assert np.abs(fall.iloc[1:]).max() == pytest.approx(3.0, abs=0.05)
    assert "knock" in str(mcsim.schema("vibration"))
