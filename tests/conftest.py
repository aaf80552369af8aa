"""Shared scenarios."""

from __future__ import annotations

import copy
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from mcsim import Scenario, run
from mcsim.sensor_terms import gauss_markov
from mcsim.sensor_terms.bias_instability import flicker
from mcsim.sensor_terms.mechanisms import process
from mcsim.sensor_terms.mechanisms.white import NOISE
from mcsim.sensor_terms.random_walk import walk
from mcsim.systems import problem_of

# The same examples on every machine and in every run; "--hypothesis-profile explore" draws
# others each time.
settings.register_profile("fixed", derandomize=True, deadline=None)
settings.register_profile("explore", deadline=None)
settings.load_profile("fixed")

BASE: dict[str, Any] = {
    "case": "planar",
    "trajectory": {
        "shape": "half_cosine",
        "length": "50 m",
        "width": "5 m",
        "speed": "20 m/s",
        "deceleration": "0 m/s^2",
        "lead": "100 ms",
    },
    "sensors": {
        "rate": "100 Hz",
        "sampling": "fir",
        "accelerometer": {"noise_density": "2.2e-3 m/s^2/√Hz", "miscalibration": "0 m/s^2"},
        "gyroscope": {"noise_density": "3.0e-2 °/s/√Hz", "miscalibration": "0 °/s"},
    },
    "initial": {"speed_error": "0 m/s", "direction_error": "0 °"},
    "monte_carlo": {"realizations": 1000, "seed": 1, "confidence": "3 sigma"},
}
ALL_ERRORS = {
    "sensors.accelerometer.miscalibration": "0.01 m/s^2",
    "sensors.gyroscope.miscalibration": "0.1 °/s",
    "initial.speed_error": "0.01 m/s",
    "initial.direction_error": "0.1 °",
}
NO_NOISE = {
    "sensors.accelerometer.noise_density": "0 m/s^2/√Hz",
    "sensors.gyroscope.noise_density": "0 °/s/√Hz",
}


#: Kernels that a whole run needs, by worker: what one compiles the other would only wait for.
_FIRST = (
    ("strapdown", [{}, {"sensors.time.lost": "1 %"}]),
    ("planar", [{}, {"sensors.time.lost": "1 %"}, {"reconstruction.integration": "cubic"}]),
)


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the shipped kernels side by side, where all tests run on several workers."""
    name = os.environ.get("PYTEST_XDIST_WORKER", "")
    whole = [Path(argument).name for argument in session.config.args] == ["tests"]
    if name in ("gw0", "gw1") and whole:
        case, needed = _FIRST[int(name[2:])]
        for values in needed:
            few = {"monte_carlo.realizations": 2, **values}
            run(Scenario.from_dict({**copy.deepcopy(BASE), "case": case}, "first", overrides=few))


def scenario(overrides: dict[str, Any] | None = None, **more: Any) -> Scenario:
    """The base scenario with some values replaced."""
    return Scenario.from_dict(copy.deepcopy(BASE), "base", overrides={**(overrides or {}), **more})


def density(block) -> float:
    """One-sided white noise density of a sensor block's first axis."""
    return float(block.acts_on(0)[NOISE].density)


def problem(overrides: dict[str, Any] | None = None, folder: Path = Path()):
    """The planar problem of the base scenario with some values replaced."""
    return problem_of(scenario(overrides).base, folder)


def processes_of(
    bias_instability: float,
    random_walk: float,
    drift: float,
    correlation_time: float,
    interval: float,
    duration: float,
) -> process.Processes:
    """Flicker noise, random walk and Gauss-Markov drift of one channel, SI."""
    terms = {
        "bias instability": flicker(bias_instability),
        "Gauss-Markov drift": gauss_markov.drift(drift, correlation_time),
        "random walk": walk(random_walk),
    }
    return process.processes_of(terms, interval, duration)


@pytest.fixture
def scenario_file(tmp_path):
    """Writes a YAML scenario and returns its path."""

    def write(text: str, name: str = "case.yaml") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


BASE_YAML = """\
case: planar
trajectory: {shape: half_cosine, length: 50 m, width: 5 m, speed: 20 m/s, deceleration: 0 m/s^2}
sensors:
  rate: 100 Hz
  sampling: fir
  accelerometer: {noise_density: 2.2e-3 m/s^2/√Hz, miscalibration: 0 m/s^2}
  gyroscope: {noise_density: 3.0e-2 °/s/√Hz, miscalibration: 0 °/s}
initial: {speed_error: 0 m/s, direction_error: 0 °}
monte_carlo: {realizations: 200, seed: 1, confidence: 3 sigma}
sweep:
  sensors.accelerometer.noise_density: [1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]
  sensors.gyroscope.noise_density: [0.03 °/s/√Hz, 0.3 °/s/√Hz]
"""
