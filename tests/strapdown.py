"""Scenarios of the strapdown case, and its kernel without a scenario around it."""

from __future__ import annotations

import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mcsim import Scenario
from mcsim.kernels import strapdown as kernel
from mcsim.systems import problem_of
from mcsim.systems.strapdown.undisturbed import integrated
from mcsim.units import STANDARD_GRAVITY
from tests.conftest import ALL_ERRORS, BASE

#: A body that answers accelerations, on a road that slopes both ways.
LEANING = {
    "body.roll.gradient": "0.3 °/(m/s²)",
    "body.pitch.gradient": "0.2 °/(m/s²)",
    "body.bank": "3 °",
    "body.grade": "4 °",
}
EVERYTHING = {
    **ALL_ERRORS,
    **LEANING,
    "trajectory.deceleration": "1 m/s^2",
    "initial.heading_error": "0.2 °",
    "initial.course_error": "0.3 °",
    "initial.roll_error": "0.1 °",
    "initial.pitch_error": "0.2 °",
}
#: Constants of the channels' offsets and of their noise at sample 0.
OFFSETS = [0, 1, 2, 12, 13, 14]
FIRST = [8, 9, 10, 20, 21, 22]
RULES = ("rectangular", "forward_euler", "trapezoidal", "two_sample")
#: The three channels and their constants that the planar case does not have.
SPATIAL_CHANNELS = slice(3, 6)


def scenario(overrides: dict[str, Any] | None = None) -> Scenario:
    """The planar base scenario in space, with some values replaced."""
    tree = copy.deepcopy(BASE) | {"case": "strapdown"}
    return Scenario.from_dict(tree, "base", overrides=overrides or {})


def problem(overrides: dict[str, Any] | None = None, folder: Path = Path()):
    """The problem of that scenario."""
    return problem_of(scenario(overrides).base, folder)


def constants_of(p):
    """Standard deviations (24,) of what the kernel draws once per realization."""
    return p.deviations(p.measurement, disturbed=True)


def with_errors(p, white, deviations):
    """The same problem with other deviations of noise (6,) and of constants (24,)."""
    initial = np.where(np.isin(np.arange(24), OFFSETS + FIRST), 0.0, deviations)
    errors = replace(
        p.sensor_errors,
        white=white,
        constants={"miscalibration": deviations[OFFSETS]},
    )
    return replace(p, sensor_errors=errors, initial_deviations=initial)


def run_kernel(signals, initial, interval, rule, share=0.5, gravity=STANDARD_GRAVITY):
    """States (9, n + 1) that ideal samples (n + 1, 6) are integrated to."""
    rows = signals if rule != "forward_euler" else np.concatenate([signals[:1], signals[:-1]])
    return integrated(kernel.Motion(*initial), rows, rule, interval, share, gravity)
